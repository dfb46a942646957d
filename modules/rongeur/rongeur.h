// Rongeur: jaws that close around an edge of bone and bite it off.
#pragma once

#include "sim/api/module.h"
#include "volume/cuts/tool_body.h"

namespace trephine::rongeur {

/// The two cups of a rongeur close across its shaft; a Kerrison has a foot that slides below the bone, and a
/// jaw that moves down its shaft.
enum class Kind : std::uint8_t { rongeur, kerrison };

struct Rongeur {
  Kind kind = Kind::rongeur;
  double width = 4;         ///< mm, of the round jaws
  double opening = 12;      ///< mm between the open jaws
  double jaw = 1.2;         ///< mm, thickness of each jaw
  double max_bite = 60;     ///< mm3, largest bite of a hand; larger bites are refused
  double close_time = 0.4;  ///< s until the jaws are closed by the button, for devices without a squeeze
  static const sim::Schema& schema();
  /// Returns the body between the open jaws, which a bite removes.
  volume::ToolBody bite() const noexcept {
    return volume::ToolBody::cylinder(0.5 * width, opening, 0.1 * width);
  }
};

/// State of a rongeur. The hand holds the throat of a rongeur, from which the cups reach ahead by their
/// width, or the top of a Kerrison's foot. Once the first axis of the device was above 0, the jaws follow
/// this axis. Until then, the jaws close while the button is pressed.
struct RongeurState {
  double closed = 0;                         ///< 0 open to 1 closed
  bool is_done = true, has_squeeze = false;  ///< is_done: the jaws must open before the next bite
  static const sim::Schema& schema();
};

/// Emitted at the centre of a bite.
struct Bite {
  double size = 0;  ///< mm3
  static const sim::Schema& schema();
};
/// The jaws could not close. Emitted at the centre of the bite.
struct BiteRefused {
  std::string reason;
  static const sim::Schema& schema();
};

sim::Instrument rongeur(const Rongeur& parameters);

class RongeurModule final : public sim::Module {
 public:
  std::string_view name() const noexcept override { return "rongeur"; }
  std::uint32_t version() const noexcept override { return 4; }  // 4: position of open cups
  std::span<const sim::InstrumentType* const> instruments() const override;
  std::span<const sim::ValueType* const> events() const override;
  std::vector<sim::Measure> measures(const sim::OperationState& operation) const override;
};

}  // namespace trephine::rongeur
