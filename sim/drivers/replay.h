// Replay: runs a recorded session again. The same ticks and commands in the same order give the same bits.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "haptics/servo/servo_loop.h"
#include "sim/engine/engine.h"
#include "sim/session/checkpoint_store.h"
#include "sim/session/servo_follower.h"
#include "sim/session/session_reader.h"
#include "sim/session/session_writer.h"

namespace trephine::sim {

/// First difference of a replay from the recording.
struct Mismatch {
  std::uint64_t tick = 0;
  std::string what;  ///< "force", "voxels", "removed volume"
  std::string recorded, replayed;
};

/// For one thread. Borrows the session. The servo and the engine run in the logged order; each tick uses the
/// scene that the recorded tick used.
class Replay {
 public:
  /// `data`: volumes of the scene, the anatomy first. Volumes, models and streams that `data` lacks are read
  /// from the session. Error if the data do not match the session, or if the program lacks an instrument, a
  /// method or a module of the session.
  static Result<std::unique_ptr<Replay>> open(SessionReader& session, SceneData data = {});

  /// Opens a session with a scene that was already built from its header, such as the scene of the recording
  /// program.
  static Result<std::unique_ptr<Replay>> open(SessionReader& session, OperationStart start);

  /// Returns the reason why this program cannot reproduce the session's bits; empty if it can.
  Status reason_not_verifiable() const;
  /// Runs the next tick of any hand, and the commands before it. False at the end of the session.
  Result<bool> step();
  /// Goes to the state after the last tick before `tick`, forward or back, from kept states and checkpoints.
  /// If `tick` is at least the session's number of ticks, goes to the end of the session, with the commands
  /// after the last tick.
  Status seek(std::uint64_t tick);
  /// As seek(), but returns after about `seconds`. Returns false if it must be called again to arrive.
  Result<bool> seek_for(std::uint64_t tick, double seconds);
  /// Returns the parts of the force of a hand in a tick. Afterwards the replay is at the end of that hand's
  /// part of the tick. Error if the session has no such tick.
  Result<haptics::ForceParts> force_parts(std::uint64_t tick, int hand);
  /// Makes step() compare each checkpoint of the session with the replayed state.
  void verify_checkpoints() noexcept { is_verifying_ = true; }
  /// Returns the tail with which SessionWriter::append() continues the recording.
  SessionTail tail();

  const haptics::ServoRecord& record() const noexcept { return record_; }  ///< last tick, as replayed
  /// Newest record of a hand.
  const haptics::ServoRecord& record(int hand) const noexcept {
    return state_->records[static_cast<std::size_t>(hand)];
  }
  const glm::dvec3& recorded_force() const noexcept { return recorded_force_; }
  /// Result of the proxy method in the last tick.
  const haptics::ProxyStep& proxy_step() const noexcept {
    return state_->servo.cores()[record_.hand].last_step();
  }
  /// Scene of the hand of the last tick.
  std::shared_ptr<const haptics::ServoHand> servo_hand() const noexcept {
    const auto& scene = state_->servo.current_scene();
    return {scene, &scene->hands[record_.hand]};
  }
  const Engine& engine() const noexcept { return state_->engine; }
  Engine& engine() noexcept { return state_->engine; }
  std::uint64_t next_tick() const noexcept { return state_->next_tick; }
  const std::optional<Mismatch>& mismatch() const noexcept { return mismatch_; }
  /// Returns the voxels that may look different since the last call.
  volume::VoxelBox take_changed() noexcept;
  struct Counts {
    std::uint64_t ticks = 0, dropped = 0, commands = 0, versions = 0, hashes = 0, events = 0, resumes = 0,
                  checkpoints = 0,  ///< compared checkpoints
        opened_checkpoints = 0,     ///< checkpoints that seek() opened
        failed_checkpoints = 0;     ///< checkpoints that could not be opened
  };
  const Counts& counts() const noexcept { return counts_; }

 private:
  /// All state that changes; a copy is a state to return to.
  struct State {
    Engine engine;
    ServoFollower servo;
    std::map<std::uint64_t, std::shared_ptr<const volume::Version>> versions_to_check;  ///< by their serials
    std::size_t events = 0;                     ///< number of checked events of the chronicle
    std::uint64_t next_tick = 0, replayed = 0;  ///< number of played ticks
    std::uint64_t opened_at = 0;                ///< serial of the opened checkpoint; 0: from the start
    std::uint64_t dropped = 0;                  ///< ticks dropped since the newest resume
    bool is_in_tick = false;                    ///< the last hand's part of the tick is missing
    /// Offset fields that were built from states before the opened checkpoint, for adoptions after it.
    std::vector<Checkpoint::Fields> fields;
    SessionReader::Position position;
    std::vector<haptics::ServoRecord> records = {};  ///< newest of each hand
  };
  Replay(SessionReader& session, Engine engine);
  Status restore(State state);
  Status open_at(std::size_t checkpoint);
  Status process_item(const LogItem& item);
  void compare_checkpoint();
  void compare_tick();
  void finish_tick(bool may_keep = true);
  void keep();
  Status run_tick(const TickItem& item);
  void run_command(const Command& command);
  void record_mismatch(std::uint64_t tick, const char* what, std::string recorded, std::string replayed);
  void add_change(const Outcome& outcome);
  void check(const VersionItem& item);
  void check(const HashItem& item);
  void check(const EventItem& item);
  void check_end();

  SessionReader* session_;
  double dt_;
  std::unique_ptr<State> state_;
  std::vector<State> kept_states_;
  std::set<std::size_t> failed_checkpoints_;  ///< that could not be opened
  CheckpointStore checkpoints_;
  bool are_checkpoints_usable_ = true, is_verifying_ = false;
  std::size_t next_checkpoint_ = 0;                ///< index of the next checkpoint to compare
  std::optional<Checkpoint> compared_checkpoint_;  ///< checkpoint whose ticks are being compared
  std::size_t compared_ticks_ = 0;
  haptics::ServoRecord record_;
  glm::dvec3 recorded_force_{0.0};
  std::optional<Mismatch> mismatch_;
  std::optional<haptics::ForceParts> parts_;
  /// Tick and hand for which run_tick() sets `parts_`.
  std::optional<std::pair<std::uint64_t, int>> requested_parts_;
  volume::VoxelBox changed_{glm::ivec3(0), glm::ivec3(-1)};
  Counts counts_;
};

}  // namespace trephine::sim
