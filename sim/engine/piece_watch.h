// PieceWatch: detects after each stroke whether the stroke disconnected a part. Such a part becomes a body.
#pragma once

#include <optional>

#include "sim/engine/engine.h"
#include "volume/cuts/separation.h"

namespace trephine::sim {

/// For the engine's thread. A disconnected part is detached by an ordinary command of the operation
/// (free-pieces), so a replay needs no PieceWatch.
class PieceWatch {
 public:
  /// `smallest`: mm3. A smaller disconnected part stays in place until a larger part is detached.
  explicit PieceWatch(double smallest) : smallest_(smallest) {}

  /// Result of a stroke.
  enum class Detection : std::uint8_t {
    nothing,
    disconnected,  ///< a part is disconnected: apply command()
    pending        ///< undecided: run search(), which takes too long for a tick
  };
  /// Call after each tick. Examines at most some hundred bricks (volume::detect_detachment).
  Detection after_tick(const Engine& engine);
  /// Call after every command, so that its changes are not attributed to a stroke. After command(), `outcome`
  /// contains the job that began, or the reason of a refusal.
  void after_command(const Engine& engine, const Command& command, const Outcome& outcome);
  /// Returns the command that detaches disconnected parts. Apply it before any other command.
  Command command() {
    is_command_due_ = true;
    return {FreePieces{0, smallest_}, 0};
  }
  /// Returns a job that searches the current state for disconnected parts, in tenths of a second. If its
  /// result is empty (DerivedData::is_empty), no part of at least `smallest` is disconnected; otherwise apply
  /// command().
  DerivedJob search(Engine& engine) const;

  struct Counts {
    std::uint64_t strokes = 0, disconnected = 0, pending = 0;  ///< examined strokes, and their results
    std::int64_t max_bricks = 0;                               ///< most bricks examined after one stroke
  };
  const Counts& counts() const noexcept { return counts_; }

 private:
  bool was_outdated(const Engine& engine) const;

  double smallest_;
  std::shared_ptr<const volume::Version> before_;  ///< after the last stroke or command
  Id job_;                                         ///< running free-pieces job; 0: no job
  bool is_command_due_ = false;                    ///< command() was called, and its command not applied yet
  /// Number of bodies when the command was refused: it is due again when fewer exist. 0: never due again.
  std::optional<std::size_t> refused_at_;
  Counts counts_;
};

}  // namespace trephine::sim
