#include "modules/bone_flap/evaluation.h"
#include "modules/bone_flap/freehand.h"
#include "modules/bone_flap/judgement.h"
#include "tests/modules/flap_vault.h"

namespace trephine::bone_flap {
namespace {

constexpr double k_ball = 6;          // mm, radius of the labelled target
const dvec3 k_ball_centre(4, 0, 58);  // mm, world

/// A vault with a labelled ball below its top, and a plan with one outline.
struct Case {
  std::shared_ptr<volume::SurgicalPlan> plan = std::make_shared<volume::SurgicalPlan>();
  Vault vault;

  explicit Case(double spacing = 0.6) : vault(labelled(spacing), 6.5) {
    plan->outlines.push_back({.name = "planned flap", .points_world = Outline(14, 12).anchors});
    plan->targets.push_back({"tumour", "tumour"});
  }
  static volume::Volume labelled(double spacing) {
    volume::Volume scan = scenes::sampled({-30, -30, 45}, {30, 30, 82}, dvec3(spacing),
                                          [](const dvec3& p) { return Vault::shell(p); });
    volume::Volume with_labels = volume::make_volume(scan.size, scan.frame, true).value();
    with_labels.is_hounsfield = true;
    with_labels.label_names = {"", "tumour"};
    for (int z = 0; z < scan.size.z; ++z)
      for (int y = 0; y < scan.size.y; ++y)
        for (int x = 0; x < scan.size.x; ++x) {
          const std::size_t i = scan.index(x, y, z);
          with_labels.voxels[i] = scan.voxels[i];
          const dvec3 p = scan.frame.world_from_volume(dvec3(x, y, z));
          with_labels.labels[i] = glm::distance(p, k_ball_centre) <= k_ball;
        }
    return with_labels;
  }
  sim::Lockstep run() const {
    static const BoneFlap module;
    static const sim::Catalogue catalogue({&module});
    std::vector<sim::HandStart> hands;
    hands.push_back({haptics::ServoHand(haptics::borrowed(vault.scene), haptics::borrowed(*vault.method),
                                        haptics::TouchState(nullptr)),
                     {}});
    return sim::Lockstep(sim::Engine(std::move(hands), 1e-3, catalogue, {}, plan), {}, 1000);
  }
};

/// Area common to two circles of radii `a` and `b`, whose centres are `d` apart.
double lens(double a, double b, double d) {
  const double at = (d * d + a * a - b * b) / (2 * d), rest = d - at;
  return a * a * std::acos(at / a) - at * std::sqrt(a * a - at * at) + b * b * std::acos(rest / b) -
         rest * std::sqrt(b * b - rest * rest);
}

double measure(const sim::Engine& engine, const std::string& name) {
  for (const sim::Measure& m : engine.measures())
    if (m.name == name && !m.is_stale) return m.value;
  return std::nan("");
}

/// A flap that was cut along an outline is measured again on the detached piece alone, as one that was cut by
/// hand.
TEST(FlapJudgement, AFlapCutByHandIsMeasuredOnItsPiece) {
  for (const double spacing : {0.5, 0.9}) {
    const Case scene(spacing);
    sim::Lockstep run = scene.run();
    ASSERT_FALSE(run.apply_and_finish({CutFlap{.outline = "planned flap"}, 0}).refused);
    const sim::OperationState& state = run.engine().state();
    const FlapState& cut = *state.undoable_of<FlapState>();
    ASSERT_EQ(state.undoable.bodies.size(), 1u);
    EXPECT_EQ(freehand_piece(state), nullptr) << "a command cut it";
    const FlapState measured = flap_of_piece(*state.undoable.bodies[0].piece, {0, 0, 0});
    const OutlineDistance distance = distance_between(measured.outline, cut.outline);
    SCOPED_TRACE(spacing);
    EXPECT_LT(distance.mean, 0.6);
    EXPECT_LT(distance.worst, 1.6);
    EXPECT_GT(glm::dot(measured.normal, cut.normal), std::cos(0.05));
    // The area of the cut extends to the middle of the kerf, that of the piece to its edge.
    const double margin = 0.5 * cut.width * shape_of(cut).perimeter;
    EXPECT_NEAR(measured.area, cut.area - margin, 0.03 * cut.area);
    EXPECT_NEAR(shape_of(measured).length, shape_of(cut).length, 0.8);
    const auto from_plan = distance_from_nearest(measured, *scene.plan),
               exact = distance_from_nearest(cut, *scene.plan);
    EXPECT_NEAR(from_plan->mean, exact->mean, 0.4);
    EXPECT_TRUE(clearances_of(measured, {}).empty());
    // No sector of the outline reaches into the flap.
    EXPECT_NEAR(shape_of(measured).perimeter, shape_of(cut).perimeter, 0.06 * shape_of(cut).perimeter);
    EXPECT_GT(shape_of(measured).roundness, 0.9 * shape_of(cut).roundness);
  }
}

TEST(FlapJudgement, APlannedOutlineIsPreviewedAndCutByItsName) {
  const Case scene;
  sim::Lockstep run = scene.run();
  const sim::Outcome unknown = run.apply_and_finish({CutFlap{.outline = "other"}, 0});
  ASSERT_TRUE(unknown.refused);
  EXPECT_NE(unknown.refused->message().find("planned flap"), std::string::npos) << unknown.refused->message();
  EXPECT_FALSE(run.apply_and_finish({PreviewFlap{}, 0}).refused);
  EXPECT_EQ(measure(run.engine(), "previews"), 1) << "the only outline of the plan";
  const CutFlap both{.outline = "planned flap", .anchors = Outline(10, 6).anchors};
  EXPECT_TRUE(run.apply_and_finish({both, 0}).refused) << "a request with both an outline and anchors";
  EXPECT_FALSE(run.apply_and_finish({PreviewFlap{.outline = "planned flap"}, 0}).refused);
  EXPECT_EQ(measure(run.engine(), "previews"), 1);
  const double height = Outline(14, 12).height;
  ASSERT_EQ(cut(run, CutFlap{.outline = "planned flap", .distance = height}), "");
  EXPECT_FALSE(run.apply_and_finish({JudgeFlap{}, 0}).refused);
  // The samples of the cut lie on the lines of the saw, 0.5 mm apart.
  EXPECT_LT(measure(run.engine(), "distance from planned outline"), 0.1);
  EXPECT_NEAR(measure(run.engine(), "flap area") / Outline(14, 12).area(), 1, 0.01);
}

TEST(FlapJudgement, EqualsTheClosedFormOfABallUnderTheOpening) {
  const Case scene;
  sim::Lockstep run = scene.run();
  const Outline outline(14, 12);
  ASSERT_EQ(cut(run, outline.request()), "");
  ASSERT_FALSE(run.apply_and_finish({JudgeFlap{"tumour", "planned flap"}, 0}).refused);
  const auto judged = events_of<FlapJudged>(run.engine());
  ASSERT_EQ(judged.size(), 1u);
  const FlapJudged& j = judged[0].first;
  ASSERT_TRUE(j.has_target && j.has_plan);
  // The radius of the opening's inscribed circle is the apothem of the polygon of anchors. The centre of the
  // flap lies over the origin.
  const double apothem = k_outer * std::sin(outline.polar) * std::cos(k_pi / outline.count);
  EXPECT_NEAR(j.exposed, 100, 0.01);
  EXPECT_NEAR(j.margin, apothem - k_ball_centre.x - k_ball - 0.5 * width_of(Saw::w1_6), 0.7);
  EXPECT_NEAR(j.depth, judged[0].second.z - k_ball_centre.z - k_ball, 0.6);
  EXPECT_LT(j.plan_worst, 0.1);
  EXPECT_NEAR(j.length, 2 * k_outer * std::sin(outline.polar), 0.5);
  EXPECT_EQ(measure(run.engine(), "target margin"), j.margin);
  // Without names: the target of the plan, and the nearest outline.
  ASSERT_FALSE(run.apply_and_finish({JudgeFlap{}, 0}).refused);
  EXPECT_EQ(sim::Value(events_of<FlapJudged>(run.engine())[1].first).words(), sim::Value(j).words());
  // A smaller flap exposes only a part of the ball: the circles of the ball and of the opening overlap in
  // part. `opening`: radius of the circle with the area of the polygon, less half of the saw's width.
  sim::Lockstep small = scene.run();
  ASSERT_EQ(cut(small, Outline(6, 12).request()), "");
  ASSERT_FALSE(small.apply_and_finish({JudgeFlap{"tumour", "planned flap"}, 0}).refused);
  const FlapJudged smaller = events_of<FlapJudged>(small.engine())[0].first;
  const double opening =
      k_outer * std::sin(6 * k_pi / 180) * std::sqrt(12 / (2 * k_pi) * std::sin(k_pi / 6)) -
      0.5 * width_of(Saw::w1_6);
  EXPECT_NEAR(smaller.exposed, 100 * lens(opening, k_ball, k_ball_centre.x) / (k_pi * k_ball * k_ball), 2);
  EXPECT_LT(smaller.margin, 0);
  // Concentric outlines are at most the difference of their radii apart, seen from the apex.
  EXPECT_NEAR(smaller.plan_mean, k_outer * (std::sin(14 * k_pi / 180) - std::sin(6 * k_pi / 180)), 1.0);
}

TEST(FlapJudgement, DistanceOfAPlanOnTheOppositeSideIsThatAcrossTheSkull) {
  const Case scene;
  std::vector<dvec3> opposite = Outline(14, 12).anchors;
  for (dvec3& p : opposite) p.z = -p.z;
  sim::Lockstep run = scene.run();
  ASSERT_EQ(cut(run, Outline(14, 12).request()), "");
  ASSERT_FALSE(run.apply_and_finish({JudgeFlap{"", "", opposite}, 0}).refused);
  const FlapJudged j = events_of<FlapJudged>(run.engine())[0].first;
  const double across = 2 * k_outer * std::cos(14 * k_pi / 180);
  EXPECT_NEAR(j.plan_mean, across, 1.5);
  EXPECT_NEAR(j.plan_worst, across, 2);
}

TEST(FlapJudgement, InvalidRequestsAreRefusedWithARemedy) {
  const Case scene;
  sim::Lockstep run = scene.run();
  const auto refusal = [&](const JudgeFlap& request) {
    const sim::Outcome outcome = run.apply_and_finish({request, 0});
    return outcome.refused ? outcome.refused->message() : std::string();
  };
  EXPECT_NE(refusal({}).find("no bone flap"), std::string::npos);
  ASSERT_EQ(cut(run, Outline(10, 8).request()), "");
  EXPECT_NE(refusal({"aneurysm", ""}).find("unknown label"), std::string::npos);
  const std::string outline = refusal({"", "other"});
  EXPECT_NE(outline.find("unknown outline"), std::string::npos);
  EXPECT_NE(outline.find("planned flap"), std::string::npos) << outline;
  EXPECT_TRUE(events_of<FlapJudged>(run.engine()).empty());
}

// A judgement belongs to its flap: an undo or another flap removes its measures.
TEST(FlapJudgement, BelongsToItsFlap) {
  const Case scene;
  sim::Lockstep run = scene.run();
  ASSERT_EQ(cut(run, Outline(10, 8).request()), "");
  EXPECT_TRUE(std::isnan(measure(run.engine(), "flap length")));
  ASSERT_FALSE(run.apply_and_finish({JudgeFlap{}, 0}).refused);
  const double length = measure(run.engine(), "flap length");
  EXPECT_GT(length, 20);
  run.apply_and_finish({sim::Undo{}, 0});
  EXPECT_TRUE(std::isnan(measure(run.engine(), "flap length")));
  ASSERT_EQ(cut(run, Outline(12, 8).request()), "");
  EXPECT_TRUE(std::isnan(measure(run.engine(), "flap length"))) << "the judgement is of the previous flap";
}

}  // namespace
}  // namespace trephine::bone_flap
