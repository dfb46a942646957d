// Events: emitted with their tick and place, kept for good.
#pragma once

#include <memory>
#include <vector>

#include "sim/value.h"
#include "volume/mix_hash.h"

namespace trephine::sim {

struct Event {
  std::uint64_t tick = 0;
  std::uint8_t hand = 0;
  glm::dvec3 place_world{0.0};
  Value what;
};

/// Faults of the force that a hand's servo latched, or that a person took away again.
struct FaultEvent {
  std::string names;  ///< "lost device, ..."
  bool is_cleared = false;
  static const Schema& schema();
};

/// Why a job was left that may be begun again.
inline constexpr const char* k_world_changed = "the world changed";
/// A job's result was left: the world changed too much under it, or its subject is gone.
struct JobDiscarded {
  Id job;
  std::string why;
  static const Schema& schema();
};

/// A part came off; emitted at its middle.
struct PieceFreed {
  Id body;
  double size = 0;  ///< mm3
  static const Schema& schema();
};
/// Parts came off that are too small for bodies; they are gone.
struct DebrisFreed {
  std::int64_t count = 0;
  double size = 0;  ///< mm3, of all
  static const Schema& schema();
};

/// Something measured: for reports and scores.
struct Measure {
  std::string name;  ///< "removed"
  double value = 0;
  std::string unit;  ///< "mm3"; empty: none
};

/// All events since the start, and how often was undone. Nothing in it is ever taken back. Copies share what
/// is old.
class Chronicle {
 public:
  void add(Event event);
  std::size_t size() const noexcept { return k_chunk * full_.size() + newest_.size(); }
  const Event& operator[](std::size_t i) const noexcept {
    return i / k_chunk < full_.size() ? (*full_[i / k_chunk])[i % k_chunk] : newest_[i % k_chunk];
  }
  std::uint64_t undos = 0, redos = 0;
  /// Hash of all of it.
  std::uint64_t hash() const noexcept;

 private:
  static constexpr std::size_t k_chunk = 64;
  std::vector<std::shared_ptr<const std::vector<Event>>> full_;
  std::vector<Event> newest_;
  volume::MixHash hash_;
};

/// Adds bytes, a word at a time.
void add_bytes(volume::MixHash& hash, std::string_view bytes) noexcept;
/// Adds a value with its name; an empty one counts too.
void add_value(volume::MixHash& hash, const Value& value);

}  // namespace trephine::sim
