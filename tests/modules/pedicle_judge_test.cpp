// Judgements of screws: a canal in a box with breaches in closed form, and the spine phantom against a brute
// force search of its exact bone, which shares no code with the judge.
#include <algorithm>
#include <array>

#include "data-tools/phantoms/spine_phantom.h"
#include "tests/modules/pedicle_bench.h"

namespace trephine::pedicle {
namespace {

// A canal in a box, whose walls are planes.

constexpr double k_canal = 11, k_front = 8;  // mm: half width of the canal, half of its depth
constexpr double k_wide = 10, k_high = 8;    // mm: width of a pedicle, half of its height
constexpr double k_plate = 16, k_body = 40;  // mm: outer side of the lamina, front of the body
const dvec3 k_shift(0.13, -0.21, 0.17);      // mm, of the box relative to the voxels

bool is_box_bone(const dvec3& world) {
  const dvec3 p = world - k_shift;
  const double x = std::abs(p.x), z = std::abs(p.z);
  if (p.y > k_plate || p.y < -k_body) return false;
  if (p.y < -k_front) return x < 25 && z < 14;               // body
  if (p.y > k_front) return x < 25 && z < k_high;            // lamina
  return x > k_canal && x < k_canal + k_wide && z < k_high;  // pedicles
}

struct Box {
  std::shared_ptr<const volume::Volume> scan;
  volume::Field bone;
  JudgedBone found;
  explicit Box(double spacing) {
    volume::Volume sampled = scenes::sampled({-29, -44, -18}, {29, 20, 18}, dvec3(spacing),
                                             [](const dvec3& p) { return is_box_bone(p) ? 800.0 : 0.0; });
    volume::Volume all = volume::make_volume(sampled.size, sampled.frame, true).value();
    std::copy(sampled.voxels.span().begin(), sampled.voxels.span().end(), all.voxels.data());
    for (std::size_t i = 0; i < all.labels.size(); ++i) all.labels[i] = all.voxels.data()[i] > 400;
    all.label_names = {"nothing", "box"};
    all.is_hounsfield = true;
    scan = std::make_shared<const volume::Volume>(std::move(all));
    bone = volume::Field(*scan, {"bone", 400});
    auto result = find_bone(scan, bone, 1, nullptr);
    EXPECT_TRUE(result) << (result ? "" : result.error().reason);
    if (result) found = std::move(result).value();
  }
};

/// A screw along the left pedicle that protrudes by `breach` mm through a wall.
Screw screw_through(Wall wall, double breach, double diameter) {
  const double r = 0.5 * diameter, middle = k_canal + 0.5 * k_wide;
  dvec3 entry(middle, k_plate, 0);
  if (wall == Wall::medial) entry.x = k_canal + r - breach;
  if (wall == Wall::lateral) entry.x = k_canal + k_wide - r + breach;
  if (wall == Wall::above) entry.z = k_high - r + breach;
  if (wall == Wall::below) entry.z = -k_high + r - breach;
  entry += k_shift;
  return {entry, entry + dvec3(0, -40, 0), diameter};
}

TEST(PedicleJudge, BreachesOfABoxAreExactToHalfAVoxel) {
  for (const double spacing : {0.4, 0.8}) {
    const Box box(spacing);
    ASSERT_NE(box.found.surface, nullptr);
    EXPECT_NEAR(box.found.zones.canal_front, k_front, 0.6);
    int flagged = 0;
    for (const Wall wall : {Wall::medial, Wall::lateral, Wall::above, Wall::below})
      for (const double breach : {-1.0, 1.9, 2.0, 2.1, 3.9, 4.0, 4.1, 5.9, 6.0, 6.1}) {
        SCOPED_TRACE(std::string(k_wall_names[static_cast<std::size_t>(wall)]) + " " +
                     std::to_string(breach) + " mm at " + std::to_string(spacing));
        const auto judged = judge({sim::Id{7}, screw_through(wall, breach, 7)}, box.found, nullptr, {});
        ASSERT_TRUE(judged) << judged.error().reason;
        const ScrewJudged& j = judged.value();
        EXPECT_EQ(j.side, BodySide::left);
        if (breach < 0) {
          EXPECT_LT(j.breach, 0);
          EXPECT_EQ(j.grade, Grade::a);
          EXPECT_EQ(j.wall, Wall::none);
          continue;
        }
        EXPECT_NEAR(j.breach, breach, 0.5 * spacing + 0.02);
        EXPECT_EQ(j.wall, wall);
        EXPECT_NEAR(j.half_voxel, 0.5 * spacing, 0.02);
        // The grade with exact bone lies between the grades with bone that is half a voxel larger and
        // smaller.
        const Grade exact = breach < 2 ? Grade::b : breach < 4 ? Grade::c : breach < 6 ? Grade::d : Grade::e;
        EXPECT_LE(j.grade_of_larger, exact);
        EXPECT_GE(j.grade_of_smaller, exact);
        EXPECT_TRUE(j.is_uncertain || j.grade == exact);
        flagged += j.is_uncertain;
        EXPECT_NEAR(j.breach_at.y, k_shift.y, 8);
      }
    EXPECT_GE(flagged, 24) << "a tenth of a millimetre is below the resolution of the scan";
    // Breaches that are 1 mm from the limits of grades are not flagged.
    for (const double clear : {1.0, 3.0, 5.0, 7.0}) {
      const auto judged = judge({sim::Id{7}, screw_through(Wall::medial, clear, 7)}, box.found, nullptr, {});
      ASSERT_TRUE(judged);
      EXPECT_FALSE(judged.value().is_uncertain) << clear;
    }
    // A screw that is 3 mm too long.
    Screw longer = screw_through(Wall::none, 0, 6);
    longer.tip_world = longer.entry_world + dvec3(0, -(k_plate + k_body + 3), 0);
    const auto front = judge({sim::Id{7}, longer}, box.found, nullptr, {});
    ASSERT_TRUE(front);
    EXPECT_NEAR(front.value().front, 3, 0.5 * spacing + 0.05);
    EXPECT_EQ(front.value().grade, Grade::a);
    // Core and shell of a screw in the middle of the pedicle are in bone of 800 HU.
    EXPECT_TRUE(front.value().has_intensity);
    EXPECT_NEAR(front.value().core_hu, 800, 60);
  }
}

/// Returns the signed distance to the bone of the box, mm; exact outside the bone.
double distance_to_box(const dvec3& world) {
  const dvec3 p = world - k_shift;
  const auto block = [&](const dvec3& low, const dvec3& high) {
    const dvec3 past = glm::max(low - p, p - high);
    return glm::length(glm::max(past, dvec3(0))) + std::min(0.0, std::max({past.x, past.y, past.z}));
  };
  return std::min({block({-25, -k_body, -14}, {25, -k_front, 14}),
                   block({-25, k_front, -k_high}, {25, k_plate, k_high}),
                   block({k_canal, -k_front, -k_high}, {k_canal + k_wide, k_front, k_high}),
                   block({-k_canal - k_wide, -k_front, -k_high}, {-k_canal, k_front, k_high})});
}

/// Returns the number of screws with a wrong grade or wall among 24 screws, whose breaches lie a tenth of a
/// millimetre from the limits of grades.
int wrong_verdicts(const VertebraZones& zones, const BoneDistance& distance) {
  int wrong = 0;
  for (const Wall wall : {Wall::medial, Wall::lateral, Wall::above, Wall::below})
    for (const double breach : {1.9, 2.1, 3.9, 4.1, 5.9, 6.1}) {
      const Breach found = find_breaches(screw_through(wall, breach, 7), zones, distance).pedicle;
      wrong += found.wall != wall || grade_of(found.mm) != grade_of(breach);
    }
  return wrong;
}

TEST(PedicleJudge, GradesAreExactWithTheExactBoneAndWrongWithPlantedFaults) {
  const VertebraZones zones = Box(0.4).found.zones;
  EXPECT_EQ(wrong_verdicts(zones, distance_to_box), 0);
  EXPECT_GE(wrong_verdicts(zones, [](const dvec3& p) { return distance_to_box(p) - 0.15; }), 12)
      << "bone that is 0.15 mm too large";
  EXPECT_GE(wrong_verdicts(zones, [](const dvec3& p) { return distance_to_box(p) + 0.15; }), 12)
      << "bone that is 0.15 mm too small";
  VertebraZones mirrored = zones;
  mirrored.frame.up = -mirrored.frame.up;
  EXPECT_GE(wrong_verdicts(mirrored, distance_to_box), 12) << "above and below exchanged";
}

TEST(PedicleJudge, ScoresByThePlan) {
  const Box box(0.8);
  const Screw screw = screw_through(Wall::none, 0, 6);
  volume::SurgicalPlan plan;
  const auto add = [&](const char* name, const char* side, const dvec3& entry, const dvec3& target) {
    volume::PlannedTrajectory& one = plan.trajectories.emplace_back();
    one.name = name, one.side = side, one.vertebra = "box", one.entry_world = entry,
    one.target_world = target;
  };
  add("far", "left", screw.entry_world + dvec3(0, 0, 9), screw.tip_world);
  add("near", "left", screw.entry_world + dvec3(0, 0, 3), screw.tip_world + dvec3(4, 0, 3));
  add("other", "right", screw.entry_world, screw.tip_world);
  const auto judged = judge({sim::Id{1}, screw, 36.0}, box.found, &plan,
                            {.trajectory_zero = 20, .depth_zero = 10, .trajectory_share = 0.5});
  ASSERT_TRUE(judged);
  const ScrewJudged& j = judged.value();
  EXPECT_EQ(j.planned, "near");
  EXPECT_NEAR(j.entry_error, 3, 1e-9);
  EXPECT_NEAR(j.target_error, 5, 1e-9);
  EXPECT_NEAR(j.angle_error, std::atan2(4, 40) * 180 / 3.14159265, 1e-3);
  EXPECT_NEAR(j.depth_error, 4, 1e-9);
  EXPECT_NEAR(j.score, 100 * (0.5 * (1 - 8.0 / 20) + 0.5 * (1 - 4.0 / 10)), 1e-6);
  // Without a track the trajectory alone counts; without a plan there is no score.
  const auto alone = judge({sim::Id{1}, screw}, box.found, &plan, {});
  EXPECT_NEAR(alone.value().score, 100 * (1 - 8.0 / 20), 1e-6);
  EXPECT_FALSE(judge({sim::Id{1}, screw}, box.found, nullptr, {}).value().has_score);
}

// The spine phantom.

constexpr int k_l4 = 1;

/// Returns the largest distance from the surface of a screw to the exact bone, where the screw passes the
/// canal. By brute force: twice as many points around and along the screw as in the judge, and rays from the
/// farthest points to the bone.
double brute_force_breach(const data_tools::SpinePhantom& spine, const dvec3& entry, const dvec3& tip,
                          double diameter) {
  const dvec3 origin = spine.world_point(k_l4, {0, 24, 0}),
              back = glm::normalize(spine.world_point(k_l4, {0, 25, 0}) - origin);
  const dvec3 along = glm::normalize(tip - entry), u = glm::normalize(glm::cross(along, dvec3(0, 0, 1))),
              v = glm::cross(along, u);
  const double length = glm::length(tip - entry),
               scale = glm::length(spine.world_point(k_l4, {0, 25, 0}) - origin);
  const auto outside = [&](const dvec3& p) {
    const auto all = spine.bone_distances(p);
    return all[k_l4];
  };
  std::vector<std::pair<double, dvec3>> far;
  for (double s = diameter; s < length - 0.8 * diameter; s += 0.1) {
    const double y = glm::dot(entry + s * along - origin, back);
    if (std::abs(y) > 8 * scale) continue;
    for (int i = 0; i < 144; ++i) {
      const double a = 2 * 3.14159265358979 * i / 144;
      const dvec3 p = entry + s * along + 0.5 * diameter * (std::cos(a) * u + std::sin(a) * v);
      if (const double d = outside(p); d > 0) far.emplace_back(d, p);
    }
  }
  std::sort(far.begin(), far.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  double worst = 0;
  for (std::size_t i = 0; i < std::min<std::size_t>(far.size(), 150); i += 3) {
    double nearest = 12;
    for (int k = 0; k < 200; ++k) {  // a spiral over the sphere
      const double z = 1 - 2 * (k + 0.5) / 200, turn = 2.39996323 * k, r = std::sqrt(1 - z * z);
      const dvec3 to(r * std::cos(turn), r * std::sin(turn), z);
      for (double t = 0.05; t < nearest; t += 0.05)
        if (outside(far[i].second + t * to) < 0) nearest = t;
    }
    worst = std::max(worst, nearest);
  }
  return worst;
}

TEST(PedicleJudge, AgreesWithBruteForceOnTheSpine) {
  constexpr double k_spacing = 0.8;
  data_tools::PhantomOptions options;
  options.spacing_mm = dvec3(k_spacing);
  options.parameters["noise"] = 20;
  const auto scan =
      std::make_shared<const volume::Volume>(data_tools::make_phantom("spine", options).value());
  const volume::Field bone(*scan, {"bone", 140});
  const data_tools::SpinePhantom spine(1);
  const auto found = find_bone(scan, bone, scan->label_value("L4"), nullptr);
  ASSERT_TRUE(found) << found.error().reason;
  const dvec3 left =
      glm::normalize(spine.world_point(k_l4, {1, 24, 0}) - spine.world_point(k_l4, {0, 24, 0}));
  int breached = 0;
  for (const data_tools::SpineScrew& planned : spine.screws()) {
    if (!planned.name.starts_with("L4") || !planned.name.ends_with("pedicle")) continue;
    const double side = planned.name.find("left") != std::string::npos ? 1 : -1;
    for (const double medial : {0.0, 3.0, 5.0, -4.0}) {
      SCOPED_TRACE(planned.name + " " + std::to_string(medial) + " mm medial");
      const dvec3 shift = -side * medial * left;
      const Screw screw{planned.entry_world + shift, planned.target_world + shift, 6};
      const auto judged = judge({sim::Id{1}, screw}, found.value(), nullptr, {});
      ASSERT_TRUE(judged) << judged.error().reason;
      const ScrewJudged& j = judged.value();
      EXPECT_EQ(j.side, side > 0 ? BodySide::left : BodySide::right);
      const double exact = brute_force_breach(spine, screw.entry_world, screw.tip_world, screw.diameter);
      EXPECT_NEAR(std::max(0.0, j.breach), exact, 0.5 * k_spacing + 0.2);
      if (exact > 0.5) {
        ++breached;
        EXPECT_EQ(j.wall, medial > 0 ? Wall::medial : Wall::lateral);
      }
      const Grade grade = grade_of(exact);
      EXPECT_TRUE(j.is_uncertain || j.grade == grade || std::abs(j.breach - exact) > 0.5 * k_spacing)
          << j.breach << " " << exact;
      if (medial == 0) {
        EXPECT_EQ(j.grade, Grade::a);
      }
    }
  }
  EXPECT_GE(breached, 4);
}

TEST(PedicleJudge, TheJobStoresItsJudgementUntilTheScrewIsGone) {
  const Box box(0.8);
  ProbeBench bench(scenes::scene_of(volume::copy_of(*box.scan).value(), {}, {"bone", 400}), {});
  for (int i = 0; i < 3; ++i) bench.run->step({{0, 60, 0}, {1, 0, 0, 0}, 0});
  EXPECT_TRUE(bench.run->apply({JudgeScrew{.vertebra = "box"}, 0}).refused.has_value()) << "no screw";
  const Screw screw = screw_through(Wall::medial, 3, 7);
  const PlaceScrew place{.entry = {screw.entry_world},
                         .target = {screw.tip_world},
                         .diameter = Diameter::d7,
                         .length = Length::l40,
                         .seconds = 0};
  ASSERT_FALSE(bench.run->apply_and_finish({place, 0}).refused);
  ASSERT_EQ(bench.run->engine().state().undoable.bodies.size(), 1u);
  ASSERT_FALSE(bench.run->apply_and_finish({JudgeScrew{.vertebra = "box"}, 0}).refused);
  ASSERT_FALSE(bench.run->apply_and_finish({JudgeScrew{}, 0}).refused);
  const auto judged = bench.events<ScrewJudged>();
  ASSERT_EQ(judged.size(), 2u);
  EXPECT_EQ(sim::Value(judged[0].first).words(), sim::Value(judged[1].first).words())
      << "without a label, the vertebra of the screw is found";
  EXPECT_NEAR(judged[0].first.breach, 3, 0.42);
  const auto measure = [&](const std::string& name) {
    for (const sim::Measure& one : bench.run->engine().measures())
      if (one.name == name) return one.value;
    return -1.0;
  };
  EXPECT_NEAR(measure("box left: breach"), 3, 0.42);
  EXPECT_EQ(measure("box left: grade"), 2);
  EXPECT_EQ(measure("worst screw grade"), 2);
  EXPECT_EQ(measure("screws judged"), 1);
  ASSERT_FALSE(bench.run->apply({RemoveScrew{}, 0}).refused);
  EXPECT_EQ(measure("box left: breach"), -1);
  EXPECT_EQ(measure("screws"), 0);
  EXPECT_EQ(measure("screws judged"), 0);
}

}  // namespace
}  // namespace trephine::pedicle
