// Rongeurs: jaws that close around an edge of bone and bite it off.
#pragma once

#include "sim/module.h"
#include "volume/tool_body.h"

namespace trephine::rongeur {

/// A rongeur's two cups close across its shaft; a Kerrison has a foot that goes under the bone, and a jaw
/// that comes down its shaft.
enum class Kind : std::uint8_t { rongeur, kerrison };

struct Rongeur {
  Kind kind = Kind::rongeur;
  double width = 4;         ///< mm, of the jaws: they are round
  double opening = 6;       ///< mm between them
  double jaw = 1.2;         ///< mm, how thick each of them is
  double most = 60;         ///< mm3 that a hand can bite through at once; more is refused
  double close_time = 0.4;  ///< s of the button held until they are closed, where the device has no squeeze
  static const sim::Schema& schema();
  /// Bone between the open jaws.
  volume::ToolBody bite() const noexcept {
    return volume::ToolBody::cylinder(0.5 * width, opening, 0.1 * width);
  }
};

/// The hand holds a rongeur's throat, ahead of which its cups reach by their width, and the top of a
/// Kerrison's foot. Jaws close by the first axis of the device, where that is above 0 or was, or else while
/// the button is held.
struct RongeurState {
  double closed = 0;                         ///< 0 open to 1
  bool is_done = true, has_squeeze = false;  ///< bitten, or refused: opens first
  static const sim::Schema& schema();
};

/// It bit, at a place.
struct Bite {
  double size = 0;  ///< mm3
  static const sim::Schema& schema();
};
/// It could not close.
struct BiteRefused {
  std::string why;
  static const sim::Schema& schema();
};

sim::Instrument rongeur(const Rongeur& parameters);

class RongeurModule final : public sim::Module {
 public:
  std::string_view name() const noexcept override { return "rongeur"; }
  std::uint32_t version() const noexcept override { return 3; }  // 3: a bite has a largest size
  std::span<const sim::InstrumentType* const> instruments() const override;
  std::span<const sim::ValueType* const> events() const override;
  std::vector<sim::Measure> measures(const sim::OperationState& now) const override;
};

}  // namespace trephine::rongeur
