// Compares a session that is opened at random ticks with a replay from its start.
#pragma once

#include <map>
#include <random>

#include "haptics/servo/servo_memory.h"
#include "tests/sim/session_fixture.h"

namespace trephine::sim {

inline std::string bytes_of(const haptics::ServoRecord& record) {
  std::string bytes;
  haptics::put_record(bytes, record);
  return bytes;
}

/// Opens a session at random ticks, and compares each state and the following 300 records with those of a
/// replay from the start. Returns the largest number of ticks that a seek had to play. `places`: number of
/// times that the session is opened, with two seeks each.
inline std::uint64_t expect_opens_anywhere(const std::string& path, const Catalogue& catalogue,
                                           const SceneData& data, int places = 6) {
  auto opened = SessionReader::open(path, catalogue);
  EXPECT_TRUE(opened.is_ok()) << opened.error().message();
  SessionReader& session = opened.value();
  EXPECT_GT(session.checkpoints().size(), 5u);
  constexpr std::uint64_t k_every = 7;  // ticks between hashes
  std::map<std::uint64_t, std::uint64_t> hashes;
  std::map<std::pair<std::uint64_t, int>, std::string> ticks;
  const auto played_of = Replay::open(session, data).value();
  Replay& played = *played_of;
  played.verify_checkpoints();
  for (;;) {
    const auto stepped = played.step();
    if (!stepped) ADD_FAILURE() << stepped.error().message();
    if (!stepped || !stepped.value()) break;
    const haptics::ServoRecord& record = played.record();
    ticks[{record.tick, record.hand}] = bytes_of(record);
    if (played.next_tick() % k_every == 0 && record.hand + 1u == played.engine().hand_count())
      hashes[played.next_tick()] = played.engine().snapshot()->hash();
  }
  if (played.mismatch())
    ADD_FAILURE() << played.mismatch()->what << " at " << played.mismatch()->tick << ": "
                  << played.mismatch()->recorded << " / " << played.mismatch()->replayed;
  EXPECT_EQ(played.counts().checkpoints, session.checkpoints().size());

  std::mt19937 random(11);
  std::uint64_t worst = 0;
  for (int i = 0; i < places; ++i) {
    auto again = SessionReader::open(path, catalogue);  // nothing is reused
    const auto replay_of = Replay::open(again.value(), data).value();
    Replay& replay = *replay_of;
    for (int k = 0; k < 2; ++k) {  // the second seek begins after the records that followed the first
      auto to = hashes.begin();
      std::advance(to, static_cast<std::ptrdiff_t>(random() % hashes.size()));
      const std::uint64_t before = replay.counts().ticks;
      const Status error = replay.seek(to->first);
      EXPECT_FALSE(error) << error->message();
      worst = std::max(worst, replay.counts().ticks - before);
      if (k == 0) {
        EXPECT_EQ(replay.counts().opened_checkpoints, to->first >= session.checkpoints()[0].next_tick);
        EXPECT_EQ(replay.counts().failed_checkpoints, 0u);
      }
      EXPECT_EQ(replay.engine().snapshot()->hash(), to->second) << "opened at " << to->first;
      for (int n = 0; n < 300; ++n) {
        const auto stepped = replay.step();
        EXPECT_TRUE(stepped.is_ok());
        if (!stepped || !stepped.value()) break;
        const haptics::ServoRecord& record = replay.record();
        if (bytes_of(record) != ticks[{record.tick, record.hand}]) {
          ADD_FAILURE() << "tick " << record.tick << " of hand " << int{record.hand} << " after opening at "
                        << to->first;
          break;
        }
      }
    }
    EXPECT_FALSE(replay.seek(session.tick_count()));
    EXPECT_EQ(replay.engine().snapshot()->hash(), played.engine().snapshot()->hash());
    if (replay.mismatch())
      ADD_FAILURE() << replay.mismatch()->what << " at " << replay.mismatch()->tick << ": "
                    << replay.mismatch()->recorded << " / " << replay.mismatch()->replayed;
    if (testing::Test::HasFailure()) break;
  }
  return worst;
}

/// Returns options with `work` as WriterOptions::checkpoint_work.
inline WriterOptions with_checkpoint_work(int work) {
  WriterOptions options;
  options.checkpoint_work = work;
  return options;
}

}  // namespace trephine::sim
