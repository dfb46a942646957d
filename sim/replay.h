// Runs a recorded session again: the same ticks and commands in the same order give the same bits.
#pragma once

#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "haptics/servo/servo_loop.h"
#include "sim/session_reader.h"

namespace trephine::sim {

/// Error when the scene holds what a session's header has no words for: meshes, further volumes, more shapes
/// than one volume has.
volume::Status check_recordable(const haptics::TouchScene& scene);
/// The effects that a header names, as laws; null when there are none.
std::shared_ptr<const haptics::LawSet> laws_of(const SessionHeader& header);
/// What a session says of a scene, its method and its tools.
SessionHeader describe_session(const haptics::TouchScene& scene, const haptics::ProxyMethod& method,
                               const haptics::ServoOptions& options, std::vector<ToolSpec> tools);
/// The session's shapes on a scan, their bits made. Error when the scan is not the session's.
volume::Result<haptics::TouchScene> scene_of(const SessionReader& session,
                                             std::shared_ptr<const volume::Volume> scan);

/// Where a replay first differed from what was recorded.
struct Mismatch {
  std::uint64_t tick = 0;
  std::string what;  ///< "force", "voxels", "removed volume"
  std::string recorded, replayed;
};

/// One thread. Borrows everything. The servo and the edits run in the logged order; each tick sees the
/// version that it saw then.
class Replay {
 public:
  /// `tools`: one a hand, as the header names them; null for a hand that only touches.
  Replay(SessionReader& session, const haptics::TouchScene& scene, const haptics::ProxyMethod& method,
         std::vector<Tool*> tools);

  /// Why this session's bits cannot be expected of this program; nothing when they can.
  volume::Status why_not_verifiable() const;
  /// The next tick of any hand, and the commands before it. False at the end of the session.
  volume::Result<bool> step();
  /// To the last tick before `tick`, forward or back; back goes by way of kept states. From the session's
  /// last tick on: to its very end, with the commands that follow.
  volume::Status seek(std::uint64_t tick);

  const haptics::ServoRecord& record() const noexcept { return record_; }  ///< as replayed, exact
  const glm::dvec3& recorded_force() const noexcept { return recorded_force_; }
  /// What the method did in that tick, and what it saw.
  const haptics::ProxyStep& proxy_step() const noexcept { return state_->cores[record_.hand].last_step(); }
  std::shared_ptr<const haptics::TouchState> seen() const noexcept {
    const auto& scene = state_->seen.front();
    return {scene, &scene->hands[record_.hand].state};
  }
  const EditSession& edits() const noexcept { return state_->edits; }
  std::uint64_t next_tick() const noexcept { return state_->next_tick; }
  const std::optional<Mismatch>& mismatch() const noexcept { return mismatch_; }
  /// Voxels that may look different since the last call.
  volume::VoxelBox take_changed() noexcept;
  struct Counts {
    std::uint64_t ticks = 0, dropped = 0, commands = 0, versions = 0, hashes = 0, resumes = 0;
  };
  const Counts& counts() const noexcept { return counts_; }

 private:
  /// All that changes; a copy between strokes is a place to come back to.
  struct State {
    EditSession edits;
    std::vector<haptics::ServoCore> cores;
    std::deque<std::shared_ptr<const haptics::ServoScene>>
        seen;  ///< by the last tick, and may be by a coming one
    std::map<std::uint64_t, std::shared_ptr<const volume::Version>> hashable;  ///< whose hash may still come
    std::vector<Command> settings;                                             ///< of tools, since the start
    std::uint64_t next_tick = 0;
    SessionReader::Place place;
  };
  haptics::ServoCore make_core(std::size_t hand, std::uint64_t first_tick) const;
  State fresh_state() const;
  volume::Status restore(const State& state);
  volume::Status run_tick(const TickItem& item);
  void run_command(const Command& command);
  void note(std::uint64_t tick, const char* what, std::string recorded, std::string replayed);
  void note_change(const EditOutcome& outcome);
  void check(const VersionItem& item);
  void check(const HashItem& item);

  SessionReader* session_;
  const haptics::TouchScene* scene_;
  const haptics::ProxyMethod* method_;
  std::vector<Tool*> tools_;
  double dt_;
  std::unique_ptr<State> state_;
  std::vector<State> kept_;
  haptics::ServoRecord record_;
  glm::dvec3 recorded_force_{0.0};
  std::optional<Mismatch> mismatch_;
  volume::VoxelBox changed_{glm::ivec3(0), glm::ivec3(-1)};
  Counts counts_;
};

}  // namespace trephine::sim
