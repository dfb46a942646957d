// Findings of modules: against closed forms and the modules' own judges, with planted errors, stale
// judgements, and the reasons of findings that cannot be judged.
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "data-tools/phantoms/spine_phantom.h"
#include "modules/drilling/burr.h"
#include "modules/fluoroscopy/fluoroscopy.h"
#include "modules/laminectomy/laminectomy.h"
#include "modules/pedicle/pedicle.h"
#include "modules/skull_clamp/skull_clamp.h"
#include "modules/ventriculostomy/ventriculostomy.h"
#include "tests/modules/flap_vault.h"
#include "volume/cuts/removal.h"

namespace trephine {
namespace {

using glm::dvec3;
using sim::Finding;

/// Frozen input of findings, set by the tests.
struct Judged {
  haptics::TouchScene scene;
  sim::OperationState state;
  std::shared_ptr<volume::SurgicalPlan> plan = std::make_shared<volume::SurgicalPlan>();
  std::vector<std::shared_ptr<const sim::Forbidden>> forbidden;

  explicit Judged(volume::Volume scan, const volume::Shape& shape = {"bone", 300})
      : scene(scenes::scene_of(std::move(scan), {}, shape)) {
    state.undoable.version = std::make_shared<const volume::Version>(scene.base);
    state.plan = plan;
    state.dt = 1e-3;
  }
  template <class T>
  void set_undoable(const T& value) {
    state.undoable.modules = {std::make_shared<const sim::Value>(value)};
  }
  template <class T>
  void set_settings(const T& value) {
    state.settings.modules = {std::make_shared<const sim::Value>(value)};
  }
  template <class T>
  void set_result(const T& value) {
    state.settings.results = {{std::make_shared<const sim::Value>(value), 0}};
  }
  std::vector<Finding> of(const sim::Module& module) const {
    return module.findings({state, scene, haptics::solids_of(scene), forbidden});
  }
};

const Finding& find(const std::vector<Finding>& all, const std::string& name) {
  static const Finding missing{.name = "missing", .value = std::nan("")};
  const auto found = std::find_if(all.begin(), all.end(), [&](const Finding& f) { return f.name == name; });
  EXPECT_NE(found, all.end()) << name;
  return found == all.end() ? missing : *found;
}
double value(const std::vector<Finding>& all, const std::string& name) {
  const Finding& finding = find(all, name);
  EXPECT_TRUE(finding.value.has_value()) << name << ": " << finding.reason;
  return finding.value.value_or(std::nan(""));
}
void expect_reason(const std::vector<Finding>& all, const std::string& name, const std::string& words) {
  const Finding& finding = find(all, name);
  EXPECT_FALSE(finding.value.has_value()) << name;
  EXPECT_NE(finding.reason.find(words), std::string::npos) << name << ": " << finding.reason;
  EXPECT_TRUE(finding.reason.ends_with(".")) << finding.reason;
}

/// Returns a volume whose voxels and labels are functions of the world position.
template <class Hounsfield, class Label>
volume::Volume labelled(const dvec3& low, const dvec3& high, const dvec3& spacing,
                        const Hounsfield& hounsfield, const std::vector<std::string>& names,
                        const Label& label) {
  const volume::Volume scan = scenes::sampled(low, high, spacing, hounsfield);
  volume::Volume all = volume::make_volume(scan.size, scan.frame, true).value();
  all.is_hounsfield = true;
  all.label_names = names;
  for (int z = 0; z < scan.size.z; ++z)
    for (int y = 0; y < scan.size.y; ++y)
      for (int x = 0; x < scan.size.x; ++x) {
        const std::size_t i = scan.index(x, y, z);
        all.voxels[i] = scan.voxels[i];
        all.labels[i] = static_cast<std::uint8_t>(label(scan.frame.world_from_volume(dvec3(x, y, z))));
      }
  return all;
}

volume::Volume plain_bone() {
  return scenes::sampled({-4, -4, -4}, {4, 4, 4}, dvec3(1), [](const dvec3& p) { return p.z < 0 ? 800 : 0; });
}

TEST(Findings, AnUnusedModuleHasNoFindings) {
  Judged judged(plain_bone());
  const auto expect_none = [&](const sim::Module& module) {
    EXPECT_TRUE(judged.of(module).empty()) << module.name();  // without a state of the module
    const sim::Value undoable = module.undoable(), settings = module.settings(), result = module.result();
    if (!undoable.is_empty()) judged.state.undoable.modules = {std::make_shared<const sim::Value>(undoable)};
    if (!settings.is_empty()) judged.state.settings.modules = {std::make_shared<const sim::Value>(settings)};
    if (!result.is_empty()) judged.state.settings.results = {{std::make_shared<const sim::Value>(result), 0}};
    EXPECT_TRUE(judged.of(module).empty()) << module.name();  // with the initial state of the module
  };
  expect_none(bone_flap::BoneFlap());
  expect_none(laminectomy::Laminectomy());
  expect_none(pedicle::Pedicle());
  expect_none(ventriculostomy::Ventriculostomy());
  expect_none(skull_clamp::SkullClamp());
  expect_none(fluoroscopy::Fluoroscopy());
  expect_none(drilling::Drilling());
}

// Bone flap.

constexpr double k_ball = 6;
const dvec3 k_ball_centre(4, 0, 58);

TEST(Findings, AFlapIsComparedWithItsTargetsAndTheNearestOutline) {
  using namespace bone_flap;
  const Vault vault(labelled({-30, -30, 45}, {30, 30, 82}, dvec3(0.6), Vault::shell, {"", "tumour"},
                             [](const dvec3& p) { return glm::distance(p, k_ball_centre) <= k_ball; }),
                    6.5);
  sim::Lockstep run = vault.run();
  const Outline outline(14, 12);
  ASSERT_EQ(cut(run, outline.request()), "");
  auto state = *run.engine().snapshot();
  auto plan = std::make_shared<volume::SurgicalPlan>();
  state.plan = plan;
  const auto findings = [&] { return BoneFlap().findings({state, vault.scene, {}, {}}); };
  expect_reason(findings(), "flap: exposed part of the target", "no target");
  expect_reason(findings(), "flap: distance from plan", "no outline");
  plan->targets = {{"lesion", "tumour"}, {"other", "aneurysm"}};
  plan->outlines.push_back({.name = "far", .points_world = Outline(20, 12).anchors});
  plan->outlines.push_back({.name = "near", .points_world = Outline(16, 12).anchors});
  const auto all = findings();
  const double apothem = k_outer * std::sin(outline.polar) * std::cos(k_pi / outline.count);
  EXPECT_NEAR(value(all, "flap: exposed part of lesion"), 100, 0.01);
  EXPECT_NEAR(value(all, "flap: margin around lesion"),
              apothem - k_ball_centre.x - k_ball - 0.5 * width_of(Saw::w1_6), 0.7);
  expect_reason(all, "flap: exposed part of other", "lacks the label");
  EXPECT_NEAR(value(all, "flap: distance from plan"),
              k_outer * (std::sin(16 * k_pi / 180) - std::sin(14 * k_pi / 180)), 1.0);
  EXPECT_GE(value(all, "flap: largest distance from plan"), value(all, "flap: distance from plan"));
  // An undo removes the flap and its findings.
  run.apply_and_finish({sim::Undo{}, 0});
  EXPECT_TRUE(BoneFlap().findings({*run.engine().snapshot(), vault.scene, {}, {}}).empty());
}

// Laminectomy and pedicle screws.

/// The spine phantom. open_roof() removes the bone behind the canal of L4.
struct Spine {
  Judged judged;
  explicit Spine(double spacing = 1.2) : judged(phantom(spacing), {"bone", 140}) {}
  static volume::Volume phantom(double spacing) {
    data_tools::PhantomOptions options;
    options.spacing_mm = dvec3(spacing);
    return data_tools::make_phantom("spine", options).value();
  }
  const volume::Field& bone() const { return judged.scene.items[0].field; }
  int l4() const { return judged.scene.base->label_value("L4"); }
  /// Sweeps balls of 4 mm radius along the roof of the canal of L4.
  void open_roof() {
    const auto base = judged.scene.base;
    const auto lattice =
        volume::CutLattice::for_burr(*base, std::max(4.5, volume::CutLattice::smallest_burr_mm(*base)));
    volume::RemovalEditor editor(std::make_shared<const volume::Version>(base, lattice.value()), {bone()});
    const data_tools::SpinePhantom spine(1);
    for (double x = -6; x <= 6; x += 4)
      for (double y = 36; y <= 44; y += 4)
        editor.remove(volume::Sweep{spine.world_point(1, {x, y, -14}), spine.world_point(1, {x, y, 14}), 4});
    judged.state.undoable.version = editor.freeze();
  }
};

TEST(Findings, ALaminectomyIsJudgedAgainAfterItsJudgement) {
  using namespace laminectomy;
  Spine spine(1.6);
  const auto before = judge(spine.bone(), spine.l4(), nullptr, *spine.judged.state.undoable.version);
  ASSERT_TRUE(before) << before.error().reason;
  // The operation has stored a judgement of the intact vertebra. The findings must judge the current anatomy.
  const Judgement stored = judgement_of(before.value(), "L4");
  spine.judged.set_result(stored);
  spine.judged.state.chronicle.add({1, 0, before.value().frame.middle, stored});
  EXPECT_EQ(value(spine.judged.of(Laminectomy()), "L4: canal gained"), 0);
  spine.open_roof();
  const auto after = judge(spine.bone(), spine.l4(), nullptr, *spine.judged.state.undoable.version);
  ASSERT_TRUE(after) << after.error().reason;
  const Judgement j = judgement_of(after.value(), "L4");
  ASSERT_GT(j.opened_length, 5);
  const auto all = spine.judged.of(Laminectomy());
  EXPECT_EQ(value(all, "L4: canal gained"), 100 * (j.canal_after - j.canal_before) / j.canal_before);
  EXPECT_EQ(value(all, "L4: opened length"), j.opened_length);
  EXPECT_EQ(value(all, "L4: left upper facet removed"), j.left_upper_facet);
  EXPECT_EQ(value(all, "L4: right lower facet removed"), j.right_lower_facet);
  EXPECT_EQ(value(all, "L4: left pars"), j.left_pars);
  EXPECT_EQ(value(all, "L4: right pars"), j.right_pars);
  // Without a stored judgement, the vertebra is found by the bone that was removed from its label.
  spine.judged.state.chronicle = {};
  spine.judged.set_result(Judgement{});
  const auto found = spine.judged.of(Laminectomy());
  EXPECT_EQ(found.size(), all.size());
  EXPECT_EQ(value(found, "L4: opened length"), j.opened_length);
  for (const Finding& finding : found) EXPECT_EQ(finding.name.rfind("L4", 0), 0u) << finding.name;
  // A judgement that failed is reported under the label of its request, with a reason.
  spine.judged.state.chronicle.add({1, 0, dvec3(0), JudgementFailed{"disc", "no"}});
  expect_reason(spine.judged.of(Laminectomy()), "disc: canal gained", "not judged");
}

TEST(Findings, ScrewsEqualTheirJudgeAndTheClosedFormOfThePlan) {
  using namespace pedicle;
  Spine spine;
  const data_tools::SpinePhantom phantom(1);
  const auto bone = find_bone(spine.judged.scene.base, spine.bone(), spine.l4(), nullptr);
  ASSERT_TRUE(bone) << bone.error().reason;
  const volume::VertebraFrame& frame = bone.value().zones.frame;
  // Screws in the vertebra's own frame, from the back to the front, next to the canal; x: mm to the left.
  const auto screw = [&](double x) { return Screw{frame.world({x, 18, 8}), frame.world({x, -22, 8}), 6}; };
  PedicleState state;
  const auto place = [&](const Screw& one, double track, double depth) {
    state.screw_bodies.push_back(sim::Id{static_cast<std::uint32_t>(state.screw_bodies.size() + 1)});
    state.screw_entries.push_back(one.entry_world), state.screw_tips.push_back(one.tip_world);
    state.screw_diameters.push_back(one.diameter), state.screw_tracks.push_back(track);
    if (track == 0) return;
    state.track_entries.push_back(one.entry_world), state.track_ends.push_back(one.tip_world);
    state.track_depths.push_back(depth), state.track_outside.push_back(track == 1 ? 0.7 : 0.0);
  };
  place(screw(15), 1, 37), place(screw(12), 0, 0), place(screw(-15), 2, 40);
  spine.judged.set_undoable(state);
  ScrewJudgements stale;  // an old judgement that the findings ignore
  stale.bodies = {sim::Id{1}}, stale.names = "L4 left\n";
  stale.breaches = {99}, stale.fronts = {99}, stale.grades = {4}, stale.scores = {0};
  spine.judged.set_result(stale);
  spine.judged.plan->trajectories.push_back({.name = "plan",
                                             .entry_world = frame.world({15, 18, 5}),
                                             .target_world = frame.world({15, -18, 8}),
                                             .side = "left",
                                             .vertebra = "L4"});
  const auto all = spine.judged.of(Pedicle());
  for (const auto& [name, index] :
       {std::pair<std::string, std::size_t>{"L4 left", 0}, {"L4 left 2", 1}, {"L4 right", 2}}) {
    const auto judged = judge(judged_screw(state, index), bone.value(), spine.judged.plan.get(), {});
    ASSERT_TRUE(judged) << judged.error().reason;
    EXPECT_EQ(value(all, name + ": breach"), std::max(0.0, judged.value().breach));
    EXPECT_EQ(value(all, name + ": grade"), static_cast<double>(judged.value().grade));
    EXPECT_EQ(value(all, name + ": body breach"), std::max(0.0, judged.value().front));
  }
  EXPECT_NEAR(value(all, "L4 left: entry to plan"), 3, 1e-9);
  EXPECT_NEAR(value(all, "L4 left: tip to plan"), 4, 1e-9);
  EXPECT_NEAR(value(all, "L4 left: angle to plan"), std::atan2(3.0, 36.0) * 180 / M_PI, 1e-6);
  EXPECT_NEAR(value(all, "L4 left: length to track"), 3, 1e-9);
  EXPECT_EQ(value(all, "tracks: beyond bone"), 0.7);
  expect_reason(all, "L4 left 2: length to track", "without a track");
  expect_reason(all, "L4 right: entry to plan", "no trajectory");
  // A screw 3 mm farther medially has a larger breach.
  EXPECT_GT(value(all, "L4 left 2: breach"), value(all, "L4 left: breach"));
}

TEST(Findings, AScrewWithoutALabelIsComparedWithThePlanOnly) {
  using namespace pedicle;
  Judged judged(plain_bone());
  PedicleState state;
  state.screw_bodies = {sim::Id{5}};
  state.screw_entries = {dvec3(0, 0, 0)}, state.screw_tips = {dvec3(0, 0, -3)};
  state.screw_diameters = {6}, state.screw_tracks = {0};
  judged.set_undoable(state);
  judged.plan->trajectories.push_back(
      {.name = "plan", .entry_world = {1, 0, 0}, .target_world = {0, 2, -3}, .side = "left"});
  const auto all = judged.of(Pedicle());
  expect_reason(all, "screw 1: breach", "add a label");
  EXPECT_EQ(value(all, "screw 1: entry to plan"), 1);
  EXPECT_EQ(value(all, "screw 1: tip to plan"), 2);
}

// Ventriculostomy.

const std::vector<std::string> k_layers{"", "dura", "brain", "ventricle_left", "ventricle_right", "sinus"};

/// A head in layers: bone from z = 0 down to -6 mm, dura to -7, brain to -30, and two ventricles below. A
/// sinus is at x > 6, below the bone down to z = -20.
Judged head() {
  Judged judged(labelled(
      {-15, -15, -45}, {15, 15, 5}, dvec3(0.5),
      [](const dvec3& p) { return 300 + 400 * std::min(-p.z, p.z + 6); }, k_layers,
      [](const dvec3& p) {
        if (p.x > 6 && p.z < -6 && p.z > -20) return 5;
        if (p.z > -6) return 0;
        if (p.z > -7) return 1;
        return p.z > -30 ? 2 : p.x > 0 ? 3 : 4;
      }));
  volume::Shape sinus{"sinus"};
  sinus.label = 5;
  judged.forbidden.push_back(sim::Forbidden::build(judged.scene.base, sinus).value());
  judged.plan->trajectories.push_back({"planned", {3, 0, 0}, {3, 0, -34}, 3, "ventriculostomy"});
  return judged;
}
ventriculostomy::CatheterPassages passages(std::int64_t count, const dvec3& start, const dvec3& tip) {
  ventriculostomy::CatheterPassages all;
  all.count = count;
  all.starts = {start}, all.tips = {tip}, all.directions = {glm::normalize(tip - start)}, all.hands = {0};
  return all;
}

TEST(Findings, ACatheterIsJudgedInClosedForm) {
  const ventriculostomy::Ventriculostomy module;
  Judged judged = head();
  ventriculostomy::CatheterJudged stale;
  stale.has_value = true, stale.target_error = 99;
  judged.set_result(stale);
  judged.set_settings(passages(2, {3, 3, -6}, {3, 3, -38}));
  auto all = judged.of(module);
  EXPECT_NEAR(value(all, "catheter: tip to target"), 5, 1e-9);
  EXPECT_NEAR(value(all, "catheter: entry to plan"), 3, 0.1);
  EXPECT_NEAR(value(all, "catheter: angle to plan"), 0, 1e-5);
  EXPECT_NEAR(value(all, "catheter: depth from outer table"), 38, 0.15);
  EXPECT_NEAR(value(all, "catheter: depth from dura"), 32, 0.3);
  EXPECT_NEAR(value(all, "catheter: length in ventricles"), 8, 0.3);
  EXPECT_EQ(value(all, "catheter: grade of the tip"), 1);
  EXPECT_EQ(value(all, "catheter: passages"), 2);
  EXPECT_EQ(value(all, "catheter: forbidden structures crossed"), 0);
  EXPECT_NEAR(value(all, "catheter: clearance of forbidden structures"), 3 - 1.5, 0.4);
  judged.set_settings(passages(1, {-3, 0, -6}, {-3, 0, -38}));  // the other ventricle
  EXPECT_EQ(value(judged.of(module), "catheter: grade of the tip"), 2);
  judged.set_settings(passages(1, {3, 0, -6}, {3, 0, -25}));  // the tip is in front of the ventricle
  EXPECT_EQ(value(judged.of(module), "catheter: grade of the tip"), 3);
  judged.set_settings(passages(1, {8, 0, -6}, {8, 0, -38}));  // through the sinus
  all = judged.of(module);
  EXPECT_EQ(value(all, "catheter: forbidden structures crossed"), 1);
  EXPECT_NE(find(all, "catheter: forbidden structures crossed").reason.find("sinus"), std::string::npos);
  // Reasons state the missing data.
  judged.plan->trajectories.clear();
  judged.forbidden.clear();
  all = judged.of(module);
  expect_reason(all, "catheter: tip to target", "no trajectory");
  expect_reason(all, "catheter: grade of the tip", "no trajectory");
  expect_reason(all, "catheter: forbidden structures crossed", "no forbidden structures");
  Judged plain(plain_bone());
  plain.set_settings(passages(1, {0, 0, 0}, {0, 0, -3}));
  expect_reason(plain.of(module), "catheter: tip to target", "no labels");
  EXPECT_EQ(plain.of(module).size(), all.size());
}

// Skull clamp.

constexpr dvec3 k_radii(76, 92, 72);  // mm
dvec3 on_shell(const dvec3& direction) { return direction / glm::length(direction / k_radii); }

TEST(Findings, AClampIsFittedAgainToItsCurrentPins) {
  const skull_clamp::SkullClamp module;
  Judged judged(scenes::sampled({-82, -98, -78}, {82, 98, 78}, dvec3(2), [](const dvec3& p) {
    const dvec3 q = p / k_radii, slope = q / k_radii;
    const double f = glm::length(q), d = f > 0 ? f * (f - 1) / glm::length(slope) : -70;
    return std::clamp(300 + 400 * std::min(-d, d + 6), -1000.0, 1600.0);
  }));
  skull_clamp::ClampPlan pins;
  // The pair is as far apart as the rocker is wide: 90 mm.
  const double x = k_radii.x * std::sqrt(1 - 45 * 45 / (k_radii.y * k_radii.y));
  pins.pins = {dvec3(-k_radii.x, 0, 0), dvec3(x, 45, 0)};
  judged.set_settings(pins);
  auto all = judged.of(module);
  ASSERT_EQ(all.size(), 1u);
  expect_reason(all, "clamp: fitted", "place the others");
  pins.pins.push_back({x, -45, 0});
  judged.set_settings(pins);
  skull_clamp::ClampFitted stale;  // the fit of other pins, which the findings ignore
  stale.is_fitted = true, stale.axis_miss = 99, stale.trouble = "old";
  judged.set_result(stale);
  all = judged.of(module);
  EXPECT_EQ(value(all, "clamp: fitted"), 1);
  EXPECT_EQ(value(all, "clamp: at a limit"), 0);
  EXPECT_NEAR(value(all, "clamp: least bone at a pin"), 6, 1.0);
  EXPECT_LT(value(all, "clamp: pin to its planned position"), 3);
  expect_reason(all, "clamp: largest height over the sweatband", "no sweatband");
  expect_reason(all, "clamp: pin to approach", "no approach");
  expect_reason(all, "clamp: clearance of forbidden structures", "no forbidden structures");
  judged.plan->planes.push_back({"sweatband", {0, 0, 0}, {0, 0, 1}});
  judged.plan->trajectories.push_back({"approach", on_shell({-1, 0.2, 0}), {0, 0, 0}, 3});
  all = judged.of(module);
  EXPECT_LT(value(all, "clamp: largest height over the sweatband"), 0.5);
  EXPECT_NEAR(value(all, "clamp: pin to approach"), glm::distance(on_shell({-1, 0.2, 0}), pins.pins[0]), 1);
  // A pin 15 mm higher.
  pins.pins[0] = on_shell({-1, 0, 0.2});
  judged.set_settings(pins);
  EXPECT_NEAR(value(judged.of(module), "clamp: largest height over the sweatband"), pins.pins[0].z, 1);
  // Two pins at one position cannot hold.
  pins.pins[2] = pins.pins[1];
  judged.set_settings(pins);
  all = judged.of(module);
  EXPECT_EQ(value(all, "clamp: fitted"), 0);
  EXPECT_NE(find(all, "clamp: fitted").reason.find("does not fit"), std::string::npos);
}

// Drilling and X-rays.

TEST(Findings, TheDeepestPlungeCounts) {
  Judged judged(plain_bone());
  for (const double plunge : {1.0, 3.5, 2.0})
    judged.state.chronicle.add({static_cast<std::uint64_t>(100 * plunge), 0, dvec3(plunge, 0, 0),
                                drilling::Breakthrough{2, plunge, 0.1}});
  const auto all = judged.of(drilling::Drilling());
  EXPECT_EQ(value(all, "drilling: deepest plunge"), 3.5);
  EXPECT_EQ(find(all, "drilling: deepest plunge").tick, std::uint64_t{350});
  EXPECT_EQ(value(all, "drilling: breakthroughs"), 3);
}

TEST(Findings, ShotsAreReportedWithoutPoints) {
  Judged judged(plain_bone());
  fluoroscopy::FluoroscopyState state;
  state.is_placed = true, state.shots = 4, state.seconds = 1.5, state.kerma = 0.2;
  judged.set_settings(state);
  const auto all = judged.of(fluoroscopy::Fluoroscopy());
  EXPECT_EQ(value(all, "X-ray: shots"), 4);
  EXPECT_EQ(value(all, "X-ray: time"), 1.5);
  const sim::Score score = sim::score(all, {});
  EXPECT_EQ(score.possible, 0);
}

// The score.

TEST(Findings, PointsAreLinearBetweenTheLimits) {
  const auto finding = [](double value) {
    return std::vector<Finding>{
        {.name = "a", .value = value, .unit = "mm", .full_at = 2, .zero_at = 10, .weight = 4}};
  };
  using Verdict = Finding::Verdict;
  for (const auto& [at, points, verdict] : {std::tuple{1.0, 4.0, Verdict::good},
                                            {2.0, 4.0, Verdict::good},
                                            {6.0, 2.0, Verdict::fair},
                                            {10.0, 0.0, Verdict::bad},
                                            {20.0, 0.0, Verdict::bad}}) {
    const sim::Score score = sim::score(finding(at), {});
    EXPECT_DOUBLE_EQ(score.points, points) << at;
    EXPECT_EQ(score.findings[0].verdict, verdict) << at;
    EXPECT_EQ(score.possible, 4);
    EXPECT_EQ(score.critical,
              verdict == Verdict::bad ? std::vector<std::string>{"a"} : std::vector<std::string>());
  }
  EXPECT_TRUE(sim::score(finding(20), {{"a", 2, 10, 3.9}}).critical.empty()) << "a weight below 4";
  // Limits of the plan replace those of a finding. A limit for a missing finding is listed as not judged.
  const sim::Score score = sim::score(finding(6), {{"a", 6, 8, 1}, {"b", 0, 1, 3}});
  EXPECT_EQ(score.points, 1);
  EXPECT_EQ(score.possible, 1);
  EXPECT_EQ(score.not_judged, 3);
  ASSERT_EQ(score.findings.size(), 2u);
  expect_reason(score.findings, "b", "no such finding");
}

}  // namespace
}  // namespace trephine
