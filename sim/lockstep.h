// Headless operation without threads: one servo step of each hand, then its edit, and so on. Same input, same
// bits.
#pragma once

#include "sim/piece_watch.h"
#include "sim/session_writer.h"

namespace trephine::sim {

class Lockstep {
 public:
  /// One hand, with an instrument or none. Borrows scene and method, which was prepared for it. `recorder`:
  /// informed of everything when not null.
  Lockstep(const haptics::TouchScene& scene, const haptics::ProxyMethod& method, Instrument instrument,
           const haptics::ForceOptions& force, double rate_hz, SessionWriter* recorder = nullptr);
  /// Goes on from `engine`, whatever its hands, at `first_tick`.
  Lockstep(Engine engine, const haptics::ForceOptions& force, double rate_hz,
           SessionWriter* recorder = nullptr, std::uint64_t first_tick = 0);

  /// One tick of one hand. The servo sees what the tick before left.
  haptics::ServoRecord step(const haptics::Pose& pose);
  /// One tick of all hands: they see the same scene.
  std::span<const haptics::ServoRecord> step(std::span<const haptics::Pose> poses);
  /// All hands forget faults, contact and force with the next tick.
  void reset() noexcept { is_reset_ = true; }
  /// By stroke. A tool over which bone grows is led out along its own path.
  Outcome undo() { return apply(Undo{}); }
  Outcome redo() { return apply(Redo{}); }
  Outcome apply(const Command& command);
  /// A job that it begins is done before this returns.
  Outcome apply_whole(const Command& command);
  /// From here on pieces of `smallest` mm3 and more come off by themselves, at the ends of strokes.
  void watch_pieces(double smallest) { pieces_.emplace(smallest); }
  const std::optional<PieceWatch>& pieces() const noexcept { return pieces_; }

  const Engine& engine() const noexcept { return engine_; }
  Engine& engine() noexcept { return engine_; }
  /// Ticks from a cut to the offset fields that know it, where the tool is round.
  static constexpr int k_offsets_every = 20;
  const haptics::ProxyStep& last_step(std::size_t hand = 0) const noexcept {
    return cores_[hand].last_step();
  }
  const haptics::ServoCore& core(std::size_t hand = 0) const noexcept { return cores_[hand]; }
  /// Records of the last tick, all hands together.
  const Outcome& last_outcome() const noexcept { return last_outcome_; }
  const haptics::ServoRecord& last_record(std::size_t hand = 0) const noexcept { return records_[hand]; }

 private:
  Engine engine_;
  std::vector<haptics::ServoCore> cores_;
  SessionWriter* recorder_;
  Outcome last_outcome_;
  std::optional<PieceWatch> pieces_;
  std::vector<haptics::ServoRecord> records_;
  int ticks_owed_ = 0;
  bool is_reset_ = false;
};

}  // namespace trephine::sim
