// Headless operation without threads: one servo step, then its edit, and so on. Same input, same bits.
#pragma once

#include "sim/edit_session.h"
#include "sim/session_writer.h"

namespace trephine::sim {

class Lockstep {
 public:
  /// Borrows everything; the method was prepared for the scene. A null tool only touches. `recorder`: told of
  /// everything when not null.
  Lockstep(const haptics::TouchScene& scene, const haptics::ProxyMethod& method, Tool* tool,
           const haptics::ForceOptions& force, double rate_hz, SessionWriter* recorder = nullptr);
  /// Goes on from `edits` (of one hand) at `first_tick`.
  Lockstep(EditSession edits, const haptics::ForceOptions& force, double rate_hz, SessionWriter* recorder,
           std::uint64_t first_tick);

  /// One tick. The servo sees the version that the tick before left.
  haptics::ServoRecord step(const haptics::Pose& pose);
  /// By stroke. A tool over which bone grows is led out along its own path.
  EditOutcome undo() { return apply({Command::Kind::undo, 0, {}, 0}); }
  EditOutcome redo() { return apply({Command::Kind::redo, 0, {}, 0}); }
  EditOutcome apply(const Command& command);

  const EditSession& edits() const noexcept { return edits_; }
  /// Ticks from a cut to the offset fields that know it, where the tool is round.
  static constexpr int k_offsets_every = 20;
  const haptics::ProxyStep& last_step() const noexcept { return servo_.last_step(); }
  const EditOutcome& last_edit() const noexcept { return last_edit_; }
  const haptics::ServoRecord& last_record() const noexcept { return last_record_; }

 private:
  EditSession edits_;
  haptics::ServoCore servo_;
  SessionWriter* recorder_;
  EditOutcome last_edit_;
  haptics::ServoRecord last_record_;
  int ticks_owed_ = 0;
};

}  // namespace trephine::sim
