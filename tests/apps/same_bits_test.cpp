// Forces, events and volumes are the same bits with any number of threads, and with and without AVX2.
#include <algorithm>

#include "tests/apps/command_fixture.h"

namespace trephine::command_tests {
namespace {

TEST_F(Command, ForcesEventsAndVolumesDoNotDependOnThreadsOrAvx2) {
  ASSERT_EQ(run("phantom sphere --size 64 --psf 1 -o s.mha").exit_code, 0);
  const auto script = [](const char* diameter) {
    return std::string("schema = 1\ntitle = \"A notch\"\nscan = \"s.mha\"\nrate = 500\nfree_pieces = 1\n") +
           "[[hands]]\ninstrument = \"burr\"\nparameters = \"removal_rate=300 diameter=" + diameter +
           "\"\npoints = [[0, 0.3, 0.2, 60, 0], [0.2, 0.3, 0.2, 46, 1], [0.7, 0.3, 0.2, 41, 1], "
           "[1.2, 8, 4, 41, 1], [1.5, 8, 4, 60, 0]]\n";
  };
  write("a.toml", script("4"));
  write("other.toml", script("4.1"));
  // Records a session, and writes every tick of its replay as a table.
  const auto record = [&](const std::string& name, const std::string& scene, const std::string& setting) {
    const std::string prefix = "env -u DISPLAY " + setting;
    fs::remove(folder_ / (name + ".session"));
    const ProcessResult r =
        run("run " + scene + " --record " + name + ".session -o " + name + ".mha --json", prefix);
    EXPECT_EQ(r.exit_code, 0) << r.err;
    const ProcessResult replay =
        run("replay " + name + ".session --scan s.mha --verify --table " + name + ".csv", prefix);
    EXPECT_EQ(replay.exit_code, 0) << replay.out << replay.err;
    return Json::parse(r.out, nullptr, false)["content_hash"].get<std::string>();
  };
  const std::string hash = record("a", "a.toml", ""), steps = read(file("a.csv"));
  const Json rows = json("timeline a.session")["rows"];
  EXPECT_GT(json("info a.session")["removed_mm3"].get<double>(), 20);
  EXPECT_GT(std::count(steps.begin(), steps.end(), '\n'), 700);
  for (const char* setting : {"TREPHINE_AVX2=off", "TREPHINE_THREADS=1", "TREPHINE_THREADS=4"}) {
    EXPECT_EQ(record("b", "a.toml", setting), hash) << setting;
    EXPECT_TRUE(read(file("b.csv")) == steps) << setting;
    EXPECT_EQ(json("timeline b.session")["rows"], rows) << setting;
    EXPECT_TRUE(read(file("b.mha")) == read(file("a.mha"))) << setting;
    // The session of the usual setting is replayed with this one.
    EXPECT_EQ(
        run("replay a.session --scan s.mha --verify", std::string("env -u DISPLAY ") + setting).exit_code, 0);
  }
  // A planted difference is found.
  EXPECT_NE(record("c", "other.toml", ""), hash);
  EXPECT_FALSE(read(file("c.csv")) == steps);
}

}  // namespace
}  // namespace trephine::command_tests
