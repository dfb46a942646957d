// Laminectomies are judged by the command laminectomy and by scripts, on the built-in spine and on a real
// spine with labels.
#include "apps/workbench/session_summary.h"
#include "tests/apps/command_fixture.h"
#include "tests/data-tools/file_helpers.h"
#include "tests/whole.h"

namespace trephine::command_tests {
namespace {

/// docs/examples/laminectomy.toml: the script meets its expectations, and the command judges its session.
TEST_F(Command, ALaminectomyIsPlayedJudgedAndReplayed) {
  write("l.toml", read(TREPHINE_SOURCE_DIR "/docs/examples/laminectomy.toml"));
  const Json played = json("run l.toml --record l.session");
  EXPECT_EQ(played["is_met"], true) << played.dump(1);
  const Json outcome = json("laminectomy l.session --vertebra L4 --slices o.png");
  EXPECT_GT(fs::file_size(folder_ / "o.png"), 50000u);
  EXPECT_GT(outcome["canal"]["now_mm2"].get<double>(), 1.08 * outcome["canal"]["before_mm2"].get<double>());
  EXPECT_LT(outcome["spinous_process"]["remaining_mm3"], 10);
  EXPECT_GE(outcome["opening"]["length_mm"], 18);
  // The error of this example: the opening extends too far to the left.
  EXPECT_LT(outcome["pars"][0]["now_mm"].get<double>(), outcome["pars"][1]["now_mm"].get<double>() - 1.5);
  ASSERT_EQ(outcome["facets"].size(), 4u);
  EXPECT_GT(outcome["facets"][1]["removed_percent"].get<double>(),
            outcome["facets"][3]["removed_percent"].get<double>() + 4);
  const Json& dura = outcome["forbidden"][0];
  EXPECT_EQ(dura["structure"], "dural_sac");
  EXPECT_GE(dura["nearest_mm"], 0);
  EXPECT_TRUE(dura["contacts"].empty());
  EXPECT_GE(outcome["breakthroughs"]["count"], 1);
  EXPECT_NE(run("timeline l.session").out.find("L4: canal"), std::string::npos);
  EXPECT_EQ(json("replay l.session --verify")["is_same"], true);
  // A window opens the session with a view from the back, and with the hand that works at the time: bone
  // cutter (0), burr (1) or Kerrison (2).
  const auto summary = workbench::summarize_session((folder_ / "l.session").string());
  ASSERT_TRUE(summary) << summary.error().message();
  ASSERT_TRUE(summary.value().work_position.has_value());
  EXPECT_GT(summary.value().work_position->y, 25);
  for (const auto& [seconds, hand] :
       {std::pair(0.0, 0), std::pair(3.0, 0), std::pair(68.0, 1), std::pair(90.0, 2)})
    EXPECT_EQ(summary.value().hand_at(static_cast<std::uint64_t>(250 * seconds)), hand) << seconds;
  std::size_t bites = 0;
  for (const auto& mark : summary.value().marks) {
    bites += mark.text.starts_with("Bite of");
    EXPECT_LE(mark.seconds, 141);
  }
  EXPECT_GE(bites, 20u);
  for (const auto& [arguments, words] : std::initializer_list<std::pair<std::string, std::string>>{
           {"", "no vertebra selected"},
           {"--canal 1,2", "X,Y,Z"},
           {"--vertebra L4 --until -1", "does not contain this time"}}) {
    const ProcessResult bad = run("laminectomy l.session " + arguments);
    EXPECT_EQ(bad.exit_code, 2) << arguments;
    EXPECT_NE(bad.err.find(words), std::string::npos) << arguments << "\n" << bad.err;
  }
  if (!runs_all_cases()) return;
  // Before the last column of bites, the left pars was as wide as the right pars.
  const Json earlier = json("laminectomy l.session --vertebra L4 --until 129.7");
  EXPECT_NEAR(earlier["pars"][0]["now_mm"].get<double>(), earlier["pars"][1]["now_mm"].get<double>(), 1);
  for (const auto& [arguments, words] : std::initializer_list<std::pair<std::string, std::string>>{
           {"--vertebra L9", "unknown label"},
           {"--vertebra L4 --until 500", "does not contain this time"},
           {"--vertebra L4 --slices l.session", "l.session"}}) {
    const ProcessResult bad = run("laminectomy l.session " + arguments);
    EXPECT_EQ(bad.exit_code, 2) << arguments;
    EXPECT_NE(bad.err.find(words), std::string::npos) << arguments << "\n" << bad.err;
  }
  // With the foot 3 mm deeper in the middle, contacts with the dural sac are reported with their slices.
  std::string script = read(file("l.toml"));
  for (std::size_t at = 0; (at = script.find(" 0, 34, ", at)) != std::string::npos;)
    script.replace(at, 8, " 0, 31, ");
  write("deep.toml", script);
  EXPECT_EQ(run("run deep.toml --record deep.session").exit_code, 1);
  const Json deep = json("laminectomy deep.session --vertebra L4")["forbidden"][0];
  EXPECT_LT(deep["nearest_mm"], -0.3);
  ASSERT_GE(deep["contacts"].size(), 1u);
  EXPECT_GT(deep["contacts"][0]["slice"], 50);
  EXPECT_LT(deep["contacts"][0]["slice"], 120);
  EXPECT_TRUE(json("laminectomy deep.session --vertebra L3")["forbidden"][0]["contacts"].empty());
  EXPECT_GT(fs::file_size(folder_ / "l.session"), 10000u);
}

/// Points of the path of a hand, which moves to each position in turn and presses its button there.
class Bites {
 public:
  void at(double x, double y, double z, double from_y) {
    add(0.0, x, from_y, z, 0), add(0.3, x, y, z, 0), add(0.1, x, y, z, 1), add(0.5, x, y, z, 1),
        add(0.1, x, y, z, 0), add(0.1, x, from_y, z, 0);
  }
  void add(double after, double x, double y, double z, int button) {
    t_ += after > 0 ? after : 0.05;
    text_ += (text_.empty() ? "[" : ", [") + std::to_string(t_) + "," + std::to_string(x) + "," +
             std::to_string(y) + "," + std::to_string(z) + "," + std::to_string(button) + "]";
  }
  void wait_for(const Bites& other) { t_ = std::max(t_, other.t_); }
  double end() const { return t_; }
  std::string hand(const std::string& instrument, const std::string& parameters) const {
    return "[[hands]]\ninstrument = \"" + instrument + "\"\nparameters = \"" + parameters +
           "\"\nshaft = [0, 1, 0]\npoints = [" + text_ + "]\n";
  }

 private:
  std::string text_;
  double t_ = 0;
};

TEST_F(Command, ALaminectomyOfARealSpine) {
  if (data_tools::real_data().empty()) GTEST_SKIP() << "no real data: set TREPHINE_DATA";
  import_real_spine(data_tools::real_data());
  Bites process, thinning, lamina;
  for (const double y : {-83.0, -90.0, -97.0})
    for (const double z : {270.0, 276.0, 282.0, 288.0, 293.0}) process.at(2.6, y, z, y + 8);
  thinning.wait_for(process);
  for (const double x : {-2.0, 7.0}) {
    thinning.add(0.1, x, -90, 290, 0), thinning.add(0.3, x, -104, 290, 1);
    thinning.add(3, x, -104, 274, 1), thinning.add(0.2, x, -90, 274, 0);
  }
  lamina.wait_for(thinning);
  for (const double x : {2.6, -1.4, 6.6}) {
    const double y = x == 2.6 ? -114.5 : -115;
    lamina.add(0.1, x, -40, 262, 0), lamina.add(0.3, x, y, 262, 0);
    for (double z = 274; z < 296; z += 3) lamina.at(x, y, z, y);
    lamina.add(0.1, x, y, 262, 0), lamina.add(0.3, x, -40, 262, 0);
  }
  write("l.toml", "schema = 1\nscan = \"real\"\nrate = 250\n" +
                      process.hand("rongeur", "kind=rongeur width=8 opening=20 most=900") +
                      thinning.hand("burr", "diameter=6") +
                      lamina.hand("rongeur", "kind=kerrison width=5 opening=20 most=400") +
                      "[[do]]\nat = " + std::to_string(lamina.end() + 0.2) +
                      "\ncommand = \"judge-laminectomy\"\n"  // judges the vertebra that was cut
                      "[[expect]]\nwhat = \"canal\"\nleast = 305\n"
                      "[[expect]]\nwhat = \"opened length\"\nleast = 8\n");
  const Json played = json("run l.toml --record l.session");
  EXPECT_EQ(played["is_met"], true) << played.dump(1);
  const Json outcome = json("laminectomy l.session --scan real --vertebra vertebrae_L4 --slices o.png");
  EXPECT_NEAR(outcome["canal"]["before_mm2"].get<double>(), 299, 6);
  EXPECT_GT(outcome["canal"]["now_mm2"], 305);
  EXPECT_LT(outcome["spinous_process"]["remaining_mm3"].get<double>(),
            0.3 * outcome["spinous_process"]["before_mm3"].get<double>());
  for (const Json& facet : outcome["facets"]) EXPECT_LT(facet["removed_percent"], 3);
  for (const Json& pars : outcome["pars"]) EXPECT_GT(pars["now_mm"], 10);
  if (!runs_all_cases()) return;
  // The canals of the other vertebrae have areas in the anatomical range, 150 to 400 mm². The sacrum is
  // refused.
  for (const std::string label : {"L5", "L3", "L2", "L1", "T12"}) {
    const double area =
        json("laminectomy l.session --scan real --vertebra vertebrae_" + label)["canal"]["before_mm2"];
    EXPECT_GT(area, 150) << label;
    EXPECT_LT(area, 400) << label;
  }
  EXPECT_EQ(run("laminectomy l.session --scan real --vertebra vertebrae_S1").exit_code, 2);
}

}  // namespace
}  // namespace trephine::command_tests
