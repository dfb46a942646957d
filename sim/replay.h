// Runs a recorded session again: the same ticks and commands in the same order give the same bits.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "haptics/servo/servo_loop.h"
#include "sim/checkpoint_store.h"
#include "sim/engine.h"
#include "sim/servo_follower.h"
#include "sim/session_reader.h"
#include "sim/session_writer.h"

namespace trephine::sim {

/// First difference of a replay from the recording.
struct Mismatch {
  std::uint64_t tick = 0;
  std::string what;  ///< "force", "voxels", "removed volume"
  std::string recorded, replayed;
};

/// One thread. Borrows the session. The servo and the engine run in the logged order; each tick sees the
/// scene that it saw then.
class Replay {
 public:
  /// `data`: the volumes that the session does not hold itself, the anatomy first; its models it holds. Error
  /// when they are others, or the program lacks an instrument, a method or a module of the session.
  static volume::Result<std::unique_ptr<Replay>> open(SessionReader& session, SceneData data = {});

  /// Over a scene that was made of the session's header: the program that recorded it has one.
  static volume::Result<std::unique_ptr<Replay>> open(SessionReader& session, OperationStart start);

  /// Why this session's bits cannot be expected of this program; nothing when they can.
  volume::Status why_not_verifiable() const;
  /// The next tick of any hand, and the commands before it. False at the end of the session.
  volume::Result<bool> step();
  /// To the last tick before `tick`, forward or back; back goes by way of kept states. From the session's
  /// last tick on: to its very end, with the commands that follow.
  volume::Status seek(std::uint64_t tick);
  /// From here on step() compares each checkpoint of the session with what it comes to by itself.
  void verify_checkpoints() noexcept { is_verifying_ = true; }
  /// To go on with the recording, SessionWriter::append().
  SessionTail tail();

  const haptics::ServoRecord& record() const noexcept { return record_; }  ///< as replayed, exact
  /// The newest of one hand.
  const haptics::ServoRecord& record(int hand) const noexcept {
    return state_->records[static_cast<std::size_t>(hand)];
  }
  const glm::dvec3& recorded_force() const noexcept { return recorded_force_; }
  /// Result of the method in that tick, and its scene.
  const haptics::ProxyStep& proxy_step() const noexcept {
    return state_->servo.cores()[record_.hand].last_step();
  }
  std::shared_ptr<const haptics::TouchState> seen() const noexcept {
    const auto hand = servo_hand();
    return {hand, &hand->state};
  }
  /// Scene of its hand.
  std::shared_ptr<const haptics::ServoHand> servo_hand() const noexcept {
    const auto& scene = state_->servo.seen();
    return {scene, &scene->hands[record_.hand]};
  }
  const Engine& engine() const noexcept { return state_->engine; }
  Engine& engine() noexcept { return state_->engine; }
  std::uint64_t next_tick() const noexcept { return state_->next_tick; }
  const std::optional<Mismatch>& mismatch() const noexcept { return mismatch_; }
  /// Voxels that may look different since the last call.
  volume::VoxelBox take_changed() noexcept;
  struct Counts {
    std::uint64_t ticks = 0, dropped = 0, commands = 0, versions = 0, hashes = 0, events = 0, resumes = 0,
                  checkpoints = 0,  ///< that were compared
        opened = 0,                 ///< by a checkpoint
        unopened = 0;               ///< checkpoints that could not be
  };
  const Counts& counts() const noexcept { return counts_; }

 private:
  /// All that changes; a copy is a place to come back to.
  struct State {
    Engine engine;
    ServoFollower servo;
    std::map<std::uint64_t, std::shared_ptr<const volume::Version>> hashable;  ///< whose hash may still come
    std::size_t events = 0;                     ///< of the chronicle that were checked
    std::uint64_t next_tick = 0, replayed = 0;  ///< ticks played, which may be fewer
    std::uint64_t opened_at = 0;                ///< the serial with which it began
    bool is_in_tick = false;                    ///< some hand's was played, and not the last one's
    /// Fields of tools that will be adopted, and were made of what was before.
    std::vector<Checkpoint::Fields> fields;
    SessionReader::Place place;
    std::vector<haptics::ServoRecord> records = {};  ///< the newest of each hand
  };
  Replay(SessionReader& session, Engine engine);
  volume::Status restore(State state);
  volume::Status open_at(std::size_t checkpoint);
  volume::Status take(const LogItem& item);
  void compare_checkpoint();
  void compare_tick();
  void finish_tick(bool may_keep = true);
  void keep();
  volume::Status run_tick(const TickItem& item);
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
  std::vector<State> kept_;
  CheckpointStore checkpoints_;
  bool are_usable_ = true, is_verifying_ = false;
  std::size_t next_checkpoint_ = 0;      ///< to be compared
  std::optional<Checkpoint> comparing_;  ///< its ticks go on
  std::size_t compared_ticks_ = 0;
  haptics::ServoRecord record_;
  glm::dvec3 recorded_force_{0.0};
  std::optional<Mismatch> mismatch_;
  volume::VoxelBox changed_{glm::ivec3(0), glm::ivec3(-1)};
  Counts counts_;
  std::uint64_t dropped_before_ = 0;  ///< ticks, before the newest resume: an end counts those after it
};

}  // namespace trephine::sim
