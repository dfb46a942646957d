// Burrs driven by the contact force: rate, force, layers, breakthrough.
// One file: all of its tests use the vault and its scenes.
#include <array>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include "apps/bench/scenes/scenes.h"
#include "haptics/methods/methods.h"
#include "modules/drilling/burr.h"
#include "sim/drivers/lockstep.h"

namespace trephine::drilling {
namespace {

using glm::dvec3;

/// Returns the HU of a vault whose outer side is up: air above z = 6.8 mm, table, diploe, table, and soft
/// tissue below z = 0.
double vault_hounsfield(const dvec3& p) {
  constexpr double k_blur = 0.35;  // mm, sigma of the scanner's blur
  const auto above = [&](double z) { return 0.5 * (1 + std::erf((p.z - z) / (k_blur * std::sqrt(2.0)))); };
  return 40 + (1700 - 40) * above(0) + (750 - 1700) * above(1.8) + (1700 - 750) * above(4.6) +
         (-1000 - 1700) * above(6.8);
}
/// Returns a scene of a box of 16 x 16 x 24 mm. `smallest`: smallest burr of the scene, mm.
haptics::TouchScene vault(const dvec3& spacing,
                          const std::function<double(const dvec3&)>& hounsfield = vault_hounsfield,
                          double smallest = 4) {
  haptics::TouchScene scene =
      scenes::scene_of(scenes::sampled({-8, -8, -12}, {8, 8, 12}, spacing, hounsfield));
  EXPECT_FALSE(haptics::set_smallest_burr(scene, smallest).has_value());
  return scene;
}

const sim::Catalogue& catalogue() {
  static const Drilling module;
  static const sim::Catalogue all(std::vector<const sim::Module*>{&module});
  return all;
}

/// A hand that presses straight down with a steady force, as a mass with a damper.
struct Hand {
  double thrust = 4;     // N
  double mass = 0.15;    // kg
  double damping = 0.1;  // N s/mm, of a braced arm
  dvec3 at{0.05, -0.1, 8}, velocity{0.0};
  double reaction = 0.2;  // s, from the loss of resistance until the hand pulls back
  void advance(const dvec3& force, double press, double dt) {
    const double pushed = velocity.z + 1e3 * (force.z - press) / mass * dt;
    velocity.z = pushed / (1 + 1e3 * damping / mass * dt);  // stable at any rate
    at.z += velocity.z * dt;
  }
};

struct Trace {
  struct Tick {
    double t, depth, removed, press;
  };
  std::vector<Tick> ticks;
  std::optional<Breakthrough> through;
  dvec3 through_at{0.0};
  double hottest = 0, end = 0;
  /// Removal rate (mm3/s) between two depths of the hand (mm); 0 if it did not reach them.
  double rate(double from, double to) const {
    const Tick *first = nullptr, *last = nullptr;
    for (const Tick& one : ticks) {
      if (one.depth < from) first = last = nullptr;
      if (!first && one.depth >= from) first = &one;
      if (first && one.depth <= to) last = &one;
      if (one.depth > to) break;
    }
    return first && last && last->t > first->t ? (last->removed - first->removed) / (last->t - first->t) : 0;
  }
};

/// Presses a burr on the vault at `rate` (Hz) until the hand has pulled back from the breakthrough, but at
/// most for `seconds`. `stops_deep`: also ends at a depth of 4.5 mm.
Trace press_on(const haptics::TouchScene& scene, const Burr& burr, double rate, const Hand& start = {},
               double seconds = 30, bool stops_deep = false) {
  const auto method = haptics::make_method(haptics::k_default_method).value();
  EXPECT_FALSE(method->prepare(scene).has_value());
  sim::Engine engine(scene, *method, drilling::burr(burr), 1 / rate, catalogue());
  sim::Lockstep run(std::move(engine), {}, rate);
  Hand hand = start;
  Trace trace;
  double free_since = -1;
  const auto count = static_cast<int>(seconds * rate);
  for (int i = 0; i < count; ++i) {
    const double t = i / rate;
    const haptics::ServoRecord record = run.step(haptics::Pose{hand.at, {1, 0, 0, 0}, 1});
    const bool is_past = hand.at.z < 2 && !record.has_contact;
    if (!is_past) free_since = -1;
    if (is_past && free_since < 0) free_since = t;
    const bool has_noticed = free_since >= 0 && t - free_since > hand.reaction;
    hand.advance(record.force_world, has_noticed ? -hand.thrust : hand.thrust, 1 / rate);
    trace.ticks.push_back(
        {t, 6.8 - record.proxy_world.z, run.engine().removed_mm3(), glm::length(record.contact_force_world)});
    if (has_noticed && hand.at.z > 4) break;
    if (trace.ticks.back().depth > 4.5 && stops_deep) break;
  }
  const sim::Chronicle& all = run.engine().state().chronicle;
  for (std::size_t i = 0; i < all.size(); ++i)
    if (const auto* one = all[i].value.as<Breakthrough>())
      trace.through = *one, trace.through_at = all[i].position_world;
  for (const sim::Measure& one : run.engine().measures())
    if (one.unit == "K") trace.hottest = one.value;
  trace.end = hand.at.z;
  return trace;
}

constexpr double k_rates[] = {250, 1000, 4000};
constexpr double k_spacings[] = {0.3, 0.45, 0.6};

TEST(Burring, SteadyThrustRemovesTheSameAtAnyVoxelSizeAndLoopRate) {
  const struct {
    const char* name;
    double from, to;
  } layers[] = {{"outer table", 0.5, 1.8}, {"diploe", 2.6, 4.6}, {"inner table", 5.2, 6.4}};
  std::vector<std::array<double, 3>> all;
  for (const double spacing : k_spacings) {
    const haptics::TouchScene scene = vault(dvec3(spacing));
    for (const double rate : k_rates) {
      const Trace trace = press_on(scene, Burr{}, rate);
      std::array<double, 3>& one = all.emplace_back();
      for (std::size_t i = 0; i < 3; ++i) one[i] = trace.rate(layers[i].from, layers[i].to);
    }
  }
  for (std::size_t i = 0; i < 3; ++i) {
    double mean = 0, worst = 0;
    for (const auto& one : all) mean += one[i] / static_cast<double>(all.size());
    for (const auto& one : all) worst = std::max(worst, std::abs(one[i] / mean - 1));
    EXPECT_LT(worst, 0.05) << layers[i].name;
    EXPECT_GT(mean, 2);
    RecordProperty(std::string(layers[i].name).substr(0, 5) + "_worst_percent", std::to_string(100 * worst));
  }
  EXPECT_GT(all[0][1], 1.5 * all[0][0]);  // the diploe is softer
  EXPECT_GT(all[0][1], 1.5 * all[0][2]);
}

/// Returns the removal rate (mm3/s) of docs/drilling.md. A part of the contact force proportional to the
/// engaged area (mm2) only rubs; 0.3 of the rest is drag at the speed of the rim. A cutting burr needs 4 J
/// per mm3 of bone of 1.8 g/cm3; the energy scales with the square of the density.
double documented_rate(const Burr& burr, double press, double engaged, double hounsfield) {
  const bool is_diamond = burr.grade == Grade::diamond;
  const double speed = 3.14159265358979 * burr.diameter * 1e-3 * burr.rpm / 60;  // m/s
  const double density = 0.131 + 1.067e-3 * hounsfield, share = density / 1.8;
  const double joule = (is_diamond ? 4.0 * 165 / 63 : 4.0) * share * share;
  return 0.3 * (press - (is_diamond ? 0.02 : 0.05) * engaged) * speed / joule;
}

TEST(Burring, RateFollowsForceSpeedGradeAndDensity) {
  const auto solid = [](double hounsfield) {
    return [hounsfield](const dvec3& p) { return p.z < 6.8 ? hounsfield : -1000; };
  };
  const double disc = 3.14159265358979 * 4;  // mm2: deep in a hole the whole width of a 4 mm ball is engaged
  for (const double hounsfield : {900.0, 1600.0}) {
    const haptics::TouchScene scene = vault(dvec3(0.45), solid(hounsfield));
    for (const Burr& burr : {Burr{}, Burr{.grade = Grade::diamond}, Burr{.rpm = 30000}})
      for (const double thrust : {2.0, 5.0}) {
        Hand hand;
        hand.thrust = thrust;
        const Trace trace = press_on(scene, burr, 1000, hand, 120, true);
        const double found = trace.rate(3, 4), exact = documented_rate(burr, thrust, disc, hounsfield);
        EXPECT_NEAR(found / exact, 1, 0.04) << hounsfield << " HU, " << thrust << " N";
      }
  }
  // With too little force the burr only rubs, once enough of it is engaged.
  Hand hand;
  hand.thrust = 0.3;
  const Trace trace = press_on(vault(dvec3(0.45), solid(1600)), Burr{}, 1000, hand, 60);
  const auto at = [&](double t) { return trace.ticks[static_cast<std::size_t>(1000 * t)].removed; };
  EXPECT_GT(at(10), 1);
  EXPECT_LT(at(59) - at(49), 0.05 * at(10));
}

TEST(Burring, SteadyFeedMeetsTableDiploeTable) {
  // A stiff arm moves down at 0.15 mm/s against any resistance. The mean force (N) is taken in each layer.
  for (const double spacing : k_spacings) {
    haptics::TouchScene scene = vault(dvec3(spacing));
    scene.items[0].material.stiffness = 20;
    const auto method = haptics::make_method(haptics::k_default_method).value();
    ASSERT_FALSE(method->prepare(scene).has_value());
    sim::Lockstep run(scene, *method, burr(Burr{}), {}, 1000);
    double sum[3] = {}, count[3] = {};
    for (int i = 0; i < 60000; ++i) {
      const double z = 7 - 0.15e-3 * i;
      const haptics::ServoRecord record = run.step(haptics::Pose{{0.05, -0.1, z}, {1, 0, 0, 0}, 1});
      const double depth = 6.8 - record.proxy_world.z;
      const int layer = depth > 0.8 && depth < 1.8   ? 0
                        : depth > 3 && depth < 4.4   ? 1
                        : depth > 5.4 && depth < 6.3 ? 2
                                                     : -1;
      if (layer >= 0) sum[layer] += glm::length(record.contact_force_world), ++count[layer];
    }
    for (int i = 0; i < 3; ++i) {
      ASSERT_GT(count[i], 100);
      sum[i] /= count[i];
    }
    EXPECT_GT(sum[0], 1.5);  // N: cutting needs force
    EXPECT_LT(sum[1], 0.8 * sum[0]) << spacing;
    EXPECT_LT(sum[1], 0.8 * sum[2]) << spacing;
  }
}

TEST(Burring, BreakthroughIsReportedWithItsPlunge) {
  for (const double thrust : {2.0, 4.0})
    for (const double reaction : {0.1, 0.25}) {
      Hand hand;
      hand.thrust = thrust, hand.reaction = reaction;
      const Trace trace = press_on(vault(dvec3(0.45)), Burr{}, 1000, hand, 90);
      ASSERT_TRUE(trace.through.has_value()) << thrust << " " << reaction;
      EXPECT_NEAR(trace.through_at.z, 0, 0.6);  // at the vault's inner side
      EXPECT_NEAR(trace.through->thrust, thrust, 0.1 * thrust);
      // Expected plunge: a mass with a damper moves under a steady force for the reaction time, and then
      // under the reversed force until it rests. The contact spring (0.5 N/mm) adds its compression.
      const double tau = 1e-3 * hand.mass / hand.damping, fast = thrust / hand.damping;
      const double path = fast * (reaction - tau * (1 - std::exp(-reaction / tau)));
      const double speed = fast * (1 - std::exp(-reaction / tau));
      const double stop = tau * std::log(1 + speed / fast);
      const double rest = (speed + fast) * tau * (1 - std::exp(-stop / tau)) - fast * stop;
      EXPECT_NEAR(trace.through->plunge, path + rest + thrust / 0.5, 0.1 * (path + rest + thrust / 0.5));
    }
}

TEST(Burring, PoresAreNotABreakthrough) {
  const auto porous = [](const dvec3& p) {
    return p.z > 6.8 ? -1000.0 : p.z < 0 ? 40.0 : p.z > 3 && p.z < 4 ? 100.0 : 1500.0;
  };
  const Trace trace = press_on(vault(dvec3(0.45), porous), Burr{}, 1000);
  ASSERT_TRUE(trace.through.has_value());
  EXPECT_NEAR(trace.through_at.z, 0, 0.6);
}

/// HU of the built-in head's vault, interpolated and moved by `shift`, so that its outer side is at z = 6.8
/// mm as in vault_hounsfield(). `thick`: thickness of the vault, mm.
struct HeadVault {
  volume::Volume head;
  dvec3 shift{0, -20, 0};
  double thick = 0;

  HeadVault() : head(make()) {
    double z = 80;
    while (at({0, -20, z}) < 300) z -= 0.01;
    shift.z = z - 6.8;
    double in = z;
    while (in > z - 15 && at({0, -20, in}) >= 300) in -= 0.01;
    thick = z - in;
  }
  static volume::Volume make() {
    data_tools::PhantomOptions options;
    options.spacing_mm = dvec3(0.7);
    return data_tools::make_phantom("head", options).value();
  }
  double at(const dvec3& p_world) const {
    // The window has no high limit, so that its field is HU - k_low.
    constexpr double k_low = -2000;
    const volume::Field field(head, volume::Shape{.low = k_low});
    return k_low + field.value(head.frame.volume_from_world(p_world));
  }
};

TEST(Burring, OnTheHeadsVaultTheRateIsTheSameAndItsLayersAreNoticeable) {
  const HeadVault head;
  ASSERT_GT(head.thick, 3);
  ASSERT_LT(head.thick, 10);
  std::vector<double> rates;
  for (const double spacing : {0.4, 0.55, 0.7}) {
    haptics::TouchScene scene =
        vault(dvec3(spacing), [&](const dvec3& p) { return head.at(p + head.shift); });
    for (const double rate : k_rates) {
      const Trace trace = press_on(scene, Burr{}, rate, {}, 60);
      rates.push_back(trace.rate(0.15 * head.thick, 0.85 * head.thick));
      ASSERT_TRUE(trace.through.has_value());
      EXPECT_NEAR(trace.through_at.z, 6.8 - head.thick, 0.7);
    }
    // The burr is faster in the diploe than in either table. The tables are only slightly denser in this
    // head.
    const Trace trace = press_on(scene, Burr{}, 1000, {}, 60);
    const double t = head.thick;
    const double outer = trace.rate(0.1 * t, 0.3 * t), middle = trace.rate(0.45 * t, 0.65 * t),
                 inner = trace.rate(0.8 * t, 0.95 * t);
    EXPECT_GT(middle, 1.03 * outer) << spacing;
    EXPECT_GT(middle, 1.01 * inner) << spacing;
  }
  double mean = 0, worst = 0;
  for (const double one : rates) mean += one / static_cast<double>(rates.size());
  for (const double one : rates) worst = std::max(worst, std::abs(one / mean - 1));
  EXPECT_LT(worst, 0.05);
  EXPECT_GT(mean, 1);
}

/// Returns the least and the greatest width of a hole (mm): twice the least and the greatest distance from a
/// point on its axis to the bone, across the axis.
std::pair<double, double> gauge(const volume::Version& version, const dvec3& on_axis, const dvec3& axis) {
  const dvec3 side = glm::normalize(glm::cross(axis, dvec3(0.3, 0.5, 0.8))), other = glm::cross(axis, side);
  double least = 1e9, most = 0;
  for (int i = 0; i < 72; ++i) {
    const double angle = 6.283185307179586 * i / 72;
    const dvec3 direction = std::cos(angle) * side + std::sin(angle) * other;
    double low = 0, high = 6;
    for (int k = 0; k < 40; ++k) {
      const double middle = 0.5 * (low + high);
      const dvec3 p = version.base().frame.volume_from_world(on_axis + middle * direction);
      (version.distance(p) <= 0 ? low : high) = middle;
    }
    least = std::min(least, 2 * low), most = std::max(most, 2 * low);
  }
  return {least, most};
}

/// A scene and a method for a burr that touches bone with its whole body.
struct RoundBench {
  haptics::TouchScene scene;
  std::unique_ptr<haptics::ProxyMethod> method;
  RoundBench(double spacing, const Burr& burr,
             const std::function<double(const dvec3&)>& hounsfield = vault_hounsfield)
      : scene(vault(dvec3(spacing), hounsfield)) {
    const sim::ToolNeeds needs = drilling::burr(burr).type->needs(&burr, *scene.base);
    EXPECT_FALSE(haptics::set_smallest_burr(scene, needs.finest_cut).has_value());
    EXPECT_FALSE(haptics::set_tool(scene, needs.tool).has_value());
    method = haptics::make_method(needs.tool->is_six_dof() ? haptics::general_method(*needs.tool).name
                                                           : "subvoxel")
                 .value();
    const Status error = method->prepare(scene);
    EXPECT_FALSE(error.has_value()) << (error ? error->message() : "");
  }
};

TEST(Burring, AHoleHasTheBurrsWidth) {
  for (const Shape shape : {Shape::sphere, Shape::cylinder, Shape::barrel, Shape::match_head})
    for (const double spacing : k_spacings) {
      // Each case takes seconds: shapes other than the sphere are tested at one voxel size only.
      if (shape != Shape::sphere && spacing != (shape == Shape::barrel ? 0.45 : 0.6)) continue;
      const Burr burr{.diameter = 4, .removal_rate = 1000, .is_round = true, .shape = shape};
      const RoundBench bench(spacing, burr);
      sim::Lockstep run(bench.scene, *bench.method, drilling::burr(burr), {}, 1000);
      const dvec3 start(0.13, -0.21, 11);
      for (int i = 0; i < 900; ++i) {
        const double z = std::max(-4.0, start.z - 20e-3 * i);
        run.step(haptics::Pose{{start.x, start.y, z}, {1, 0, 0, 0}, 1});
      }
      const auto [least, most] = gauge(*run.engine().version(), {start.x, start.y, 4}, {0, 0, 1});
      EXPECT_NEAR(least, 4, 0.1) << static_cast<int>(shape) << " " << spacing;
      EXPECT_NEAR(most, 4, 0.1) << static_cast<int>(shape) << " " << spacing;
    }
}

TEST(Burring, TheShaftMeetsTheBoneAndCutsNothing) {
  // The burr is below the vault, and its shaft is in an existing hole of 4 mm. The hand then presses the
  // shaft on the wall of the hole.
  const auto pierced = [](const dvec3& p) {
    const double wall = std::clamp(std::hypot(p.x, p.y) - 2 + 0.5, 0.0, 1.0);
    return wall * vault_hounsfield(p) - (1 - wall) * 1000;
  };
  double force[2];
  for (const bool has_shaft : {false, true}) {
    const Burr burr{.diameter = 3, .is_round = true, .shaft = has_shaft ? 12.0 : 0.0};
    RoundBench bench(0.6, burr, pierced);
    sim::Lockstep run(bench.scene, *bench.method, drilling::burr(burr), {}, 1000);
    for (int i = 0; i < 150; ++i) run.step(haptics::Pose{{0, 0, 10 - 0.1 * i}, {1, 0, 0, 0}, 0});
    double most = 0;
    for (int i = 0; i < 200; ++i)
      most = std::max(
          most, glm::length(run.step(haptics::Pose{{1e-2 * i, 0, -5}, {1, 0, 0, 0}, 1}).contact_force_world));
    force[has_shaft] = most;
    EXPECT_EQ(run.engine().removed_mm3(), 0);
  }
  EXPECT_EQ(force[0], 0);
  EXPECT_GT(force[1], 0.2);
}

TEST(Burring, ATurningBurrDragsTheHandSidewaysAndShakesIt) {
  const haptics::TouchScene scene = vault(dvec3(0.45));
  const auto method = haptics::make_method(haptics::k_default_method).value();
  ASSERT_FALSE(method->prepare(scene).has_value());
  // Presses on flat bone: with the button, without it, and with a burr of a fixed removal rate.
  double aside[3] = {}, shake[3] = {};
  for (int kind = 0; kind < 3; ++kind) {
    sim::Lockstep run(scene, *method, burr(kind == 2 ? Burr{.removal_rate = 1e-3} : Burr{.feed_limit = 1e-3}),
                      {}, 1000);
    double last = 0;
    for (int i = 0; i < 1000; ++i) {
      // The stylus is along x: a burr turning under it drags along y.
      const haptics::ServoRecord record =
          run.step(haptics::Pose{{0, 0, std::max(2.8, 8 - 0.02 * i)},
                                 glm::dquat(std::sqrt(0.5), 0, std::sqrt(0.5), 0),
                                 kind == 1 ? 0u : 1u});
      if (i < 600) continue;
      aside[kind] += record.force_world.y / 400;
      if (i > 600) shake[kind] += std::abs(record.force_world.z - last) / 399;
      last = record.force_world.z;
    }
  }
  // The drag is 0.3 of a force of 2 N (a hand 4 mm deep at 0.5 N/mm). The burr's surface moves along x cross
  // z, which is -y, and the bone pushes it along +y.
  EXPECT_NEAR(aside[0], 0.6, 0.1);
  EXPECT_GT(shake[0], 0.02);
  for (const int kind : {1, 2}) {
    EXPECT_NEAR(aside[kind], 0, 0.02) << kind;
    EXPECT_LT(shake[kind], 0.01) << kind;
  }
}

TEST(Burring, TheForceOfABurrFollowsTheInstrument) {
  // Another burr has another force, a removed burr has no force, and other effects stay.
  const haptics::TouchScene scene = vault(dvec3(0.6));
  const auto method = haptics::make_method(haptics::k_default_method).value();
  ASSERT_FALSE(method->prepare(scene).has_value());
  sim::Lockstep run(sim::Engine(scene, *method, burr(Burr{}), 1e-3, catalogue()), {}, 1000);
  const auto laws = [&] {
    std::vector<std::string> words;
    if (const auto& set = run.engine().servo_scene()->hands[0].laws)
      for (const haptics::ServoLaw& law : set->laws()) words.push_back(law.words);
    return words;
  };
  const std::string cutting = "spin drag=0.3 chatter=0.1 frequency=80 most=3",
                    fine = "spin drag=0.3 chatter=0.03 frequency=160 most=3";
  EXPECT_EQ(laws(), std::vector{cutting});
  run.apply(sim::SetEffect{{3}, "gravity"});
  EXPECT_EQ(laws(), (std::vector<std::string>{"gravity", cutting}));
  EXPECT_FALSE(run.apply(Burr{.grade = Grade::diamond}).refused);
  EXPECT_EQ(laws(), (std::vector<std::string>{"gravity", fine}));
  EXPECT_TRUE(run.apply(sim::SetEffect{{0xffffffff}, "gravity"}).refused);
  EXPECT_FALSE(run.apply(Burr{.removal_rate = 30}).refused);
  EXPECT_EQ(laws(), std::vector<std::string>{"gravity"});
  EXPECT_FALSE(run.apply(Burr{}).refused);
  EXPECT_FALSE(run.apply(sim::RemoveInstrument{}).refused);
  EXPECT_EQ(laws(), std::vector<std::string>{"gravity"});
  // A burr is refused if the hand already has the maximum number of effects, and nothing changes.
  for (std::uint32_t id = 10; id < 17; ++id) EXPECT_FALSE(run.apply(sim::SetEffect{{id}, "gravity"}).refused);
  EXPECT_TRUE(run.apply(Burr{}).refused);
  EXPECT_EQ(laws().size(), 8u);
}

TEST(Burring, OtherShapesThanBallsFollowTheForceToo) {
  // A tremor tilts the tool, so that its whole face is engaged, as the formula assumes.
  const auto solid = [](const dvec3& p) { return p.z < 6.8 ? 1600.0 : -1000.0; };
  const haptics::TouchScene scene = vault(dvec3(0.45), solid, 2.4);
  for (const Shape shape : {Shape::cylinder, Shape::barrel, Shape::match_head}) {
    const auto method = haptics::make_method(haptics::k_default_method).value();
    ASSERT_FALSE(method->prepare(scene).has_value());
    const Burr tool{.shape = shape};
    sim::Lockstep run(scene, *method, burr(tool), {}, 1000);
    Hand hand;
    double at_first = 0;
    for (int i = 0; i < 20000; ++i) {
      const double tilt = 0.004 * std::sin(0.05 * i);
      const haptics::ServoRecord record =
          run.step(haptics::Pose{hand.at, glm::dquat(std::sqrt(1 - tilt * tilt), tilt, 0, 0), 1});
      hand.advance(record.force_world, hand.thrust, 1e-3);
      if (i == 12000) at_first = run.engine().removed_mm3();
    }
    const double rate = (run.engine().removed_mm3() - at_first) / 8, area = 3.14159265358979 * 4;
    EXPECT_NEAR(rate / documented_rate(tool, hand.thrust, area, 1600), 1, 0.15) << static_cast<int>(shape);
    const auto [least, most] = gauge(*run.engine().version(), {0.05, -0.1, 5.4}, {0, 0, 1});
    EXPECT_GT(least, 3) << static_cast<int>(shape);
    EXPECT_LT(most, 4.3) << static_cast<int>(shape);
  }
}

TEST(Burring, ASlidingBurrIsWatchedWhereItTouches) {
  // A burr that turns too slowly to cut slides over 10 mm. Forbidden structures must be tested at its present
  // position, not at that of its last cut.
  const haptics::TouchScene scene = vault(dvec3(0.45));
  const auto method = haptics::make_method(haptics::k_default_method).value();
  ASSERT_FALSE(method->prepare(scene).has_value());
  Burr slow;
  slow.grade = Grade::diamond, slow.rpm = 1000;
  const sim::Instrument tool = burr(slow);
  sim::Lockstep run(sim::Engine(scene, *method, tool, 1e-3, catalogue()), {}, 1000);
  double worst = 0;
  int count = 0;
  for (int i = 0; i < 2000; ++i) {
    const double x = i < 800 ? -5 : std::min(5.0, -5 + 0.01 * (i - 800));
    const haptics::ServoRecord record =
        run.step(haptics::Pose{{x, 0, std::max(6.65, 8 - 2e-3 * i)}, {1, 0, 0, 0}, 1});
    if (!record.has_contact) continue;
    ++count;
    const sim::ToolBall ball = tool.type->body(
        tool.parameters.data(), run.engine().state().settings.hands[0].state.data(), {record, 1e-3, false});
    worst = std::max(worst, glm::length(ball.centre - (record.proxy_world + dvec3(0, 0, 2))));
  }
  EXPECT_GT(count, 1000);
  EXPECT_LT(worst, 0.5);  // mm; up to 4 mm with the position of the last cut
}

TEST(Burring, ABurrAtRestWarmsNothing) {
  const haptics::TouchScene scene = vault(dvec3(0.6));
  const auto method = haptics::make_method(haptics::k_default_method).value();
  ASSERT_FALSE(method->prepare(scene).has_value());
  sim::Lockstep run(sim::Engine(scene, *method, burr(Burr{.is_dry = true}), 1e-3, catalogue()), {}, 1000);
  const auto hottest = [&] {
    for (const sim::Measure& one : run.engine().measures())
      if (one.unit == "K") return one.value;
    return 0.0;
  };
  for (int i = 0; i < 3000; ++i)
    run.step(haptics::Pose{{0, 0, std::max(3.0, 9 - 0.01 * i)}, {1, 0, 0, 0}, i < 2000 ? 0u : 1u});
  const double warm = hottest();
  EXPECT_GT(warm, 1);
  for (int i = 0; i < 2000; ++i) {
    run.step(haptics::Pose{{0, 0, 3}, {1, 0, 0, 0}, 0});
  }
  EXPECT_EQ(hottest(), warm);
}

}  // namespace
}  // namespace trephine::drilling
