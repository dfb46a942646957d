// ChainProxy: a rigid tool of several balls, against shapes with a formula and an independent search.
#include "haptics/proxy/chain_proxy.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <random>

#include "haptics/methods/methods.h"
#include "haptics/servo/servo_core.h"
#include "tests/haptics/servo/servo_fixture.h"
#include "volume/cuts/removal.h"

namespace trephine::haptics {
namespace {

using glm::dquat;
using glm::dvec3;

constexpr double k_radius = 2;  // of each ball, mm

/// Centres of balls along x, from -half to half, mm.
std::vector<dvec3> rod(double half, int balls) {
  std::vector<dvec3> all;
  for (int i = 0; i < balls; ++i) all.emplace_back(half * (2.0 * i / (balls - 1) - 1), 0, 0);
  return all;
}
/// A probe held at its end, with a bent tip.
std::vector<dvec3> hook() { return {{0, 0, 0}, {0, 0, -8}, {0, 0, -16}, {0, 0, -24}, {5, 0, -28}}; }

struct Solid {
  const char* phantom;
  std::map<std::string, double> parameters;
  std::function<double(const dvec3&)> distance;  ///< mm, positive outside
  dvec3 top{0.0};                                ///< a highest point, mm
};
std::vector<Solid> solids() {
  return {{"plane", {{"angle", 0}}, [](const dvec3& p) { return p.z; }, {0, 0, 0}},
          {"sphere", {{"radius", 30}}, [](const dvec3& p) { return glm::length(p) - 30; }, {0, 0, 30}},
          {"torus",
           {{"major", 35}, {"minor", 14}},
           [](const dvec3& p) { return std::hypot(std::hypot(p.x, p.y) - 35, p.z) - 14; },
           {35, 0, 14}}};
}

TouchScene scene_with(const Solid& solid, const std::vector<dvec3>& balls, int size = 96) {
  data_tools::PhantomOptions o = phantom_options(size);
  o.parameters = solid.parameters;
  TouchScene scene = scenes::phantom_scene(solid.phantom, o);
  EXPECT_FALSE(set_tool(scene, k_radius, balls));
  return scene;
}

double angle_between(const dquat& a, const dquat& b) {
  return 2 * std::acos(std::min(1.0, std::abs(glm::dot(a, b))));
}

struct ChainPlay {
  const TouchScene& scene;
  ChainProxy method;
  ProxyState state;
  TouchState seen;
  explicit ChainPlay(const TouchScene& s)
      : scene(s), seen(std::shared_ptr<const volume::Version>(uncut_version(s))) {
    EXPECT_FALSE(method.prepare(scene));
  }
  ProxyStep step(const Placement& hand) {
    return method.step(scene, seen, state, {hand.position_world, {}, hand.rotation});
  }
  Placement tool(const ProxyStep& r) const { return {r.proxy_world, state.tool_turn}; }
};

/// Returns the energy of the springs between hand and tool, for a stiffness of 1 N/mm.
double energy(const TouchScene& scene, const Placement& tool, const Placement& hand) {
  const dvec3 d = tool.position_world - hand.position_world;
  const double a = angle_between(tool.rotation, hand.rotation);
  return 0.5 * glm::dot(d, d) + 4 * scene.tool->gyration_square() * (1 - std::cos(0.5 * a));
}
/// Returns the least distance of a ball's centre from the solid, mm.
double least_distance(const Solid& solid, const TouchScene& scene, const Placement& tool) {
  double least = 1e300;
  for (const dvec3& at : scene.tool->centres())
    least = std::min(least, solid.distance(tool.world_from_local(at)));
  return least;
}

// A random search near the rest pose finds no free pose with notably less energy in the springs. The
// tolerance, as a length of the spring, is 0.02 voxels.
TEST(ChainProxy, RestsWhereTheSpringsOfItsBallsAreShortest) {
  std::mt19937 random(5);
  const auto between = [&](double a, double b) { return a + (b - a) * (double(random()) / 4294967296.0); };
  double worst = 0, deepest = 0;
  int touching = 0;
  for (const Solid& solid : solids())
    for (const auto& balls : {rod(12, 7), hook()}) {
      const TouchScene scene = scene_with(solid, balls);
      const double voxel = scene.base->frame.spacing().x;
      for (int trial = 0; trial < 4; ++trial) {
        ChainPlay run(scene);
        // The hand descends to 1 to 8 mm below the position in which the tool touches the top, while it
        // turns.
        const double down = balls.size() == 7 ? k_radius : 28 + k_radius;
        const dvec3 to = solid.top + dvec3(between(-6, 6), between(-6, 6), down - between(1, 8));
        const dvec3 about(between(-0.4, 0.4), between(-0.4, 0.4), between(-0.6, 0.6));
        const Placement first{to + dvec3(0, 0, 20), rotation_of({between(-0.2, 0.2), between(-0.2, 0.2), 1})};
        Placement hand = first;
        ProxyStep r;
        for (int i = 0; i <= 900; ++i) {
          const double share = std::min(1.0, i / 600.0);
          hand = {first.position_world + share * (to - first.position_world),
                  rotation_of(share * about) * first.rotation};
          r = run.step(hand);
          deepest = std::max(deepest, (k_radius - least_distance(solid, scene, run.tool(r))) / voxel);
        }
        if (!r.has_contact) continue;
        ++touching;
        EXPECT_GT(r.contacts.size(), 0u);
        // The search starts at the rest pose. No ball may be deeper in the solid than in the rest pose.
        Placement best = run.tool(r);
        const double held = energy(scene, best, hand);
        const Placement rests = best;
        const auto is_free = [&](const Placement& tool) {
          return std::all_of(balls.begin(), balls.end(), [&](const dvec3& at) {
            return solid.distance(tool.world_from_local(at)) >=
                   std::min(k_radius, solid.distance(rests.world_from_local(at)));
          });
        };
        double least = held, reach = 0.1;  // small steps, so that the search stays in one valley
        for (int n = 0; n < 6000; ++n) {
          if (n % 500 == 499) reach *= 0.5;
          const double arm = std::sqrt(scene.tool->gyration_square());
          const Placement next{
              best.position_world + reach * dvec3(between(-1, 1), between(-1, 1), between(-1, 1)),
              rotation_of(reach / arm * dvec3(between(-1, 1), between(-1, 1), between(-1, 1))) *
                  best.rotation};
          if (!is_free(next) || glm::length(next.position_world - r.proxy_world) > 1) continue;
          if (const double e = energy(scene, next, hand); e < least) least = e, best = next;
        }
        // Difference of the energies as a length of the spring, in voxels.
        worst = std::max(worst, (std::sqrt(2 * held) - std::sqrt(2 * least)) / voxel);
      }
    }
  EXPECT_GT(touching, 15);
  EXPECT_LT(deepest, 0.1) << "voxels";
  EXPECT_LT(worst, 0.02) << "voxels";
  RecordProperty("nearer_by_trial_voxels", std::to_string(worst));
  RecordProperty("deepest_voxels", std::to_string(deepest));
}

// Statics of a lever: a rod is pressed on a plane and tilted.
TEST(ChainProxy, ARodOnAPlaneIsALever) {
  const Solid plane = solids()[0];
  const double half = 15;
  const TouchScene scene = scene_with(plane, rod(half, 7));
  const double square = scene.tool->gyration_square();
  for (const double tilt : {0.0, 0.05, 0.2, -0.2})
    for (const double z : {1.5, 0.0, -4.0}) {
      ChainPlay run(scene);
      ProxyStep r;
      const dvec3 about(0, -tilt, 0);  // the end at +x is raised for tilt > 0
      for (int i = 0; i < 1500; ++i)
        r = run.step({{0, 0, std::max(z, 30 - 0.05 * i)}, rotation_of(std::min(1.0, i / 300.0) * about)});
      // The centre is at z = radius + half * sin(a), or at the hand's z if that is higher. The
      // expected angle a >= 0 has the least sum of the energies of both springs.
      double best = 0, least = 1e300;
      for (double a = 0; a <= std::abs(tilt); a += 1e-5) {
        const double height = std::max(z, k_radius + half * std::sin(a));
        const double e = std::pow(height - z, 2) + 8 * square * (1 - std::cos(0.5 * (std::abs(tilt) - a)));
        if (e < least) least = e, best = a;
      }
      const double height = std::max(z, k_radius + half * std::sin(best));
      EXPECT_NEAR(r.proxy_world.z, height, 0.03) << tilt << ' ' << z;
      EXPECT_NEAR(glm::length(r.turn_world), std::abs(tilt) - best, 0.003) << tilt << ' ' << z;
      if (tilt != 0 && best + 0.01 < std::abs(tilt)) {
        EXPECT_GT(r.turn_world.y * tilt, 0);
      }
      // The pushes of the contacts balance the springs, and each contact is where a ball touches the plane.
      dvec3 push(0), moment(0);
      for (std::size_t i = 0; i < r.contacts.size(); ++i) {
        const ToolContact& contact = r.contacts[i];
        EXPECT_NEAR(contact.point_world.z, 0, 0.05);
        EXPECT_NEAR(contact.normal_world.z, 1, 1e-3);
        push += contact.push * contact.normal_world;
        moment += glm::cross(contact.point_world - r.proxy_world, contact.push * contact.normal_world);
      }
      ASSERT_GT(r.contacts.size(), 0u);
      EXPECT_GT(r.normal_world.z, 0.99);
      EXPECT_LT(glm::length(push - (r.proxy_world - dvec3(0, 0, z))), 0.02) << tilt << ' ' << z;
      EXPECT_LT(glm::length(moment - square * r.turn_world), 0.3) << tilt << ' ' << z;
    }
}

TEST(ChainProxy, NothingIsEnteredOrPassedUnderAnyMotion) {
  const Solid plate{"plate", {{"thickness", 3}, {"angle", 20}}, nullptr, {}};
  const dvec3 normal(std::sin(20 * 3.14159265358979 / 180), 0, std::cos(20 * 3.14159265358979 / 180));
  const TouchScene scene = scene_with(plate, rod(12, 7));
  const double voxel = scene.base->frame.spacing().x;
  for (unsigned seed = 1; seed <= 3; ++seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> noise(0, 1);
    ChainPlay run(scene);
    dvec3 at(0, 0, 25), about(0);
    long contacts = 0;
    for (int i = 0; i < 6000; ++i) {
      // The hand moves at about 2 m/s and 50 rad/s, back and forth through the plate.
      at += dvec3(0.3 * noise(random), 0.3 * noise(random), noise(random) - 0.05 * at.z);
      at.z += 2 * std::sin(0.05 * i);
      about += 0.03 * dvec3(noise(random), noise(random), noise(random)) - 0.01 * about;
      if (glm::length(at) > 40) at *= 0.9;
      const ProxyStep r = run.step({at, rotation_of(about)});
      contacts += r.has_contact;
      const Placement tool = run.tool(r);
      ASSERT_EQ(run.state.balls_inside, 0u);
      for (const dvec3& ball : scene.tool->centres()) {
        const double side = glm::dot(tool.world_from_local(ball), normal) - 1.5;
        ASSERT_GT(side, k_radius - 0.1 * voxel) << i;
      }
      ASSERT_NEAR(glm::length(tool.rotation), 1, 1e-9);
    }
    EXPECT_GT(contacts, 1000);
  }
}

// On closed paths in the hole of a torus, with complete servo ticks, the hand receives no more energy than it
// gave.
TEST(ChainProxy, GivesNoEnergyOnClosedPaths) {
  const Solid torus = solids()[2];
  TouchScene scene = scene_with(torus, hook());
  ChainProxy method;
  ASSERT_FALSE(method.prepare(scene));
  const auto seen = servo_scene_of(scene, method);
  ServoCore core({}, 1e-3);
  double max_torque = 0;
  long contacts = 0;
  for (int i = 0; i <= 12000; ++i) {
    const double a = 2 * 3.14159265358979 * i / 2000;
    Pose pose;
    pose.position_world = {12 * std::cos(a), 12 * std::sin(a), 22 + 6 * std::sin(3 * a)};
    pose.orientation = rotation_of({0.3 * std::sin(2 * a), 0.3 * std::cos(a) - 0.3, 0.2 * std::sin(a)});
    const ServoRecord r = core.step(*seen, {.pose = pose});
    contacts += r.has_contact;
    max_torque = std::max(max_torque, glm::length(r.torque_world));
    ASSERT_EQ(r.faults & k_latched_faults, 0u);
  }
  EXPECT_GT(contacts, 3000);
  EXPECT_GT(max_torque, 5);
  const EnergyLedger& energy = core.energy();
  EXPECT_LT(energy.contact + energy.turning, 0.5) << energy.contact << ' ' << energy.turning;
}

TEST(ChainProxy, GrowingMatterReleasesItAndItCanLeave) {
  const Solid plane = solids()[0];
  const TouchScene scene = scene_with(plane, rod(12, 7));
  ChainPlay run(scene);
  volume::RemovalEditor editor(std::shared_ptr<const volume::Version>(uncut_version(scene)),
                               {scene.items[0].field});
  editor.remove({{-14, 0, -2}, {14, 0, -2}, 6});
  const auto cut = editor.publish();
  TouchState::OffsetFields fields{scene.items[0].offset->updated(
      scene.items[0].field, *scene.items[0].bits, *cut, {glm::ivec3(0), scene.base->size - 1})};
  const TouchState whole = run.seen;
  run.seen = TouchState(cut, fields);
  ProxyStep r;
  for (int i = 0; i < 600; ++i) r = run.step({{0, 0, std::max(-3.0, 20 - 0.1 * i)}, {1, 0, 0, 0}});
  EXPECT_NEAR(r.proxy_world.z, -3, 1e-6);  // in the trough
  run.seen = whole;
  r = run.step({{0, 0, -3}, {1, 0, 0, 0}});
  EXPECT_TRUE(r.is_buried);
  EXPECT_FALSE(r.has_contact);
  for (int i = 0; i < 300; ++i) r = run.step({{0, 0, -3 + 0.05 * i}, {1, 0, 0, 0}});
  EXPECT_EQ(run.state.balls_inside, 0u);
  for (int i = 0; i < 300; ++i) r = run.step({{0, 0, 12 - 0.05 * i}, {1, 0, 0, 0}});
  EXPECT_TRUE(r.has_contact);
  EXPECT_NEAR(r.proxy_world.z, k_radius, 0.05);
}

// While the hand rests, the tool does not move: in a hole with a radius 0.3 mm larger than that of the tool,
// and on curved walls.
TEST(ChainProxy, RestsWhileTheHandRests) {
  int rests = 0;
  for (const char* name : {"plane", "gyroid", "steps"}) {
    const bool is_plane = std::string(name) == "plane";
    const Solid solid{
        name,
        is_plane ? std::map<std::string, double>{{"angle", 0}} : std::map<std::string, double>{},
        nullptr,
        {}};
    TouchScene scene = scene_with(solid, hook(), 64);
    TouchState seen(std::shared_ptr<const volume::Version>(uncut_version(scene)));
    if (is_plane) {
      volume::RemovalEditor editor(seen.version, {scene.items[0].field});
      editor.remove({{0, 0, 2}, {0, 0, -12}, 2.3});
      const auto cut = editor.publish();
      seen = TouchState(cut, {scene.items[0].offset->updated(scene.items[0].field, *scene.items[0].bits, *cut,
                                                             {glm::ivec3(0), scene.base->size - 1})});
    }
    for (const auto& balls : {rod(8, 5), std::vector<dvec3>{{0, 0, 0}}, hook()}) {
      scene.tool = make_tool(scene.tool->radius(), balls).value();
      ChainPlay run(scene);
      run.seen = seen;
      std::mt19937 random(7);
      const auto between = [&](double a, double b) {
        return a + (b - a) * (double(random()) / 4294967296.0);
      };
      for (int trial = 0; trial < 2; ++trial) {
        run.state = ProxyState{};
        const dvec3 to(between(-2, 2), between(-2, 2), between(-8, 4));
        const dvec3 about(between(-0.5, 0.5), between(-0.5, 0.5), between(-0.5, 0.5));
        ProxyStep r;
        Placement before;
        for (int i = 0; i < 1000; ++i) {
          const double share = std::min(1.0, i / 600.0);
          r = run.step({to + dvec3(0, 0, 60 * (1 - share)), rotation_of(share * about)});
          const Placement now = run.tool(r);
          if (i > 800) {
            ASSERT_EQ(now.position_world, before.position_world) << name << ' ' << balls.size() << ' ' << i;
            ASSERT_EQ(now.rotation, before.rotation) << name << ' ' << i;
          }
          before = now;
        }
        rests += r.has_contact;
      }
    }
  }
  EXPECT_GT(rests, 8);
}

// When a tool is replaced, balls of the new tool may be inside bone, although those of the old tool were not.
// Such balls are not held, since otherwise the tool could not leave the bone.
TEST(ChainProxy, AReplacedToolIsNotHeldInsideBone) {
  const Solid plane = solids()[0];
  const TouchScene flat = scene_with(plane, {{0, 0, 0}, {0, 0, 8}}),
                   deep = scene_with(plane, {{0, 0, 0}, {0, 0, -3}});
  ChainProxy with_flat, with_deep;
  ASSERT_FALSE(with_flat.prepare(flat) || with_deep.prepare(deep));
  const auto version = std::shared_ptr<const volume::Version>(uncut_version(flat));
  ServoHand hand(borrowed(flat), borrowed(with_flat), TouchState(version));
  ServoCore core({}, 1e-3);
  ServoScene seen{1, {hand}};
  ServoRecord r;
  for (int i = 0; i < 400; ++i) r = core.step(seen, {.pose = {{0, 0, std::max(1.0, 20 - 0.1 * i)}}});
  ASSERT_TRUE(r.has_contact);
  hand.set_scene(borrowed(deep), borrowed(with_deep));
  seen = {2, {hand}};
  for (int i = 0; i < 300; ++i) r = core.step(seen, {.pose = {{0, 0, 1}}});
  EXPECT_LT(glm::length(r.force_world) + glm::length(r.torque_world), 1e-6);
  for (int i = 0; i < 600; ++i) {
    r = core.step(seen, {.pose = {{0, 0, 1 + 0.02 * i}}});
    ASSERT_LT(glm::length(r.force_world), 1e-6) << i;
  }
  EXPECT_NEAR(r.proxy_world.z, 1 + 0.02 * 599, 1e-6);
  EXPECT_EQ(core.proxy_state().balls_inside, 0u);
  for (int i = 0; i < 600; ++i) r = core.step(seen, {.pose = {{0, 0, 13 - 0.015 * i}}});
  EXPECT_TRUE(r.has_contact);
  EXPECT_NEAR(r.proxy_world.z, 3 + k_radius, 0.05);
}

/// Returns a box of triangles that face outward.
std::shared_ptr<const MeshTree> box(const dvec3& half) {
  std::vector<dvec3> corners;
  for (int i = 0; i < 8; ++i) corners.push_back(half * dvec3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1));
  std::vector<std::uint32_t> triangles;
  const auto face = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    for (const std::uint32_t corner : {a, b, c, a, c, d}) triangles.push_back(corner);
  };
  face(0, 2, 3, 1), face(4, 5, 7, 6), face(0, 1, 5, 4), face(2, 6, 7, 3), face(0, 4, 6, 2), face(1, 3, 7, 5);
  return std::make_shared<const MeshTree>(corners, triangles);
}
/// Returns the distance of p to this box by a formula, mm; negative inside.
double box_distance(const dvec3& p, const dvec3& half) {
  const dvec3 q = glm::abs(p) - half;
  return glm::length(glm::max(q, dvec3(0))) + std::min(0.0, std::max({q.x, q.y, q.z}));
}

struct BoxMotionCounts {
  long contacts = 0, buried = 0;  ///< ticks
  long aside = 0;                 ///< ticks in which the tool is more than 0.5 mm from the hand
  long checked = 0;               ///< checked positions of balls
  long in_box = 0, in_bone = 0;   ///< checked positions in box or bone: no step reported that the box passes
};
/// Moves a box back and forth through the tool, and the tool through the box. `is_late`: the method receives
/// the box's pose of the previous tick.
BoxMotionCounts lead_box(bool is_on_bone, bool is_hook, bool is_late) {
  const dvec3 half(9, 5, 3);
  const Solid plate{"plate", {{"thickness", 3}, {"angle", 0}}, nullptr, {}};
  TouchScene scene = scene_with(plate, is_hook ? hook() : rod(10, 5));
  TouchItem item = mesh_item("box", box(half));
  item.mover = 0;
  scene.items.push_back(item);
  const double voxel = scene.base->frame.spacing().x, high = is_on_bone ? 12 : 60;
  ChainPlay run(scene);
  std::mt19937 random(is_hook ? 5 : 4);
  std::normal_distribution<double> noise(0, 1);
  BoxMotionCounts counts;
  dvec3 at(0, 0, high + 48), about(0);
  std::vector<bool> is_passed(scene.tool->balls().size(), false);
  Placement box_before;
  for (int i = 0; i < 8000; ++i) {
    // Hand and box move at about 0.5 m/s and 20 rad/s.
    at += 0.25 * dvec3(noise(random), noise(random), noise(random)) + 0.02 * (dvec3(0, 0, high) - at);
    about += 0.01 * dvec3(noise(random), noise(random), noise(random)) - 0.01 * about;
    const Placement mesh{
        {14 * std::sin(0.021 * i), 9 * std::sin(0.033 * i), high + 8 * std::sin(0.027 * i + 1)},
        rotation_of({0.8 * std::sin(0.011 * i), 0.6 * std::sin(0.017 * i), std::sin(0.007 * i)})};
    const Placement& result = is_late && i > 0 ? box_before : mesh;
    const ProxyStep r =
        run.method.step(scene, run.seen, run.state, {at, std::span(&result, 1), rotation_of(about)});
    const Placement tool = run.tool(r);
    counts.contacts += r.has_contact;
    counts.buried += r.is_buried;
    counts.aside += glm::length(tool.position_world - at) > 0.5;
    for (std::size_t b = 0; b < scene.tool->balls().size(); ++b) {
      const dvec3 world = tool.world_from_local(scene.tool->balls()[b].centre),
                  to = mesh.local_from_world(world);
      const double off = box_distance(to, half);
      if (r.is_buried && off < k_radius - 0.1 * voxel) is_passed[b] = true;
      if (is_passed[b]) {
        is_passed[b] = off < k_radius;
        continue;
      }
      ++counts.checked;
      counts.in_box += off < k_radius - 0.1 * voxel;
      counts.in_bone += is_on_bone && std::abs(world.z) < 1.5 + k_radius - 0.1 * voxel;
    }
    box_before = mesh;
  }
  return counts;
}

// No ball enters the bone. No ball enters the moving box, unless the step reports that the box passes over
// the tool (is_buried), which never happens away from the bone. Planted fault: a method that receives the
// pose of the box one tick late is detected.
TEST(ChainProxy, AMovingMeshPushesItAndPassesOverItOnlyWhereReported) {
  for (const bool is_on_bone : {false, true})
    for (const bool is_hook : {false, true}) {
      SCOPED_TRACE(is_on_bone ? "on bone" : "away from it");
      const BoxMotionCounts counts = lead_box(is_on_bone, is_hook, false);
      EXPECT_GT(counts.contacts, 800);
      EXPECT_GT(counts.aside, 500);
      EXPECT_GT(counts.checked, 8000 * 4);
      EXPECT_EQ(counts.in_box, 0);
      EXPECT_EQ(counts.in_bone, 0);
      if (is_on_bone)
        EXPECT_LT(counts.buried, 800);
      else
        EXPECT_EQ(counts.buried, 0);
      RecordProperty((is_on_bone ? "buried_on_bone" : "buried") + std::string(is_hook ? "_hook" : "_rod"),
                     static_cast<int>(counts.buried));
      EXPECT_GT(lead_box(is_on_bone, is_hook, true).in_box, 100);
    }
}

TEST(ChainProxy, InvalidToolsAreRefused) {
  data_tools::PhantomOptions o = phantom_options(32);
  TouchScene scene = scenes::phantom_scene("sphere", o);
  EXPECT_NE(set_tool(scene, 0, rod(5, 3))->what.find("radius"), std::string::npos);
  EXPECT_NE(set_tool(scene, 2, std::vector<dvec3>(17))->what.find("too many balls"), std::string::npos);
  EXPECT_NE(set_tool(scene, 2, {{0, 0, 1e9}})->what.find("too far"), std::string::npos);
  EXPECT_NE(set_tool(scene, 2, {{0, std::nan(""), 0}})->what.find("too far"), std::string::npos);
  EXPECT_FALSE(scene.tool->is_six_dof());
  ChainProxy chain;
  EXPECT_EQ(chain.prepare(scene)->found, "chain, with a point");
  ASSERT_FALSE(set_tool(scene, 6, rod(5, 3)));
  EXPECT_FALSE(chain.prepare(scene));
  for (const MethodInfo& info : method_catalogue())
    EXPECT_EQ(make_method(info.name).value()->prepare(scene).has_value(), !info.takes(*scene.tool))
        << info.name;
}

}  // namespace
}  // namespace trephine::haptics
