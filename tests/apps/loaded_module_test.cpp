// A module in a library of its own: the program lists the module, and plays, records and replays its
// commands. A session is refused if its module is not loaded.
#include <algorithm>

#include "tests/apps/command_fixture.h"

namespace trephine::command_tests {
namespace {

const std::string k_eraser = " --module '" TREPHINE_ERASER "'";
const std::string k_script = " '" TREPHINE_SOURCE_DIR "/docs/examples/eraser/eraser.toml'";

TEST_F(Command, LoadsAModuleListsItPlaysItAndReplaysIt) {
  EXPECT_NE(run("modules eraser").err.find("unknown module"), std::string::npos);
  const Json listed = json("modules eraser" + k_eraser);
  EXPECT_EQ(listed["modules"][0]["name"], "eraser");
  EXPECT_EQ(listed["modules"][0]["parts"].size(), 3u);

  // The option --module takes one path, so that the name of the script may follow.
  const ProcessResult without = run("run" + k_script);
  EXPECT_EQ(without.exit_code, 2) << without.out;
  const ProcessResult played = run("run" + k_eraser + k_script + " --record eraser.session");
  ASSERT_EQ(played.exit_code, 0) << played.out << played.err;
  EXPECT_NE(played.out.find("checks met"), std::string::npos) << played.out;

  // The session names the module with its version, and needs it.
  const Json info = json("info eraser.session");
  const Json module = {{"name", "eraser"}, {"version", 1}};
  EXPECT_NE(std::find(info["modules"].begin(), info["modules"].end(), module), info["modules"].end());
  for (const char* command : {"replay eraser.session --verify", "slice eraser.session -o slice.png"}) {
    const ProcessResult missing = run(command);
    EXPECT_EQ(missing.exit_code, 2);
    EXPECT_NE(missing.err.find("the session uses the module eraser 1"), std::string::npos) << missing.err;
    EXPECT_NE(missing.err.find("load it with --module PATH"), std::string::npos) << missing.err;
  }
  const ProcessResult replayed = run("replay eraser.session --verify" + k_eraser);
  EXPECT_EQ(replayed.exit_code, 0) << replayed.out << replayed.err;
  EXPECT_NE(run("timeline eraser.session" + k_eraser).out.find("Erased"), std::string::npos);
}

TEST_F(Command, ReportsWhyAModuleIsNotLoaded) {
  const auto error_of = [this](const std::string& path) {
    const ProcessResult ended = run("modules --module '" + path + "'");
    EXPECT_EQ(ended.exit_code, 2);
    return ended.err;
  };
  EXPECT_NE(error_of("missing.so").find("the module does not exist"), std::string::npos);
  write("text.so", "not a library");
  const std::string text = error_of("text.so");
  EXPECT_NE(text.find("the module cannot be loaded"), std::string::npos) << text;
  EXPECT_EQ(text.find(folder_.string()), std::string::npos) << text;  // no path
  EXPECT_NE(error_of(TREPHINE_NO_MODULE).find("the library is not a module"), std::string::npos);
  const std::string old = error_of(TREPHINE_OLD_MODULE);
  EXPECT_NE(old.find("built against another version"), std::string::npos) << old;
  EXPECT_NE(old.find("trephine 0.0.9"), std::string::npos) << old;
  const ProcessResult twice = run("modules" + k_eraser + k_eraser);
  EXPECT_NE(twice.err.find("two modules have the same name"), std::string::npos) << twice.err;
}

}  // namespace
}  // namespace trephine::command_tests
