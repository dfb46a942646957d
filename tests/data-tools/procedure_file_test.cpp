// Files of procedures: every error has its line, every value survives a round trip, cases carry them.
#include "data-tools/cases/procedure_file.h"

#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>

#include "apps/bench/scenes/scratch.h"
#include "data-tools/cases/case_folder.h"
#include "data-tools/cases/script_file.h"
#include "data-tools/phantoms/phantoms.h"
#include "volume/scan/surgical_plan.h"

namespace trephine::data_tools {
namespace {

using volume::SurgicalProcedure;

/// Two steps, with a key of each kind.
const std::string k_small =
    "schema = 1\n"                                              // 1
    "name = \"small\"\n"                                        // 2
    "title = \"A small one\"\n"                                 // 3
    "instruments = [\"burr\"]\n"                                // 4
    "commands = [\"note\"]\n"                                   // 5
    "[[steps]]\n"                                               // 6
    "name = \"drill\"\n"                                        // 7
    "title = \"Drill\"\n"                                       // 8
    "hint = \"Press.\"\n"                                       // 9
    "note = \"Learn.\"\n"                                       // 10
    "instruments = [\"perforator\", \"burr kinematic=no\"]\n"   // 11
    "commands = [\"add-anchor\"]\n"                             // 12
    "[[steps.transitions]]\n"                                   // 13
    "to = \"done\"\n"                                           // 14
    "on = \"request\"\n"                                        // 15
    "when = [{measurement = \"removed_mm3\", min = 2.5},\n"     // 16
    "        {measurement = \"changes\", min = 1, max = 9}]\n"  // 17
    "[[steps]]\n"                                               // 18
    "name = \"done\"\n"                                         // 19
    "on_entry = [\"note text=over\"]\n"                         // 20
    "end = true\n";                                             // 21

/// Returns the text with the first occurrence of `from` replaced.
std::string changed(const std::string& from, const std::string& to, std::string text = k_small) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(ProcedureFile, ReadsEveryKey) {
  const auto read = parse_procedure(k_small, "small.toml");
  ASSERT_TRUE(read.is_ok()) << read.error().message();
  const SurgicalProcedure& procedure = read.value().procedure;
  EXPECT_EQ(procedure.name, "small");
  EXPECT_EQ(procedure.title, "A small one");
  EXPECT_EQ(procedure.instruments, std::vector<std::string>{"burr"});
  EXPECT_EQ(procedure.commands, std::vector<std::string>{"note"});
  ASSERT_EQ(procedure.steps.size(), 2u);
  const volume::ProcedureStep &drill = procedure.steps[0], &done = procedure.steps[1];
  EXPECT_EQ(drill.hint, "Press.");
  EXPECT_EQ(drill.note, "Learn.");
  EXPECT_EQ(drill.instruments, (std::vector<std::string>{"perforator", "burr kinematic=no"}));
  EXPECT_EQ(drill.commands, std::vector<std::string>{"add-anchor"});
  EXPECT_FALSE(drill.is_end);
  ASSERT_EQ(drill.transitions.size(), 1u);
  EXPECT_EQ(drill.transitions[0],
            (volume::StepTransition{"done", "request", {{"removed_mm3", 2.5, {}}, {"changes", 1, 9}}}));
  EXPECT_TRUE(done.is_end);
  EXPECT_EQ(done.on_entry, std::vector<std::string>{"note text=over"});
  EXPECT_EQ(read.value().lines[0].line, 6);
  EXPECT_EQ(read.value().lines[0].transitions, std::vector<int>{13});
  EXPECT_EQ(read.value().lines[1].line, 18);
}

const std::string k_score = "[[score]]\nfinding = \"time\"\nfull_at = 60\nzero_at = 300\nweight = 2.5\n";

TEST(ProcedureFile, LimitsOfTheCaseOverrideThoseOfTheProcedure) {
  const auto read = parse_procedure(k_small + k_score, "small.toml");
  ASSERT_TRUE(read.is_ok()) << read.error().message();
  const volume::ScoreLimit time{"time", 60, 300, 2.5}, path{"motion: path", 500, 900, 1};
  ASSERT_EQ(read.value().procedure.score, std::vector{time});
  volume::SurgicalPlan plan;
  plan.procedure = read.value().procedure;
  plan.score = {path};
  EXPECT_EQ(volume::score_limits(plan), (std::vector{path, time}));
  plan.score = {{"time", 30, 90, 1}};
  EXPECT_EQ(volume::score_limits(plan), plan.score) << "the case replaces the limits of the procedure";
}

TEST(ProcedureFile, ErrorsHaveTheirLine) {
  struct Row {
    std::string text, words;
    int line;
  };
  const std::string other_step = "[[steps]]\nname = \"done\"\nend = true\n";
  const Row rows[] = {
      {changed("hint", "hnt"), "unknown key", 9},
      {changed("on = \"request\"", "onn = \"request\""), "unknown key", 15},
      {changed("min = 2.5", "least = 2.5"), "unknown key", 16},
      {changed("title = \"A", "titel = \"A"), "unknown key", 3},
      {changed("[\"burr\"]", "\"burr\""), "not a list", 4},
      {changed("[\"note\"]", "[3]"), "not text", 5},
      {changed("end = true", "end = 1"), "neither true nor false", 21},
      {changed("name = \"drill\"\n", ""), "a step has no name", 6},
      {changed("name = \"drill\"", "name = \"the first\""), "invalid name", 6},
      {changed("to = \"done\"\n", ""), "no destination", 13},
      {changed("to = \"done\"", "to = \"dome\""), "unknown step", 13},
      {changed(", min = 2.5", ""), "a condition is not complete", 16},
      {changed("min = 2.5", "min = \"2\""), "not a number", 16},
      {changed("min = 1, max = 9", "min = 9, max = 1"), "reversed", 17},
      {changed("name = \"done\"", "name = \"drill\""), "two steps have the same name", 18},
      {changed("end = true", "end = false"), "no end can be reached", 6},
      {changed("end = true\n", "end = true\n[[steps.transitions]]\nto = \"drill\"\non = \"request\"\n"),
       "a last step has transitions", 22},
      {k_small + changed("done", "lost", other_step), "cannot be reached", 22},
      {changed("[[steps.transitions]]", "[[steps.transitions]"), "not TOML", 13},
      {changed("Press.", std::string("Pr\xff")), "not text", 9},
      {changed("Press.", "Pr\\u0007"), "control characters", 6},
      {k_small + changed("300", "60", k_score), "a limit of the score is not complete", 22},
      {k_small + changed("2.5", "-1", k_score), "out of range", 26},
  };
  for (const Row& row : rows) {
    const auto refused = parse_procedure(row.text, "small.toml");
    ASSERT_FALSE(refused.is_ok()) << row.words;
    EXPECT_NE(refused.error().message().find(row.words), std::string::npos) << refused.error().message();
    EXPECT_TRUE((refused.error().where + ":").find("small.toml, line " + std::to_string(row.line) + ":") !=
                std::string::npos)
        << row.words << "\n"
        << refused.error().message();
  }
  // A transition without a cause, and files without schema, name or steps.
  const std::string no_cause = changed(
      "on = \"request\"\nwhen = [{measurement = \"removed_mm3\", min = 2.5},\n        {measurement = "
      "\"changes\", min = 1, max = 9}]\n",
      "");
  for (const auto& [text, words] :
       {std::pair(no_cause, "has no cause"), std::pair(changed("schema = 1\n", ""), "has no schema"),
        std::pair(changed("schema = 1", "schema = 2"), "newer trephine"),
        std::pair(changed("name = \"small\"\n", ""), "the procedure has no name"),
        std::pair(changed("\"small\"", "\"a b\""), "invalid name"),
        std::pair(std::string("schema = 1\nname = \"a\"\n"), "has no step")}) {
    const auto refused = parse_procedure(text, "small.toml");
    ASSERT_FALSE(refused.is_ok()) << words;
    EXPECT_NE(refused.error().message().find(words), std::string::npos) << refused.error().message();
    EXPECT_TRUE(refused.error().where.starts_with("small.toml")) << refused.error().where;
  }
}

TEST(ProcedureFile, WrittenTextReadsBackEqual) {
  auto small = parse_procedure(k_small, "small.toml");
  ASSERT_TRUE(small.is_ok());
  SurgicalProcedure odd = small.value().procedure;
  odd.title = "quotes \" and \\ and µ";
  odd.steps[0].transitions[0].conditions[0].minimum = 0.1 + 0.2;
  odd.steps[0].transitions[0].conditions[1].maximum = -1e-7;
  odd.steps[0].transitions[0].conditions[1].minimum.reset();
  odd.steps[0].transitions.push_back({"drill", "note", {}});
  odd.score = {{"L4 \"left\": breach", 0, 4, 0}, {"time", 0.1 + 0.2, 300, 1}};
  for (const SurgicalProcedure& procedure : {small.value().procedure, odd, procedure_template("mine")}) {
    const auto again = parse_procedure(procedure_text(procedure), "again");
    ASSERT_TRUE(again.is_ok()) << again.error().message() << "\n" << procedure_text(procedure);
    EXPECT_EQ(again.value().procedure, procedure) << procedure_text(procedure);
  }
}

TEST(ProcedureFile, ShippedOnesAreFoundByName) {
  ASSERT_EQ(shipped_procedures().size(), 4u);
  for (const ShippedProcedure& shipped : shipped_procedures()) {
    const std::string name(shipped.name);
    const auto found = open_procedure(name);
    ASSERT_TRUE(found.is_ok()) << found.error().message();
    EXPECT_EQ(found.value().procedure.name, name) << "the file has the name of its procedure";
    const auto file = open_procedure(std::string(TREPHINE_SOURCE_DIR "/docs/procedures/") + name + ".toml");
    ASSERT_TRUE(file.is_ok()) << file.error().message();
    EXPECT_EQ(file.value().procedure, found.value().procedure);
    const auto again = parse_procedure(procedure_text(found.value().procedure), "again");
    ASSERT_TRUE(again.is_ok()) << again.error().message();
    EXPECT_EQ(again.value().procedure, found.value().procedure);
    for (const volume::ProcedureStep& step : found.value().procedure.steps)
      EXPECT_FALSE(step.title.empty()) << name << ": " << step.name;
  }
  const auto unknown = open_procedure("cranotomy");
  ASSERT_FALSE(unknown.is_ok());
  EXPECT_NE(unknown.error().expected.find("craniotomy, laminectomy-screws, ventriculostomy"),
            std::string::npos);
  EXPECT_FALSE(open_procedure("missing.toml").is_ok());
}

class ProcedureCase : public ::testing::Test {
 protected:
  /// A case of one structure on a small phantom.
  CasePlan plan() const {
    CasePlan plan;
    plan.name = "practice";
    plan.modality = "CT";
    CaseStructure bone;
    bone.shape.name = "bone", bone.shape.low = 300;
    plan.structures.push_back(bone);
    plan.score = {{"flap: margin", 10, 0, 2}, {"worst screw breach", 0, 4, 1}};
    return plan;
  }
  volume::Volume scan() const {
    PhantomOptions options;
    options.size = glm::ivec3(12);
    auto made = make_phantom("sphere", options);
    EXPECT_TRUE(made.is_ok());
    return std::move(made).value();
  }
  scenes::Scratch scratch_;
};

TEST_F(ProcedureCase, CarriesItsProcedureAndItsScore) {
  // A procedure that is not shipped is written to a file of the case. A shipped procedure is only named.
  CasePlan own = plan(), shipped = plan();
  own.procedure = parse_procedure(k_small, "small").value().procedure;
  shipped.procedure = shipped_procedure("craniotomy").value().procedure;
  for (const CasePlan& written : {own, shipped}) {
    const std::string folder = scratch_ / written.procedure.name;
    ASSERT_FALSE(write_case(folder, written, scan()));
    const auto opened = open_case(folder);
    ASSERT_TRUE(opened.is_ok()) << opened.error().message();
    EXPECT_EQ(opened.value().plan.procedure, written.procedure);
    EXPECT_EQ(opened.value().plan.score, written.score);
    EXPECT_EQ(std::filesystem::exists(folder + "/procedure.toml"), written.procedure == own.procedure);
    // A case that was opened is written again as it was.
    ASSERT_FALSE(write_case(folder + " 2", opened.value().plan, opened.value().scan.volume));
    const auto again = open_case(folder + " 2");
    ASSERT_TRUE(again.is_ok()) << again.error().message();
    EXPECT_EQ(again.value().plan.procedure, written.procedure);
    EXPECT_EQ(again.value().plan.procedure_file, opened.value().plan.procedure_file);
  }
  // An error in the procedure file of a case names the line in this file.
  std::ofstream(scratch_ / "small/procedure.toml") << changed("hint", "hnt");
  const auto refused = open_case(scratch_ / "small");
  ASSERT_FALSE(refused.is_ok());
  EXPECT_EQ(refused.error().where, "small/procedure.toml, line 9");
  std::filesystem::remove(scratch_ / "small/procedure.toml");
  EXPECT_FALSE(open_case(scratch_ / "small").is_ok());
}

TEST_F(ProcedureCase, RefusesWhatItCannotUse) {
  CasePlan valid = plan();
  valid.procedure = shipped_procedure("craniotomy").value().procedure;
  const std::string text = case_text(valid, false);
  ASSERT_TRUE(parse_case(text, "case.toml").is_ok());
  for (const auto& [from, to, words] :
       {std::tuple("name = \"craniotomy\"", "name = \"cranotomy\"", "unknown"),
        std::tuple("name = \"craniotomy\"", "", "either a name or a file"),
        std::tuple("name = \"craniotomy\"", "file = \"../a.toml\"", "file name"),
        std::tuple("name = \"craniotomy\"", "file = \"case.toml\"", "file name"),
        std::tuple("name = \"craniotomy\"", "step = \"a\"", "unknown key"),
        std::tuple("full_at = 10\n", "full_at = 0\n", "limit of the score"),
        std::tuple("full_at = 10\n", "", "limit of the score"),
        std::tuple("weight = 2\n", "weight = -1\n", "out of range")}) {
    const auto refused = parse_case(changed(from, to, text), "case.toml");
    ASSERT_FALSE(refused.is_ok()) << to;
    EXPECT_NE(refused.error().message().find(words), std::string::npos) << refused.error().message();
    EXPECT_NE(refused.error().where.find("line "), std::string::npos) << refused.error().where;
  }
}

TEST(ProcedureFile, ScriptsNameTheirProcedure) {
  const std::string script =
      "schema = 1\nscan = \"head\"\nprocedure = \"craniotomy\"\n[[hands]]\npoints = [[0, 0, 0, 9]]\n";
  const auto read = parse_script(script, "s.toml");
  ASSERT_TRUE(read.is_ok()) << read.error().message();
  EXPECT_EQ(read.value().procedure, "craniotomy");
  EXPECT_FALSE(parse_script(changed("\"craniotomy\"", "3", script), "s.toml").is_ok());
}

}  // namespace
}  // namespace trephine::data_tools
