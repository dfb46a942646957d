// procedure: shows, checks and begins procedures; names are compared with the catalogue; drawings are
// legible.
#include <random>

#include "apps/imaging/step_diagram.h"
#include "apps/workbench/procedure_names.h"
#include "tests/apps/command_fixture.h"
#include "tests/whole.h"

namespace trephine::command_tests {
namespace {

using imaging::PictureBox;
using imaging::StepDiagram;
using volume::SurgicalProcedure;

TEST_F(Command, ProceduresAreShown) {
  const ProcessResult text = run("procedure show ventriculostomy");
  EXPECT_EQ(text.exit_code, 0) << text.err;
  for (const char* words : {"2 burr-hole: Drill the burr hole", "instruments: perforator, burr kinematic=no",
                            "-> catheter: on request, removed_mm3 ≥ 50", "on entry: judge-catheter"})
    EXPECT_NE(text.out.find(words), std::string::npos) << words << "\n" << text.out;
  const Json data = json("procedure show laminectomy-screws");
  ASSERT_EQ(data["steps"].size(), 5u);
  EXPECT_EQ(data["steps"][1]["name"], "probe");
  EXPECT_EQ(data["steps"][1]["transitions"][0]["to"], "screw");
  EXPECT_EQ(data["steps"][1]["transitions"][0]["when"][0]["min"], 1);
  EXPECT_EQ(data["steps"][4]["is_end"], true);
  EXPECT_EQ(run("procedure show craniotomy -o c.svg").exit_code, 0);
  const std::string svg = read(file("c.svg"));
  EXPECT_TRUE(svg.starts_with("<svg ") && svg.ends_with("</svg>\n"));
  EXPECT_NE(svg.find(">Drill the burr holes</text>"), std::string::npos);
  EXPECT_EQ(run("procedure show craniotomy -o c.png").exit_code, 0);
  EXPECT_GT(fs::file_size(folder_ / "c.png"), 10000u);
  EXPECT_EQ(run("procedure show craniotomy -o c.jpg").exit_code, 2);
  // A long report that is written to a full disk ends with exit code 3.
  const int full = std::system("'" TREPHINE_COMMAND "' modules --json > /dev/full 2> /dev/null");
  EXPECT_EQ(WEXITSTATUS(full), 3);
}

/// Examples are played to their end, replayed to the bit, and scored. If an example has a procedure, its
/// steps apply.
TEST_F(Command, ExamplesOfProceduresArePlayedScoredAndReplayed) {
  struct Row {
    const char* name;
    double points;  // least share of the possible points
  };
  std::vector<Row> rows{{"procedure-laminectomy-screws", 0.85}};
  if (runs_all_cases())
    rows.insert(rows.end(),
                {Row{"procedure-ventriculostomy", 1}, Row{"ventriculostomy", 1}, Row{"clamp", 0.5},
                 Row{"procedure-craniotomy", 0.5}, Row{"procedure-first-steps", 0}});
  for (const auto& [name, points] : rows) {
    SCOPED_TRACE(name);
    write("e.toml", read(std::string(TREPHINE_SOURCE_DIR "/docs/examples/") + name + ".toml"));
    const std::string session = std::string(name) + ".session";
    const Json played = json("run e.toml --record " + session);
    EXPECT_EQ(played["is_met"], true) << played["checks"].dump(1);
    EXPECT_EQ(json("replay " + session + " --verify")["is_same"], true);
    const Json score = json("score " + session);
    EXPECT_GE(score["points"].get<double>(), points * score["possible"].get<double>()) << score.dump(1);
  }
}

/// A craniotomy along the planned outline of each approach is played to its end and gets at least 95 % of the
/// points. Only the complete run plays the approaches.
TEST_F(Command, ApproachesOfAHeadArePlayedToTheirEnd) {
  const std::string script = TREPHINE_SOURCE_DIR "/docs/examples/procedure-approach.toml";
  std::vector<std::string> approaches;
  if (runs_all_cases()) approaches = {"vault", "frontotemporal", "suboccipital", "keyhole"};
  for (const std::string& approach : approaches) {
    SCOPED_TRACE(approach);
    ASSERT_EQ(run("phantom head --approach " + approach + " --case " + approach).exit_code, 0);
    const Json played = json("run " + script + " --scan " + approach + " --record " + approach + ".session");
    EXPECT_EQ(played["is_met"], true) << played["checks"].dump(1);
    const Json score = json("score " + approach + ".session --scan " + approach);
    EXPECT_GE(score["points"].get<double>(), 0.95 * score["possible"].get<double>()) << score.dump(1);
  }
  const ProcessResult unknown = run("phantom head --approach parietal --case other");
  EXPECT_EQ(unknown.exit_code, 2);
  EXPECT_NE(unknown.err.find("frontotemporal, suboccipital or keyhole"), std::string::npos) << unknown.err;
  EXPECT_EQ(run("phantom spine --approach keyhole --case other").exit_code, 2);
  const ProcessResult empty = run("run " + script + " --scan ''");
  EXPECT_EQ(empty.exit_code, 2);
  EXPECT_NE(empty.err.find("--scan: the value of an option is empty"), std::string::npos) << empty.err;
}

TEST_F(Command, ATemplateIsValidAndAStartForChanges) {
  EXPECT_EQ(run("procedure new hole -o hole.toml").exit_code, 0);
  const ProcessResult checked = run("procedure check hole.toml");
  EXPECT_EQ(checked.exit_code, 0) << checked.err;
  EXPECT_EQ(checked.out, "hole: 2 steps, no error\n");
  const std::string text = read(file("hole.toml"));
  EXPECT_NE(text.find("# Instruction for the user.\n"), std::string::npos) << text;
  // The name of a shipped procedure and an invalid name are refused. A file cannot be both input and output.
  EXPECT_EQ(run("procedure new craniotomy -o c.toml").exit_code, 2);
  EXPECT_EQ(run("procedure new 'a b' -o c.toml").exit_code, 2);
  EXPECT_EQ(run("procedure show hole.toml -o hole.toml").exit_code, 2);
  EXPECT_EQ(leftovers({"hole.toml"}), "");
}

TEST_F(Command, NamesOfAProcedureAreCompared) {
  EXPECT_EQ(run("procedure new hole -o hole.toml").exit_code, 0);
  const std::string text = read(file("hole.toml"));
  const auto line_of = [&](const std::string& words) {
    return std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(text.find(words)), '\n') + 1;
  };
  const auto step = line_of("[[steps]]"), transition = line_of("[[steps.transitions]]"),
             end = line_of("name = \"done\"") - 1;
  struct Row {
    const char *from, *to, *words;
    std::ptrdiff_t line;
  };
  for (const auto& [from, to, words, line] :
       {Row{"burr kinematic=no", "bur", "unknown instrument", step},
        Row{"burr kinematic=no", "burr kinetic=no", "kinetic", step},
        Row{"burr kinematic=no", "burr kinematic=maybe", "kinematic", step},
        Row{"instruments = [", "commands = [\"drill\"]\ninstruments = [", "unknown command", step},
        Row{"instruments = [", "commands = [\"breakthrough\"]\ninstruments = [", "unknown command", step},
        Row{"on = \"request\"", "on = \"piece-fred\"", "unknown cause", transition},
        Row{"removed_mm3", "events bites", "unknown measurement", transition},
        Row{"removed_mm3", "visits dril", "unknown step", transition},
        Row{"note text=", "nota text=", "unknown command", end},
        Row{"note text=", "note txt=", "txt", end}}) {
    std::string other = text;
    other.replace(other.find(from), std::string(from).size(), to);
    write("other.toml", other);
    const ProcessResult refused = run("procedure check other.toml");
    EXPECT_EQ(refused.exit_code, 2) << to;
    EXPECT_NE(refused.err.find(words), std::string::npos) << refused.err;
    EXPECT_NE(refused.err.find(", line " + std::to_string(line) + ": step"), std::string::npos)
        << line << "\n"
        << refused.err;
  }
  // Commands of every step, and measures that only some operations have.
  for (const auto& [from, to, code, words] :
       {std::tuple("\"look-at\"", "\"look-aat\"", 2, "unknown command"),
        std::tuple("removed_mm3", "flap lenght", 0, "check the spelling: flap lenght"),
        std::tuple("removed_mm3", "flap area", 0, "no error"),
        std::tuple("burr kinematic=no", "*", 0, "no error")}) {
    std::string other = text;
    other.replace(other.find(from), std::string(from).size(), to);
    write("other.toml", other);
    const ProcessResult checked = run("procedure check other.toml");
    EXPECT_EQ(checked.exit_code, code) << to << checked.err;
    EXPECT_NE((checked.out + checked.err).find(words), std::string::npos) << checked.out << checked.err;
  }
  // A script with an invalid procedure does not start.
  write("other.toml", std::string(text).replace(text.find("burr kin"), 4, "burx"));
  write("s.toml",
        "schema = 1\nscan = \"head\"\nprocedure = \"other.toml\"\n[[hands]]\npoints = [[0, 0, 0, 90]]\n");
  const ProcessResult refused = run("run s.toml");
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_NE(refused.err.find("other.toml, line " + std::to_string(step)), std::string::npos) << refused.err;
}

TEST(Procedures, ShippedOnesUseKnownNames) {
  for (const data_tools::ShippedProcedure& shipped : data_tools::shipped_procedures()) {
    const auto file = workbench::open_known_procedure(std::string(shipped.name));
    ASSERT_TRUE(file.is_ok()) << file.error().message();
    EXPECT_EQ(workbench::late_measures_of(file.value().procedure), std::vector<std::string>());
  }
}

/// Returns the number of faults of a drawing: arrows that pass boxes or texts or do not end at the edge of a
/// box; texts that overlap each other or the edge of a box; boxes that overlap; texts and boxes outside the
/// picture.
int faults_of(const StepDiagram& diagram) {
  int faults = 0;
  const auto is_inside = [](const PictureBox& in, const PictureBox& out) {
    return in.low.x >= out.low.x && in.low.y >= out.low.y && in.high.x <= out.high.x &&
           in.high.y <= out.high.y;
  };
  const PictureBox picture{{0, 0}, {diagram.width, diagram.height}};
  for (const StepDiagram::Arrow& arrow : diagram.arrows) {
    const glm::dvec2 tip = arrow.points.back();
    faults += std::none_of(diagram.boxes.begin(), diagram.boxes.end(), [&](const StepDiagram::Box& box) {
      const PictureBox& area = box.area;
      const bool is_at_side =
          (tip.x == area.low.x || tip.x == area.high.x) && tip.y > area.low.y && tip.y < area.high.y;
      return is_at_side || (tip.y == area.low.y && tip.x > area.low.x && tip.x < area.high.x);
    });
    for (std::size_t i = 1; i < arrow.points.size(); ++i) {
      const imaging::Segment segment{arrow.points[i - 1], arrow.points[i]};
      for (const StepDiagram::Box& box : diagram.boxes) faults += imaging::passes(segment, box.area);
      for (const StepDiagram::Text& text : diagram.texts) faults += imaging::passes(segment, text.area);
    }
  }
  for (std::size_t i = 0; i < diagram.texts.size(); ++i) {
    const PictureBox& area = diagram.texts[i].area;
    faults += !is_inside(area, picture);
    for (std::size_t j = 0; j < i; ++j) faults += imaging::overlap(area, diagram.texts[j].area);
    for (const StepDiagram::Box& box : diagram.boxes)
      faults += imaging::overlap(area, box.area) && !is_inside(area, box.area);
  }
  for (std::size_t i = 0; i < diagram.boxes.size(); ++i) {
    faults += !is_inside(diagram.boxes[i].area, picture);
    for (std::size_t j = 0; j < i; ++j)
      faults += imaging::overlap(diagram.boxes[i].area, diagram.boxes[j].area);
  }
  return faults;
}

/// A procedure of up to 20 steps with transitions in any direction.
SurgicalProcedure random_procedure(std::mt19937& random) {
  const auto number = [&](int below) { return static_cast<int>(random() % static_cast<unsigned>(below)); };
  const auto words = [&](int most) {
    std::string text = "W";
    for (int i = number(most); i > 0; --i) text += "iWm _x"[number(6)];
    return text;
  };
  SurgicalProcedure procedure;
  procedure.name = "random", procedure.title = words(120);
  const int steps = 1 + number(20);
  for (int s = 0; s < steps; ++s) {
    volume::ProcedureStep& step = procedure.steps.emplace_back();
    step.name = "step" + std::to_string(s), step.title = words(90);
    for (int i = number(4); i > 0; --i) step.instruments.push_back(words(40));
    for (int i = number(5); i > 0; --i) {
      volume::StepTransition& transition = step.transitions.emplace_back();
      transition.to = "step" + std::to_string(number(steps));
      if (number(2)) transition.on = words(40);
      if (number(2) || transition.on.empty()) transition.conditions.push_back({words(60), number(9), {}});
    }
  }
  return procedure;
}

TEST(StepDiagram, NothingCoversAnything) {
  std::vector<SurgicalProcedure> procedures;
  for (const data_tools::ShippedProcedure& shipped : data_tools::shipped_procedures())
    procedures.push_back(data_tools::shipped_procedure(std::string(shipped.name)).value().procedure);
  std::mt19937 random(5);
  for (int i = 0; i < 100; ++i) procedures.push_back(random_procedure(random));
  for (const SurgicalProcedure& procedure : procedures) {
    StepDiagram diagram = imaging::step_diagram(procedure);
    std::size_t arrows = 1;
    for (const volume::ProcedureStep& step : procedure.steps) arrows += step.transitions.size();
    EXPECT_EQ(diagram.arrows.size(), arrows);
    EXPECT_EQ(diagram.boxes.size(), procedure.steps.size());
    ASSERT_EQ(faults_of(diagram), 0) << imaging::svg_of(diagram);
    // Planted faults are counted: a moved box, a long text, an arrow across.
    StepDiagram moved = diagram, longer = diagram, across = diagram;
    moved.boxes[0].area.low.y += 40, moved.boxes[0].area.high.y += 40;
    longer.texts.back().area.high.x += diagram.width;
    across.arrows[0].points.back().y = diagram.height;
    for (const StepDiagram& faulty : {moved, longer, across}) EXPECT_GT(faults_of(faulty), 0);
  }
}

TEST(StepDiagram, SpecialCharactersAreEscaped) {
  SurgicalProcedure procedure;
  procedure.name = "a", procedure.title = "<b> & \"c\"";
  procedure.steps.emplace_back().name = "one";
  const std::string svg = imaging::svg_of(imaging::step_diagram(procedure));
  EXPECT_NE(svg.find("&lt;b&gt; &amp; &quot;c&quot;"), std::string::npos) << svg;
}

}  // namespace
}  // namespace trephine::command_tests
