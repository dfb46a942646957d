// Checkpoints at which a session can be opened without a replay of what came before: all of an operation at
// one moment.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sim/engine.h"
#include "sim/servo_follower.h"

namespace trephine::sim {

/// The engine's state at a place of the log, and the servo's a few ticks later, when every hand has seen it:
/// what a servo may still see of older states need not be kept so.
struct Checkpoint {
  std::uint64_t block = 0;  ///< the block of the log that begins there
  EngineImage image;
  /// The ticks from there on in which some hand saw an older state, exact; ...
  std::vector<haptics::ServoRecord> records;
  /// ... and each hand's core after the last of them (ServoMemory).
  std::vector<std::string> cores;
  std::uint64_t next_tick = 0;  ///< after that tick
  /// Fields of tools that were made of older states, and adopted later.
  struct Fields {
    std::uint64_t serial = 0;
    std::uint8_t hand = 0;
    OffsetJob::Offsets offsets;
  };
  std::vector<Fields> fields;
};

/// Makes them while an operation goes on, as often as a replay from one to the next takes some hundredths of
/// a second; by counts, so that the same operation has the same ones. Informed of everything that the engine
/// has applied, in order. One thread.
class CheckpointMaker {
 public:
  CheckpointMaker(const Engine& engine, const haptics::ForceOptions& force, double dt,
                  std::uint64_t first_tick, int work = k_work);
  /// Weight of ticks that touch nothing; a touch is more, a cut more yet.
  static constexpr int k_work = 8000;
  /// Ticks for which servos that lag behind are waited for; then it is tried another time.
  static constexpr std::size_t k_most_records = 1024;

  void add(const haptics::ServoRecord& record, const Engine& engine, const Outcome& outcome);
  void add(const Command& command, const Engine& engine, const Outcome& outcome);
  /// Is one due? Then begin() with the block of the log that begins here.
  bool is_due() const noexcept { return is_faithful_ && !pending_ && work_ >= work_between_; }
  void begin(Engine& engine, std::uint64_t block);
  /// One that is complete; null: none yet.
  std::unique_ptr<Checkpoint> take();
  /// Do the followed cores give what the servo gave? If not, no more are made.
  bool is_faithful() const noexcept { return is_faithful_; }

 private:
  void finish_servo();
  void count(int work) noexcept;

  ServoFollower servo_;
  bool is_faithful_ = true;
  int work_between_, work_ = 0;
  std::unique_ptr<Checkpoint> pending_;
  std::vector<bool> has_seen_;  ///< by hand: what is kept, or newer
  bool is_servo_done_ = false, are_fields_done_ = false;
};

}  // namespace trephine::sim
