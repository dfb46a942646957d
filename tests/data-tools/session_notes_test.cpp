// Notes of a session: every value survives a round trip, errors state their line, and an empty list removes
// the file.
#include "data-tools/cases/session_notes.h"

#include <filesystem>
#include <gtest/gtest.h>

#include "apps/bench/scenes/scratch.h"
#include "tests/data-tools/file_helpers.h"

namespace trephine::data_tools {
namespace {

TEST(SessionNotes, SurviveARoundTripInTheOrderOfTime) {
  const scenes::Scratch scratch;
  const std::string session = scratch / "round.session";
  EXPECT_TRUE(read_notes(session).value().empty());
  const SessionNote late{12.345678901234, glm::dvec3(1.5, -20.25, 0.1), "Zu \"tief\" \\ ä 10 %"},
      early{0.5, std::nullopt, "Begin here."};
  ASSERT_FALSE(write_notes(session, {late, early}));
  const auto read = read_notes(session);
  ASSERT_TRUE(read.is_ok()) << read.error().message();
  EXPECT_EQ(read.value(), (std::vector<SessionNote>{early, late}));
  ASSERT_FALSE(write_notes(session, {}));
  EXPECT_FALSE(std::filesystem::exists(notes_path(session)));
}

TEST(SessionNotes, AnInvalidFileIsAnErrorWithItsLine) {
  const scenes::Scratch scratch;
  const std::string session = scratch / "invalid.session";
  for (const auto& [text, part] :
       {std::pair("[[note]]\nseconds = 1\ntext = \"a\"\n", "has no schema"),
        std::pair("schema = 2\n", "newer trephine"),
        std::pair("schema = 1\n[[note]]\nseconds = -1\ntext = \"a\"\n", "line 3"),
        std::pair("schema = 1\n[[note]]\ntext = \"a\"\n", "line 2"),
        std::pair("schema = 1\n[[note]]\nseconds = 1\ntext = \"a\"\nat = [1, 2]\n", "line 5"),
        std::pair("schema = 1\n[[note]]\nseconds = nan\ntext = \"a\"\n", "line 3"),
        std::pair("schema = 1\nnote = 3\n", "line 2"), std::pair("\x01", "not text")}) {
    SCOPED_TRACE(text);
    write_text(notes_path(session), text);
    const auto read = read_notes(session);
    ASSERT_FALSE(read.is_ok());
    EXPECT_NE(read.error().message().find(part), std::string::npos) << read.error().message();
  }
}

}  // namespace
}  // namespace trephine::data_tools
