// Event: an occurrence with its tick and position, kept in the chronicle of its operation.
#pragma once

#include <memory>
#include <vector>

#include "sim/api/value.h"
#include "volume/base/mix_hash.h"

namespace trephine::sim {

struct Event {
  std::uint64_t tick = 0;
  std::uint8_t hand = 0;
  glm::dvec3 position_world{0.0};
  Value value;  ///< a struct with a table of its fields
};

/// Faults that a hand's servo latched or reset.
struct FaultEvent {
  std::string names;  ///< "lost device, ..."
  bool is_cleared = false;
  static const Schema& schema();
};

/// Reason of a discarded job that may be started again.
inline constexpr const char* k_anatomy_changed = "the anatomy changed meanwhile; start it again";
/// The result of a job was discarded, because the state changed too much while the job ran, or because the
/// result could not be applied.
struct JobDiscarded {
  Id job;
  std::string reason;
  static const Schema& schema();
};

/// A step of the procedure began.
struct StepEntered {
  std::string step;
  static const Schema& schema();
};
/// The procedure did not allow a command or a step. A step is not allowed while a hand holds an instrument
/// that the step does not allow, or if commands on entry form a cycle.
struct StepRefused {
  std::string step;     ///< current step
  std::string request;  ///< name of the command, instrument or next step
  std::string reason;
  static const Schema& schema();
};

/// An implant was added. Emitted at its middle.
struct BodyAdded {
  Id body;
  double size = 0;  ///< mm3
  static const Schema& schema();
};
/// A part was detached as a body. Emitted at its middle.
struct PieceFreed {
  Id body;
  double size = 0;  ///< mm3
  static const Schema& schema();
};
/// Parts that are too small for bodies were detached and removed.
struct DebrisFreed {
  std::int64_t count = 0;
  double size = 0;  ///< mm3, total
  static const Schema& schema();
};

/// A measured value, for reports and scores.
struct Measure {
  std::string name;  ///< "removed"
  double value = 0;
  std::string unit;       ///< "mm3"; empty: dimensionless
  bool is_stale = false;  ///< the anatomy or another input changed after the measurement
};

/// All events since the start, and the numbers of undos and redos. Events are only added. Copies share the
/// older events.
class Chronicle {
 public:
  void add(Event event);
  std::size_t size() const noexcept { return k_chunk * full_.size() + newest_.size(); }
  const Event& operator[](std::size_t i) const noexcept {
    return i / k_chunk < full_.size() ? (*full_[i / k_chunk])[i % k_chunk] : newest_[i % k_chunk];
  }
  std::uint64_t undos = 0, redos = 0;
  /// Hash of all events and of the numbers of undos and redos.
  std::uint64_t hash() const noexcept;

 private:
  static constexpr std::size_t k_chunk = 64;
  std::vector<std::shared_ptr<const std::vector<Event>>> full_;
  std::vector<Event> newest_;
  MixHash hash_;
};

/// Adds the length and the bytes of a text, 8 bytes at a time.
void add_bytes(MixHash& hash, std::string_view bytes) noexcept;
/// Adds a value's name and bytes; two empty texts for an empty value.
void add_value(MixHash& hash, const Value& value);

}  // namespace trephine::sim
