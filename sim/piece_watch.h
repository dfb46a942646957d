// Pieces that come off by themselves: after each stroke a driver asks whether it parted something.
#pragma once

#include <optional>

#include "sim/engine.h"
#include "volume/parting.h"

namespace trephine::sim {

/// One thread: that of the engine. What it finds becomes a command, free-pieces, of the operation like any
/// other: a replay needs no watch.
class PieceWatch {
 public:
  /// `smallest`, mm3: smaller parts stay where they are until a larger part comes off.
  explicit PieceWatch(double smallest) : smallest_(smallest) {}

  /// Result of a stroke.
  enum class Finding : std::uint8_t {
    nothing,
    parted,  ///< command() is due
    pending  ///< has_loose() of the current state has the answer: too long for a tick
  };
  /// After each tick. At most some hundred bricks are looked at (volume::parting).
  Finding after_tick(const Engine& engine);
  /// Call after any command: its changes are no stroke. `outcome` of the command that was due says
  /// which job it began.
  void after_command(const Engine& engine, const Command& command, const Outcome& outcome);
  /// To be applied next.
  Command command() {
    is_asking_ = true;
    return {FreePieces{0, smallest_}, 0};
  }
  /// Does a part hang loose that is large enough? Any thread; tenths of a second.
  static bool has_loose(const haptics::TouchScene& scene, const volume::Version& version, double smallest);
  double smallest() const noexcept { return smallest_; }

  struct Counts {
    std::uint64_t strokes = 0, parted = 0, pending = 0;  ///< asked; of which ...
    std::int64_t most_bricks = 0;
  };
  const Counts& counts() const noexcept { return counts_; }

 private:
  bool was_outdated(const Engine& engine) const;

  double smallest_;
  std::shared_ptr<const volume::Version> before_;  ///< as the last stroke left it
  Id job_;                                         ///< that looks; 0: none
  bool is_asking_ = false;                         ///< the next command is its own
  /// Refused with so many bodies: it waits until there are fewer. 0: it never can.
  std::optional<std::size_t> refused_at_;
  Counts counts_;
};

}  // namespace trephine::sim
