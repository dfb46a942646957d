// Lockstep: headless operation on the caller's thread, which alternates servo steps and edits. The same input
// gives the same bits.
#pragma once

#include "sim/engine/piece_watch.h"
#include "sim/session/session_writer.h"

namespace trephine::sim {

class Lockstep {
 public:
  /// One hand, with or without an instrument. Borrows scene and method; the method must be prepared for the
  /// scene. `recorder`: records everything; may be null.
  Lockstep(const haptics::TouchScene& scene, const haptics::ProxyMethod& method, Instrument instrument,
           const haptics::ForceOptions& force, double rate_hz, SessionWriter* recorder = nullptr);
  /// Continues from `engine`, with any number of hands, at `first_tick`.
  Lockstep(Engine engine, const haptics::ForceOptions& force, double rate_hz,
           SessionWriter* recorder = nullptr, std::uint64_t first_tick = 0);

  /// Runs a tick of one hand, on the scene after the previous tick.
  haptics::ServoRecord step(const haptics::Pose& pose);
  /// Runs a tick of all hands, on the same scene.
  std::span<const haptics::ServoRecord> step(std::span<const haptics::Pose> poses);
  /// Resets faults, contact and force of all hands in the next tick.
  void reset() noexcept { is_reset_ = true; }
  /// Undoes a stroke. If restored bone encloses a tool, the tool escapes along its own past path.
  Outcome undo() { return apply(Undo{}); }
  Outcome redo() { return apply(Redo{}); }
  /// Applies a command, and then the commands of a step that it begins.
  Outcome apply(const Command& command);
  /// Applies a command, and finishes the job that it starts.
  Outcome apply_and_finish(const Command& command);
  /// Detaches disconnected pieces of at least `smallest` mm3 at the ends of strokes, from this call on.
  void watch_pieces(double smallest) { pieces_.emplace(smallest); }
  const std::optional<PieceWatch>& pieces() const noexcept { return pieces_; }

  const Engine& engine() const noexcept { return engine_; }
  Engine& engine() noexcept { return engine_; }
  /// Ticks from a cut to the offset fields that include it, for round tools.
  static constexpr int k_offsets_every = 20;
  const haptics::ProxyStep& last_step(std::size_t hand = 0) const noexcept {
    return cores_[hand].last_step();
  }
  const haptics::ServoCore& core(std::size_t hand = 0) const noexcept { return cores_[hand]; }
  /// Outcome of the last tick, of all hands together, with the commands that the tick caused.
  const Outcome& last_outcome() const noexcept { return last_outcome_; }
  const haptics::ServoRecord& last_record(std::size_t hand = 0) const noexcept { return records_[hand]; }

 private:
  Outcome apply_alone(const Command& command);
  Outcome finish_job_of(const Outcome& outcome);
  void issue_next(Outcome& outcome);

  Engine engine_;
  std::vector<haptics::ServoCore> cores_;
  SessionWriter* recorder_;
  Outcome last_outcome_;
  std::optional<PieceWatch> pieces_;
  std::vector<haptics::ServoRecord> records_;
  int stale_ticks_ = 0;
  bool is_reset_ = false;
};

}  // namespace trephine::sim
