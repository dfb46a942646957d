// PieceWatch: detects after each stroke whether it disconnected a part, which then becomes a body.
#pragma once

#include <optional>

#include "sim/engine/engine.h"
#include "volume/cuts/separation.h"

namespace trephine::sim {

/// For the engine's thread. Its finding becomes an ordinary command (free-pieces) of the operation: a replay
/// needs no watch.
class PieceWatch {
 public:
  /// `smallest`, mm3: smaller parts stay in place until a larger part is detached.
  explicit PieceWatch(double smallest) : smallest_(smallest) {}

  /// Result of a stroke.
  enum class Finding : std::uint8_t {
    nothing,
    disconnected,  ///< command() is due
    pending        ///< search() of the current state decides: it takes too long for a tick
  };
  /// Call after each tick. Examines at most some hundred bricks (volume::detect_detachment).
  Finding after_tick(const Engine& engine);
  /// Call after every command: its changes are not a stroke's. The `outcome` of command() gives the job that
  /// it started.
  void after_command(const Engine& engine, const Command& command, const Outcome& outcome);
  /// Returns the command to apply next.
  Command command() {
    is_command_due_ = true;
    return {FreePieces{0, smallest_}, 0};
  }
  /// Returns the search for disconnected parts in the current state, which takes tenths of a second. Its
  /// result is empty if all parts are connected; else command() is due.
  DerivedJob search(Engine& engine) const;

  struct Counts {
    std::uint64_t strokes = 0, disconnected = 0, pending = 0;  ///< examined, and findings
    std::int64_t max_bricks = 0;                               ///< examined after one stroke
  };
  const Counts& counts() const noexcept { return counts_; }

 private:
  bool was_outdated(const Engine& engine) const;

  double smallest_;
  std::shared_ptr<const volume::Version> before_;  ///< at the end of the last stroke
  Id job_;                                         ///< running free-pieces job; 0: no job
  bool is_command_due_ = false;                    ///< the next command is that of command()
  /// Number of bodies with which the command was refused: waits until there are fewer. 0: never possible.
  std::optional<std::size_t> refused_at_;
  Counts counts_;
};

}  // namespace trephine::sim
