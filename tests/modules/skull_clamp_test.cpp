// Skull clamps: poses and measures against closed forms on an ellipsoid shell, limits, planted errors, and
// the built-in heads.
// One file: all of its tests use the head and the pins on the shell.
#include "modules/skull_clamp/skull_clamp.h"

#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <map>
#include <random>

#include "apps/bench/scenes/scenes.h"
#include "data-tools/phantoms/head_landmarks.h"
#include "haptics/methods/methods.h"
#include "modules/skull_clamp/clamp_surface.h"
#include "sim/drivers/lockstep.h"
#include "volume/surface/surface_facts.h"

namespace trephine::skull_clamp {
namespace {

using glm::dvec3;

constexpr dvec3 k_radii(76, 92, 72);  // mm, of the shell's outer surface
constexpr double k_thickness = 6, k_width = 90, k_degree = M_PI / 180;

/// Returns the signed distance to an ellipsoid around the origin, mm, to first order near its surface.
double shell_distance(const dvec3& p) {
  const dvec3 q = p / k_radii, slope = q / k_radii;
  const double f = glm::length(q);
  return f > 0 ? f * (f - 1) / glm::length(slope) : -70;
}

/// Returns the point of the ellipsoid in a direction.
dvec3 on_shell(const dvec3& direction) { return direction / glm::length(direction / k_radii); }

/// An operation with a clamp on the shell. `thin`: mm by which the shell is thinner where x > 0 and y > 0.
struct Head {
  haptics::TouchScene scene;
  std::unique_ptr<haptics::ProxyMethod> method = haptics::make_method("subvoxel").value();
  std::shared_ptr<volume::SurgicalPlan> plan = std::make_shared<volume::SurgicalPlan>();
  std::vector<std::shared_ptr<const sim::Forbidden>> forbidden;

  explicit Head(double thin = 0) : Head(shell(thin)) {
    plan->planes.push_back({"sweatband", {0, 0, 0}, {0, 0, 1}});
    plan->landmarks.push_back({"skull centre", {0, 0, 0}});
    plan->trajectories.push_back({"approach", on_shell({0, -0.5, 1}), {0, 0, 0}, 3});
  }
  explicit Head(volume::Volume scan) : scene(scenes::scene_of(std::move(scan))) {
    EXPECT_FALSE(method->prepare(scene).has_value());
  }
  static volume::Volume shell(double thin) {
    return scenes::sampled({-81, -97, -77}, {81, 97, 77}, dvec3(1.5), [thin](const dvec3& p) {
      const double d = shell_distance(p), wall = k_thickness - (p.x > 0 && p.y > 0 ? thin : 0.0);
      return std::clamp(300 + 400 * std::min(-d, d + wall), -1000.0, 1600.0);
    });
  }
  sim::Lockstep run() const {
    static const SkullClamp module;
    static const sim::Catalogue catalogue({&module});
    std::vector<sim::HandStart> hands;
    hands.push_back({haptics::ServoHand(haptics::borrowed(scene), haptics::borrowed(*method),
                                        haptics::TouchState(nullptr)),
                     {}});
    return sim::Lockstep(sim::Engine(std::move(hands), 1e-3, catalogue, forbidden, plan), {}, 1000);
  }
};

std::string refusal(sim::Lockstep& run, const sim::Command& command) {
  const sim::Outcome outcome = run.apply_and_finish(command);
  return outcome.refused ? outcome.refused->message() : std::string();
}
void place(sim::Lockstep& run, const Pins& pins) {
  ASSERT_EQ(refusal(run, {ClearPins{}, 0}), "");
  for (const dvec3& p : pins) ASSERT_EQ(refusal(run, {PlacePin{p}, 0}), "");
}
const ClampFitted& fitted(const sim::Lockstep& run) { return *run.engine().state().result_of<ClampFitted>(); }
ClampFitted fit(sim::Lockstep& run, const Pins& pins, const FitClamp& request = {}) {
  place(run, pins);
  EXPECT_EQ(refusal(run, {request, 0}), "");
  return fitted(run);
}
std::string failure(const sim::Lockstep& run) {
  const sim::Chronicle& chronicle = run.engine().state().chronicle;
  for (std::size_t i = chronicle.size(); i-- > 0;)
    if (const auto* failed = chronicle[i].value.as<ClampFailed>()) return failed->reason;
  return {};
}

/// Returns pins on the shell. Pin 1 is in direction `first`. Pins 2 and 3 are on both sides of the direction
/// `middle`, in the plane of `middle` and `side`, and `apart` mm apart; pin 2 is at `angle` degrees from
/// `middle`.
Pins pins_on_shell(const dvec3& first, const dvec3& middle, const dvec3& side, double angle,
                   double apart = k_width) {
  const auto at = [&](double degrees) {
    return on_shell(std::cos(degrees * k_degree) * middle + std::sin(degrees * k_degree) * side);
  };
  const dvec3 second = at(angle);
  double low = -80, high = angle;
  for (int i = 0; i < 100; ++i) {
    const double between = 0.5 * (low + high);
    (glm::distance(at(between), second) > apart ? low : high) = between;
  }
  return {on_shell(first), second, at(low)};
}
/// The pins of a clamp across the head, level with the sweatband.
Pins level_pins() {
  const double y = 0.5 * k_width, x = k_radii.x * std::sqrt(1 - y * y / (k_radii.y * k_radii.y));
  return {dvec3(-k_radii.x, 0, 0), dvec3(x, y, 0), dvec3(x, -y, 0)};
}

/// Returns the measures by their names.
std::map<std::string, double> measures(const sim::Lockstep& run) {
  std::map<std::string, double> all;
  for (const sim::Measure& m : run.engine().measures()) all[m.name] = m.value;
  return all;
}

TEST(Clamp, IsFoundWithinATenthOfAMillimetreOfKnownPoses) {
  const Head head;
  sim::Lockstep run = head.run();
  std::mt19937 random(5);
  std::uniform_real_distribution<double> jitter(-0.25, 0.25), turn(-0.6, 0.6), angle(26, 38);
  for (int n = 0; n < 12; ++n) {
    SCOPED_TRACE(n);
    const dvec3 middle = glm::normalize(dvec3(1, jitter(random), jitter(random)));
    dvec3 side(0, std::cos(turn(random)), std::sin(turn(random)));
    side = glm::normalize(side - glm::dot(side, middle) * middle);
    const Pins pins = pins_on_shell({-1, jitter(random), jitter(random)}, middle, side, angle(random));
    // In closed form, the axis leads from pin 1 to the middle of the pair.
    const dvec3 end = 0.5 * (pins[1] + pins[2]), axis = glm::normalize(end - pins[0]);
    const double swing = std::asin(glm::dot(glm::normalize(pins[1] - pins[2]), axis)) / k_degree;
    ASSERT_LT(std::abs(swing), 25);
    const ClampFitted f = fit(run, pins);
    ASSERT_TRUE(f.is_fitted) << failure(run);
    EXPECT_EQ(f.trouble, "");
    for (std::size_t i = 0; i < k_pins; ++i) {
      EXPECT_LT(glm::distance(f.tips[i], pins[i]), 0.1) << i;
      EXPECT_LT(f.residuals[i], 0.1);
      EXPECT_LT(std::abs(f.gaps[i]), 0.1);
      // The angle to the surface follows from the gradient of the ellipsoid, the thickness of bone along the
      // pin from small steps through the shell.
      const dvec3 direction = i == 0 ? axis : pose_of(f).directions_world()[i];
      const dvec3 normal = glm::normalize(pins[i] / k_radii / k_radii);
      EXPECT_NEAR(f.angles[i], 90 - std::acos(-glm::dot(normal, direction)) / k_degree, 1.5);
      double bone = 0;
      while (shell_distance(pins[i] + (bone + 0.5) * direction) > -k_thickness) bone += 0.01;
      EXPECT_NEAR(f.thicknesses[i], bone + 0.5, 0.15);
    }
    EXPECT_LT(glm::distance(f.origin, pins[0]), 0.1);
    EXPECT_LT(angle_between(f.axis, axis), 0.1);
    EXPECT_NEAR(f.opening, glm::distance(end, pins[0]), 0.1);
    EXPECT_NEAR(f.swing, swing, 0.1);
    // Measures in closed form.
    const auto from_line = [](const dvec3& p, const dvec3& a, const dvec3& b) {
      return glm::length(glm::cross(p - a, glm::normalize(b - a)));
    };
    EXPECT_NEAR(f.axis_miss, from_line(dvec3(0), pins[0], end), 0.1);
    EXPECT_NEAR(f.pair_difference,
                std::abs(from_line(pins[1], pins[0], dvec3(0)) - from_line(pins[2], pins[0], dvec3(0))), 0.2);
    for (std::size_t i = 0; i < k_pins; ++i) EXPECT_NEAR(f.heights[i], pins[i].z, 0.1);
    double access = 1e9;
    for (const dvec3& p : pins) access = std::min(access, glm::distance(p, on_shell({0, -0.5, 1})));
    EXPECT_NEAR(f.access, access, 0.1);
    EXPECT_NEAR(f.site_angle,
                std::acos(glm::dot(glm::normalize(on_shell({0, -0.5, 1})), dvec3(0, -1, 0))) / k_degree,
                1e-6);
  }
  // Pins on a scalp of 7 mm hold on the bone below it.
  Pins outside = level_pins();
  outside[0].x -= 7, outside[1].x += 7, outside[2].x += 7;
  const ClampFitted f = fit(run, outside);
  ASSERT_TRUE(f.is_fitted);
  for (std::size_t i = 0; i < k_pins; ++i) {
    EXPECT_LT(glm::distance(f.tips[i], level_pins()[i]), 0.1) << i;
    EXPECT_LT(f.residuals[i], 0.1);
  }
  EXPECT_NEAR(f.opening, level_pins()[1].x - level_pins()[0].x, 0.1);
}

// No random change of the fitted pose within the limits reduces the sum of the squared distances to the pins.
TEST(Clamp, TheFitIsTheBestWithinItsLimits) {
  std::mt19937 random(11);
  std::normal_distribution<double> noise(0, 1);
  const Pins pins = level_pins();
  const auto squares = [&](const ClampPose& pose, double width) {
    double sum = 0;
    const Pins tips = pose.tips_world(width);
    for (std::size_t i = 0; i < k_pins; ++i) sum += glm::dot(tips[i] - pins[i], tips[i] - pins[i]);
    return sum;
  };
  ClampLimits narrow, wide, stiff, broad;
  const double opening = glm::distance(pins[0], 0.5 * (pins[1] + pins[2]));
  narrow.most_opening = opening - 12;
  wide.least_opening = opening + 12;
  stiff.swing = 0;
  broad.rocker_width = 100;
  for (const ClampLimits& limits : {ClampLimits{}, narrow, wide, stiff, broad}) {
    Pins asked = pins;
    const ClampPose best = fit_pose(asked, limits).value();
    const double least = squares(best, limits.rocker_width);
    for (int i = 0; i < 4000; ++i) {
      const double size = std::pow(10.0, -3.0 * (i % 4) / 3);
      ClampPose other = best;
      other.origin_world += size * dvec3(noise(random), noise(random), noise(random));
      other.axis_world =
          glm::normalize(other.axis_world + 0.01 * size * dvec3(noise(random), noise(random), noise(random)));
      other.across_world += 0.01 * size * dvec3(noise(random), noise(random), noise(random));
      other.across_world = glm::normalize(other.across_world -
                                          glm::dot(other.across_world, other.axis_world) * other.axis_world);
      other.opening =
          std::clamp(other.opening + size * noise(random), limits.least_opening, limits.most_opening);
      other.swing = std::clamp(other.swing + 0.01 * size * noise(random), -limits.swing * k_degree,
                               limits.swing * k_degree);
      ASSERT_GE(squares(other, limits.rocker_width), least - 1e-9);
    }
  }
}

TEST(Clamp, EachLimitBindsAlone) {
  const Head head;
  sim::Lockstep run = head.run();
  const Pins skewed{on_shell({-1, 0.45, 0}), level_pins()[1], level_pins()[2]};
  const double opening = fit(run, level_pins()).opening, swing = std::abs(fit(run, skewed).swing);
  ASSERT_GT(swing, 8);
  EXPECT_EQ(fitted(run).trouble, "");
  FitClamp request;
  request.most_opening = opening - 10;
  {
    const ClampFitted f = fit(run, level_pins(), request);
    EXPECT_NEAR(f.opening, opening - 10, 1e-9);
    EXPECT_NE(f.trouble.find("wider than the clamp opens"), std::string::npos) << f.trouble;
    EXPECT_EQ(f.trouble.find(';'), std::string::npos);
    double gaps = 0;
    for (const double gap : f.gaps) gaps = std::max(gaps, std::abs(gap));
    EXPECT_GT(gaps, 2);
  }
  request = {};
  request.least_opening = opening + 10;
  {
    const ClampFitted f = fit(run, level_pins(), request);
    EXPECT_NEAR(f.opening, opening + 10, 1e-9);
    EXPECT_NE(f.trouble.find("narrower than the clamp closes"), std::string::npos) << f.trouble;
    EXPECT_EQ(f.trouble.find(';'), std::string::npos);
  }
  request = {};
  request.swing = swing - 4;
  {
    const ClampFitted f = fit(run, skewed, request);
    EXPECT_NEAR(std::abs(f.swing), swing - 4, 1e-9);
    EXPECT_EQ(f.trouble.find("the rocker swings at most"), 0u) << f.trouble;
    EXPECT_EQ(f.trouble.find(';'), std::string::npos);
  }
  {
    const ClampFitted f = fit(run, pins_on_shell({-1, 0, 0}, {1, 0, 0}, {0, 1, 0}, 42, 104));
    EXPECT_NE(f.trouble.find("pins 2 and 3 are 104 mm apart, those of the rocker 90 mm"), std::string::npos)
        << f.trouble;
    EXPECT_GT(f.residuals[1], 4);
  }
}

TEST(Clamp, DegeneratePinsAreNamedAndNothingIsFitted) {
  const Head head;
  sim::Lockstep run = head.run();
  EXPECT_NE(refusal(run, {FitClamp{}, 0}).find("place-pin"), std::string::npos);
  ASSERT_TRUE(fit(run, level_pins()).is_fitted);
  const auto reason = [&](const Pins& pins) {
    place(run, pins);
    EXPECT_EQ(refusal(run, {FitClamp{}, 0}), "");
    EXPECT_FALSE(fitted(run).is_fitted);
    EXPECT_EQ(measures(run).at("clamp fitted"), 0);
    EXPECT_EQ(measures(run).at("clamp opening"), 0);
    return failure(run);
  };
  const Pins good = level_pins();
  EXPECT_NE(reason({good[0], good[1], good[1] + dvec3(0, 0, 10)}).find("pins 2 and 3 are only 10 mm"),
            std::string::npos);
  EXPECT_NE(reason({dvec3(0, -92, 0), dvec3(0, 0, 0), dvec3(0, 92, 0)}).find("on one line"),
            std::string::npos);
  EXPECT_NE(reason(pins_on_shell({1, 0, 0.8}, {1, 0, -0.3}, {0, 1, 0}, 36)).find("same side"),
            std::string::npos);
  EXPECT_NE(reason({good[0] + dvec3(-100, 0, 0), good[1] + dvec3(0, 0, 300), good[2] + dvec3(0, 0, 300)})
                .find("meets no bone"),
            std::string::npos);
  // Invalid commands are refused.
  ASSERT_TRUE(fit(run, good).is_fitted);
  EXPECT_NE(refusal(run, {PlacePin{}, 0}).find("all its pins"), std::string::npos);
  EXPECT_NE(refusal(run, {MovePin{3, dvec3(NAN)}, 0}), "");
  EXPECT_NE(refusal(run, {SetPosture{dvec3(0)}, 0}).find("no length"), std::string::npos);
  EXPECT_NE(refusal(run, {FitClamp{{}, "elsewhere"}, 0}).find("unknown approach"), std::string::npos);
  FitClamp reversed;
  reversed.least_opening = 300;
  EXPECT_NE(refusal(run, {reversed, 0}).find("reversed"), std::string::npos);
  ASSERT_EQ(refusal(run, {ClearPins{}, 0}), "");
  EXPECT_NE(refusal(run, {MovePin{1, dvec3(1)}, 0}).find("unknown pin"), std::string::npos);
}

TEST(Clamp, EachPlantedErrorMovesItsOwnMeasure) {
  using Plant = std::function<void(Head&)>;
  const auto measured = [](const Plant& plant, double thin = 0) {
    Head head(thin);
    const auto sinus = [&](double x) {
      // A labelled ball of 8 mm radius inside pin 1, which is at x = -76: it touches the pin at x = -68, and
      // is 8 mm away from it at x = -60.
      const volume::Volume& scan = *head.scene.base;
      volume::Volume labelled = volume::make_volume(scan.size, scan.frame, true).value();
      labelled.label_names = {"", "frontal sinus"};
      std::copy(scan.voxels.span().begin(), scan.voxels.span().end(), labelled.voxels.data());
      for (int z = 0; z < scan.size.z; ++z)
        for (int y = 0; y < scan.size.y; ++y)
          for (int i = 0; i < scan.size.x; ++i)
            labelled.labels[scan.index(i, y, z)] =
                glm::distance(scan.frame.world_from_volume(dvec3(i, y, z)), dvec3(x, 0, 0)) < 8;
      volume::Shape shape{"frontal sinus"};
      shape.label = 1;
      head.forbidden = {
          sim::Forbidden::build(std::make_shared<const volume::Volume>(std::move(labelled)), shape).value()};
    };
    sinus(-60);
    plant(head);
    if (head.forbidden.empty()) sinus(-68);
    sim::Lockstep run = head.run();
    EXPECT_TRUE(fit(run, level_pins()).is_fitted);
    EXPECT_EQ(refusal(run, {SetPosture{}, 0}), "");
    EXPECT_EQ(refusal(run, {FitClamp{}, 0}), "");
    return measures(run);
  };
  const auto base = measured([](Head&) {});
  EXPECT_NEAR(base.at("clamp axis miss"), 0, 0.1);
  EXPECT_NEAR(base.at("clamp pair difference"), 0, 0.2);
  EXPECT_NEAR(base.at("clamp pin 1 height"), 0, 0.1);
  EXPECT_NEAR(base.at("clamp clearance"), 8, 1);
  const auto expect_change = [&](const char* name, const std::map<std::string, double>& changed,
                                 const std::map<std::string, double>& by) {
    SCOPED_TRACE(name);
    for (const auto& [measure, value] : base) {
      const auto found = by.find(measure);
      const double difference = changed.at(measure) - value;
      EXPECT_NEAR(difference, found == by.end() ? 0.0 : found->second, found == by.end() ? 0.2 : 1.0)
          << measure;
    }
  };
  expect_change("30 mm above the band", measured([](Head& h) {
                  h.plan->planes[0].point_world = {0, 0, -30};
                }),
                {{"clamp pin 1 height", 30}, {"clamp pin 2 height", 30}, {"clamp pin 3 height", 30}});
  expect_change("axis 15 mm past the centre", measured([](Head& h) {
                  h.plan->landmarks[0].position_world = {0, 0, 15};
                }),
                {{"clamp axis miss", 15}, {"clamp pair difference", 0}});
  // If the pair is skewed by 10 mm, the axis also misses the centre. Both measures have closed forms.
  const Pins pins = level_pins();
  const double to_centre = -pins[0].x, to_pair = pins[1].x - pins[0].x;
  expect_change("pair skewed by 10 mm", measured([&](Head& h) {
                  h.plan->landmarks[0].position_world = {0, 5 * to_centre / to_pair, 0};
                }),
                {{"clamp pair difference", 10}, {"clamp axis miss", 5 * to_centre / to_pair}});
  expect_change("pin over the frontal sinus", measured([](Head& h) { h.forbidden.clear(); }),
                {{"clamp clearance", -8}});
  expect_change("thin bone under pin 2", measured([](Head&) {}, 4),
                {{"clamp pin 2 bone", base.at("clamp pin 2 bone") * -4 / k_thickness}});
  expect_change("approach 20 mm nearer", measured([](Head& h) {
                  const dvec3 entry = h.plan->trajectories[0].entry_world;
                  const dvec3 toward = glm::normalize(level_pins()[2] - entry);
                  h.plan->trajectories[0].entry_world += 20.0 * toward;
                  h.plan->trajectories[0].target_world += 20.0 * toward;
                }),
                {{"clamp access", -20}});
}

TEST(Clamp, PostureFollowsClosedForms) {
  const auto expect_neck = [](const dvec3& up, double turn, double rotation, double flexion, double bend) {
    const NeckAngles neck = neck_angles(glm::normalize(up), turn);
    EXPECT_NEAR(neck.rotation, rotation, 1e-9);
    EXPECT_NEAR(neck.flexion, flexion, 1e-9);
    EXPECT_NEAR(neck.bend, bend, 1e-9);
  };
  const double c = std::cos(30 * k_degree), s = std::sin(30 * k_degree);
  expect_neck({0, -1, 0}, 0, 0, 0, 0);
  expect_neck({-s, -c, 0}, 0, 30, 0, 0);   // the face looks to the left
  expect_neck({-s, -c, 0}, 30, 0, 0, 0);   // the trunk is turned by the same angle
  expect_neck({0, -c, s}, 0, 0, 30, 0);    // chin to chest
  expect_neck({0, c, s}, 180, 0, -30, 0);  // prone, head raised
  expect_neck({c, 0, s}, -90, 0, 0, 30);   // on the right side
  // The measures use the posture of the operation.
  const Head head;
  sim::Lockstep run = head.run();
  ASSERT_EQ(refusal(run, {SetPosture{{-s, -c, 0}, 10}, 0}), "");
  ASSERT_TRUE(fit(run, level_pins()).is_fitted);
  EXPECT_NEAR(measures(run)["neck rotation"], 20, 1e-9);
  ASSERT_EQ(refusal(run, {SetPosture{{0, -1, 0}, 0}, 0}), "");
  EXPECT_EQ(measures(run)["clamp fitted"], 0) << "a fit belongs to its posture";
}

TEST(Clamp, ShowsHandlesFrameAndSweatbandOfTheCurrentPins) {
  const Head head;
  sim::Lockstep run = head.run();
  EXPECT_TRUE(run.engine().overlays().empty());
  ASSERT_TRUE(fit(run, level_pins()).is_fitted);
  const auto objects = [&] {
    int count = 0;
    for (const sim::Overlay& overlay : run.engine().overlays())
      if (overlay.surface) {
        ++count;
        EXPECT_EQ(overlay.kind, sim::Overlay::Kind::object);
        EXPECT_TRUE(volume::is_metal(overlay.matter));
      }
    return count;
  };
  EXPECT_EQ(objects(), 1);
  std::size_t handles = 0, lines = 0;
  for (const sim::Overlay& overlay : run.engine().overlays())
    handles += overlay.handles.size(), lines += overlay.lines.size();
  EXPECT_EQ(handles, 3u);
  EXPECT_EQ(lines, 36u);
  // A moved pin makes the fit outdated: the frame of the clamp disappears, and the measures of the fit are
  // stale.
  ASSERT_EQ(refusal(run, {MovePin{2, level_pins()[1] + dvec3(0, 0, 5)}, 0}), "");
  EXPECT_EQ(objects(), 0);
  for (const sim::Measure& m : run.engine().measures())
    if (m.name == "clamp opening") {
      EXPECT_TRUE(m.is_stale);
    }
  // The frame consists of closed solids whose facets face outward: each edge is balanced, and the volume is
  // positive and large.
  const auto surface = clamp_surface(pose_of(fitted(run)), level_pins(), {0, -1, 0});
  double volume = 0;
  std::map<std::pair<std::array<double, 3>, std::array<double, 3>>, int> edges;
  for (std::uint32_t t = 0; t < surface->triangle_count(); ++t) {
    const auto corner = surface->corners(t);
    volume += glm::dot(corner[0], glm::cross(corner[1], corner[2])) / 6;
    for (std::size_t k = 0; k < 3; ++k) {
      const dvec3 &a = corner[k], &b = corner[(k + 1) % 3];
      ++edges[{{a.x, a.y, a.z}, {b.x, b.y, b.z}}];
      --edges[{{b.x, b.y, b.z}, {a.x, a.y, a.z}}];
    }
  }
  EXPECT_GT(volume, 3 * 900);
  for (const auto& [edge, count] : edges) ASSERT_EQ(count, 0);
}

/// Returns a head with a labelled scalp of 5 mm, and a ball with the label of the scalp below the head.
volume::Volume head_with_ball(const dvec3& middle, double radius) {
  const volume::Volume scan =
      scenes::sampled({-87, -103, -160}, {87, 103, 83}, dvec3(1.5), [](const dvec3& p) {
        const double d = shell_distance(p);
        return std::clamp(300 + 400 * std::min(-d, d + k_thickness), -1000.0, 1600.0);
      });
  volume::Volume labelled = volume::make_volume(scan.size, scan.frame, true).value();
  labelled.label_names = {"", "scalp", "head"};
  std::copy(scan.voxels.span().begin(), scan.voxels.span().end(), labelled.voxels.data());
  for (int z = 0; z < scan.size.z; ++z)
    for (int y = 0; y < scan.size.y; ++y)
      for (int x = 0; x < scan.size.x; ++x) {
        const dvec3 p = scan.frame.world_from_volume(dvec3(x, y, z));
        const double d = shell_distance(p);
        const bool is_scalp = (d > 0 && d < 5) || glm::distance(p, middle) < radius;
        labelled.labels[scan.index(x, y, z)] = static_cast<std::uint8_t>(d <= 0 ? 2 : is_scalp ? 1 : 0);
      }
  return labelled;
}

TEST(Clamp, ReportsScalpAndPartsInTheHeadByClosedForms) {
  // `lowest` is the lowest point of the arms' centre line. The first ball is centred on it.
  const Pins pins = level_pins();
  const ClampPose pose = fit_pose(pins, ClampLimits()).value();
  const dvec3 up(0, 0, 1), lowest = clamp_rods(pose, pins, up, ClampSize().arm_depth)[6].to;
  EXPECT_NEAR(lowest.z, -130, 0.1);
  constexpr double k_ball = 20, k_arm = 8;  // mm
  const auto measured = [&](const dvec3& middle) {
    Head head(head_with_ball(middle, k_ball));
    sim::Lockstep run = head.run();
    EXPECT_EQ(refusal(run, {SetPosture{up}, 0}), "");
    const ClampFitted f = fit(run, pins);
    EXPECT_TRUE(f.is_fitted) << failure(run);
    int touches = 0, warnings = 0;
    for (std::size_t i = 0; i < run.engine().state().chronicle.size(); ++i)
      touches += run.engine().state().chronicle[i].value.as<ClampTouchesHead>() != nullptr;
    for (const sim::Overlay& overlay : run.engine().overlays())
      for (const auto& label : overlay.labels)
        warnings += label.text.find("touches the head") != std::string::npos;
    EXPECT_EQ(touches, f.touch_depth > 0);
    EXPECT_EQ(warnings, touches);
    return f;
  };
  const ClampFitted touching = measured(lowest);
  // The nearest points of the arm's surface are its radius away from the ball's middle.
  EXPECT_NEAR(touching.touch_depth, k_ball - k_arm, 1.5);
  EXPECT_NEAR(glm::distance(touching.touch_at, lowest), k_arm, 1);
  EXPECT_NEAR(touching.touch_length, 2 * std::sqrt(k_ball * k_ball - k_arm * k_arm), 3);
  // A ball next to the arm is not touched.
  const ClampFitted free = measured(lowest + dvec3(0, k_ball + k_arm + 3, 0));
  EXPECT_EQ(free.touch_depth, 0);
  EXPECT_EQ(free.touch_length, 0);
  ASSERT_EQ(free.scalps.size(), 3u);
  EXPECT_NEAR(free.scalps[0], 5, 0.8);
  for (std::size_t i = 1; i < k_pins; ++i) {
    const dvec3 normal = glm::normalize(pins[i] / (k_radii * k_radii));
    EXPECT_NEAR(free.scalps[i], 5 / normal.x, 1.0) << "along the pin, which leans";
  }
}

TEST(Clamp, HasTwoModels) {
  const Head head;
  sim::Lockstep run = head.run();
  const ClampFitted standard = fit(run, level_pins());
  EXPECT_EQ(standard.trouble, "");
  ASSERT_EQ(refusal(run, {SetClamp{ClampModel::small}, 0}), "");
  EXPECT_FALSE(fitted(run).is_fitted) << "the fit was of the other clamp";
  ASSERT_EQ(refusal(run, {FitClamp{}, 0}), "");
  EXPECT_NE(fitted(run).trouble.find("those of the rocker 60 mm"), std::string::npos) << fitted(run).trouble;
  EXPECT_LT(fitted(run).arm_depth, standard.arm_depth);
  // A pair that is as far apart as the rocker of the small clamp fits. Limits of a request replace those of
  // the model.
  const Pins near = pins_on_shell({-1, 0, 0}, {1, 0, 0}, {0, 1, 0}, 22, 60);
  EXPECT_EQ(fit(run, near).trouble, "");
  FitClamp wide;
  wide.rocker_width = k_width;
  EXPECT_EQ(fit(run, level_pins(), wide).trouble, "");
}

TEST(Clamp, HoldsTheBuiltInHeads) {
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    SCOPED_TRACE(seed);
    data_tools::PhantomOptions o;
    o.spacing_mm = dvec3(2);
    o.seed = seed;
    Head head(data_tools::make_phantom("head", o).value());
    const data_tools::HeadAnatomy anatomy = data_tools::head_anatomy(seed);
    const data_tools::HeadLandmarks landmarks = data_tools::head_landmarks(anatomy);
    head.plan->landmarks = {{"glabella", landmarks.glabella}, {"inion", landmarks.inion}};
    head.plan->trajectories.push_back(
        {"left ventriculostomy", landmarks.left.kochers_point, landmarks.left.foramen_of_monro, 3});
    const auto on_vault = [&](const dvec3& direction) {
      double low = 0, high = 150;
      for (int i = 0; i < 60; ++i)
        (data_tools::vault_distance(0.5 * (low + high) * direction, anatomy) < 0 ? low : high) =
            0.5 * (low + high);
      return low * direction;
    };
    // The pins are in the band over the ears. The pair is as far apart as the rocker is wide.
    const dvec3 first = on_vault(glm::normalize(dvec3(-1, 0.15, -0.15))),
                second = on_vault(glm::normalize(dvec3(1, -0.55, -0.15)));
    double low = -0.5, high = 2;
    for (int i = 0; i < 60; ++i) {
      const double between = 0.5 * (low + high);
      (glm::distance(on_vault(glm::normalize(dvec3(1, between, -0.15))), second) < k_width ? low : high) =
          between;
    }
    const Pins pins{first, second, on_vault(glm::normalize(dvec3(1, low, -0.15)))};
    sim::Lockstep run = head.run();
    const ClampFitted f = fit(run, pins);
    ASSERT_TRUE(f.is_fitted) << failure(run);
    EXPECT_EQ(f.trouble, "");
    ASSERT_EQ(f.scalps.size(), 3u);
    for (const double scalp : f.scalps) EXPECT_TRUE(scalp > 1 && scalp < 20) << scalp;
    EXPECT_GT(f.opening, 115);
    EXPECT_LT(f.opening, 150);
    for (std::size_t i = 0; i < k_pins; ++i) {
      EXPECT_LT(glm::distance(f.tips[i], pins[i]), 2) << i;
      EXPECT_LT(std::abs(f.heights[i]), 12);
      EXPECT_GT(f.thicknesses[i], 1.2);
      EXPECT_LT(f.thicknesses[i], 14);
    }
    // The skull is symmetric; its centre lies in the midline, between front and back.
    EXPECT_NEAR(f.centre.x, 0, 1.1);
    EXPECT_NEAR(f.centre.y, 0, 9);
    EXPECT_LT(f.axis_miss, 15);
    EXPECT_GT(f.access, 40);
    // A pin above the band is reported by its height.
    const ClampFitted tilted = fit(run, {on_vault(glm::normalize(dvec3(-1, 0.15, 0.35))), pins[1], pins[2]});
    ASSERT_TRUE(tilted.is_fitted) << failure(run);
    EXPECT_GT(tilted.heights[0], f.heights[0] + 20);
    EXPECT_NEAR(tilted.heights[1], f.heights[1], 3);
  }
}

}  // namespace
}  // namespace trephine::skull_clamp
