// fork_session(): copies the first part of a session to a new session, which can be continued.
#include <fstream>

#include "sim/session/session_fork.h"
#include "tests/sim/session_fixture.h"

namespace trephine::sim {
namespace {

std::string bytes_of(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Returns the hash of the state of a session after `ticks` ticks.
std::uint64_t state_at(const std::string& path, const std::shared_ptr<const volume::Volume>& base,
                       std::uint64_t ticks) {
  auto opened = SessionReader::open(path, drilling_catalogue());
  EXPECT_TRUE(opened.is_ok()) << opened.error().message();
  auto run = Replay::open(opened.value(), base);
  EXPECT_TRUE(run.is_ok()) << run.error().message();
  const Status error = run.value()->seek(ticks);
  EXPECT_FALSE(error) << error->message();
  return run.value()->engine().state().hash();
}

TEST(ForkedSession, EqualsTheFirstPartAndIsContinued) {
  const Folder folder;
  const std::string path = folder.file("whole.session");
  record_lockstep(path, 6000);
  const std::string whole = bytes_of(path);
  const auto base = small_bone().base;
  int forks = 0;
  for (const std::uint64_t tick : {500u, 2222u, 4000u, 6000u}) {
    SCOPED_TRACE(tick);
    const std::string fork = folder.file(("fork" + std::to_string(tick) + ".session").c_str());
    const auto ticks = fork_session(path, tick, fork);
    if (!ticks && tick < 2000) continue;  // the first block may end after this tick
    ASSERT_TRUE(ticks.is_ok()) << ticks.error().message();
    ++forks;
    EXPECT_LE(ticks.value(), tick);
    // Blocks have about 1000 ticks at most, and only whole blocks are copied.
    EXPECT_GE(ticks.value() + 1001, std::min<std::uint64_t>(tick, 6000));
    const Verdict verdict = replay(fork, base);
    expect_same(verdict);
    // A block may end before or after the commands that follow its last tick, so states before this tick are
    // compared.
    EXPECT_EQ(state_at(fork, base, ticks.value() - 1), state_at(path, base, ticks.value() - 1));
    {
      auto opened = SessionReader::open(fork, drilling_catalogue());
      ASSERT_TRUE(opened.is_ok()) << opened.error().message();
      EXPECT_EQ(opened.value().tick_count(), ticks.value());
      EXPECT_FALSE(opened.value().end().has_value());
      EXPECT_FALSE(opened.value().is_damaged());
      // Another run continues the fork.
      auto lock = SessionLock::acquire(fork);
      ASSERT_TRUE(lock.is_ok()) << lock.error().message();
      auto run = Replay::open(opened.value(), base);
      ASSERT_TRUE(run.is_ok()) << run.error().message();
      ASSERT_FALSE(run.value()->seek(ticks.value()));
      auto writer = SessionWriter::append(std::move(lock).value(), run.value()->tail(), drilling_catalogue());
      ASSERT_TRUE(writer.is_ok()) << writer.error().message();
      Engine engine = std::move(run.value()->engine());
      const Command command{Resume{}};
      const Outcome resumed = engine.apply(command);
      writer.value()->add(command, engine, resumed);
      Lockstep more(std::move(engine), {}, 1000, writer.value().get(), ticks.value());
      for (int i = 0; i < 700; ++i) more.step(drilling_path(10).at(1e-3 * i + 0.2));
      ASSERT_FALSE(writer.value()->finish(more.engine()));
    }
    expect_same(replay(fork, base));
    EXPECT_EQ(bytes_of(path), whole) << "the original is unchanged";
    // An existing file is not replaced.
    const std::string before = bytes_of(fork);
    EXPECT_FALSE(fork_session(path, tick, fork).is_ok());
    EXPECT_EQ(bytes_of(fork), before);
  }
  EXPECT_GE(forks, 3);
  // A tick after the end is an error, and so is tick 0.
  const auto late = fork_session(path, 6001, folder.file("none.session"));
  ASSERT_FALSE(late.is_ok());
  EXPECT_EQ(late.error().found, "6.001 s");
  EXPECT_EQ(late.error().expected, "at most 6 s");
  EXPECT_FALSE(fork_session(path, 0, folder.file("none.session")).is_ok());
  EXPECT_FALSE(fs::exists(folder.file("none.session")));
  // A damaged session, a file of another kind and a missing file are refused, and no file is left behind.
  std::string damaged = whole;
  damaged[damaged.size() / 2] ^= 1;
  std::ofstream(folder.file("damaged.session"), std::ios::binary) << damaged;
  std::ofstream(folder.file("other.session"), std::ios::binary) << "nothing";
  for (const char* name : {"damaged.session", "other.session", "missing.session"})
    EXPECT_FALSE(fork_session(folder.file(name), 6000, folder.file("none.session")).is_ok()) << name;
  for (const auto& entry : fs::directory_iterator(folder.path))
    EXPECT_EQ(entry.path().string().find(".part"), std::string::npos);
}

}  // namespace
}  // namespace trephine::sim
