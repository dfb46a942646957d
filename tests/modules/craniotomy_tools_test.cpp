// Tools that open a skull: perforator and craniotome, on a vault of table, diploe and table.
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <gtest/gtest.h>
#include <optional>

#include "apps/bench/scenes/scenes.h"
#include "haptics/methods/methods.h"
#include "modules/bone_flap/freehand.h"
#include "modules/drilling/craniotome.h"
#include "modules/drilling/perforator.h"
#include "sim/drivers/lockstep.h"
#include "tests/modules/events_of.h"

namespace trephine::drilling {
namespace {

using glm::dvec3;

/// Returns the HU of a vault of 7 mm over soft tissue, with its inner side at z = 0.
double vault_at(const dvec3& p) {
  const auto above = [&](double z) { return std::clamp(0.5 + (p.z - z) / 0.8, 0.0, 1.0); };
  return 40 + 1660 * above(0) - 950 * above(2) + 950 * above(4.6) - 2700 * above(7);
}

/// A scene with a tool, ready to run.
struct ToolBench {
  haptics::TouchScene scene;
  std::unique_ptr<haptics::ProxyMethod> method;
  sim::Catalogue catalogue;
  std::unique_ptr<sim::Lockstep> run;

  /// `dura`: height below which the labels name the dura; empty: no labels.
  ToolBench(const sim::Instrument& tool, const std::function<double(const dvec3&)>& hounsfield,
            const dvec3& spacing, const dvec3& low, const dvec3& high, std::optional<double> dura = {})
      : catalogue(std::vector<const sim::Module*>{&module()}) {
    volume::Volume scan = scenes::sampled(low, high, spacing, hounsfield);
    scene = scenes::scene_of(dura ? labelled(scan, *dura) : std::move(scan));
    const sim::ToolNeeds needs = tool.type->needs(tool.parameters.data(), *scene.base);
    EXPECT_FALSE(haptics::set_smallest_burr(scene, needs.finest_cut).has_value());
    EXPECT_FALSE(haptics::set_tool(scene, needs.tool).has_value());
    method = haptics::make_method(needs.tool->is_six_dof() ? haptics::general_method(*needs.tool).name
                                                           : "subvoxel")
                 .value();
    const Status error = method->prepare(scene);
    EXPECT_FALSE(error.has_value()) << (error ? error->message() : "");
    EXPECT_FALSE(tool.type->check(tool.parameters.data(), scene).has_value());
    run = std::make_unique<sim::Lockstep>(sim::Engine(scene, *method, tool, 4e-3, catalogue),
                                          haptics::ForceOptions{}, 250);  // fewer ticks and field updates
  }
  static const Drilling& module() {
    static const Drilling one;
    return one;
  }
  /// Returns the scan with labels of skull and dura.
  static volume::Volume labelled(const volume::Volume& scan, double dura) {
    volume::Volume result = volume::make_volume(scan.size, scan.frame, true).value();
    result.is_hounsfield = scan.is_hounsfield;
    result.label_names = {"", "skull", "dura"};
    for (int z = 0; z < scan.size.z; ++z)
      for (int y = 0; y < scan.size.y; ++y)
        for (int x = 0; x < scan.size.x; ++x) {
          const std::size_t i = scan.index(x, y, z);
          result.voxels[i] = scan.voxels[i];
          result.labels[i] = scan.frame.world_from_volume({x, y, z}).z < dura ? 2 : 1;
        }
    return result;
  }
  template <class Event>
  std::vector<std::pair<Event, dvec3>> events() const {
    return sim::events_of<Event>(run->engine());
  }
  template <class State>
  const State& state() const {
    return *run->engine().state().settings.hands[0].state.as<State>();
  }
  bool is_removed(const dvec3& p) const {
    return run->engine().version()->distance(scene.base->frame.volume_from_world(p)) <= 0;
  }
};

/// Moves the hand of a perforator down, to at most 8 mm below the proxy, until the clutch releases.
void drill_to_the_stop(ToolBench& bench) {
  sim::Lockstep& run = *bench.run;
  for (int i = 0; i < 3000 && !bench.state<PerforatorState>().has_stopped; ++i)
    run.step(haptics::Pose{
        {0.1, 0.2, std::max(14.0 - 16e-3 * i, run.last_record().proxy_world.z - 8)}, {1, 0, 0, 0}, 1});
}

TEST(Perforator, StopsByItselfAtTheEndOfTheBone) {
  for (const double spacing : {0.6, 0.9}) {
    ToolBench bench(perforator({.diameter = 8, .inner = 6, .lead = 2, .feed = 3}), vault_at, dvec3(spacing),
                    {-8, -8, -9}, {8, 8, 15});
    sim::Lockstep& run = *bench.run;
    drill_to_the_stop(bench);
    const auto stops = bench.events<PerforatorStopped>();
    ASSERT_EQ(stops.size(), 1u) << spacing;
    EXPECT_NEAR(stops[0].first.depth, 7, 0.8);
    EXPECT_NEAR(stops[0].second.z, 0, 0.8);
    EXPECT_TRUE(bench.is_removed({0, 0, 1}));
    EXPECT_TRUE(bench.is_removed({3.6, 0, 5}));   // the outer drill, behind the inner one
    EXPECT_FALSE(bench.is_removed({3.6, 0, 1}));  // a ledge on which the outer drill rests
    EXPECT_FALSE(bench.is_removed({4.3, 0, 5}));
    // After the release of the clutch no force cuts, and the hand does not pass the ledge.
    const double removed = run.engine().removed_mm3();
    for (int i = 0; i < 500; ++i) run.step(haptics::Pose{{0.1, 0.2, -6}, {1, 0, 0, 0}, 1});
    EXPECT_EQ(run.engine().removed_mm3(), removed);
    EXPECT_GT(run.last_record().proxy_world.z, 1.8);
    EXPECT_GT(run.last_record().force_world.z, 2);
  }
}

/// A drill whose button is released and pressed again continues its hole. It stops at the same depth as
/// without pauses, and removes nothing when it is pressed again in the finished hole.
TEST(Perforator, PausesDoNotChangeWhereItStops) {
  ToolBench bench(perforator({.diameter = 8, .inner = 6, .lead = 2, .feed = 3}), vault_at, dvec3(0.6),
                  {-8, -8, -9}, {8, 8, 15});
  sim::Lockstep& run = *bench.run;
  int presses = 0;
  for (int i = 0; i < 6000 && bench.events<PerforatorStopped>().empty(); ++i) {
    const bool is_pressed = i % 60 < 50;
    presses += i % 60 == 0;
    run.step(haptics::Pose{{0.1, 0.2, std::max(14.0 - 16e-3 * i, run.last_record().proxy_world.z - 8)},
                           {1, 0, 0, 0},
                           is_pressed ? 1u : 0u});
  }
  EXPECT_GT(presses, 5);
  const auto stops = bench.events<PerforatorStopped>();
  ASSERT_EQ(stops.size(), 1u);
  EXPECT_NEAR(stops[0].first.depth, 7, 0.8);
  EXPECT_NEAR(stops[0].second.z, 0, 0.8);
  const double removed = run.engine().removed_mm3();
  for (int press = 0; press < 4; ++press)
    for (int i = 0; i < 60; ++i)
      run.step(
          haptics::Pose{{0.1, 0.2, run.last_record().proxy_world.z - 8}, {1, 0, 0, 0}, i < 50 ? 1u : 0u});
  EXPECT_EQ(run.engine().removed_mm3(), removed);
  const auto later = bench.events<PerforatorStopped>();
  EXPECT_EQ(later.size(), 4u);
  for (const auto& [stop, at] : later) {
    EXPECT_NEAR(stop.depth, 7, 0.8);
    EXPECT_NEAR(at.z, 0, 0.8);
    EXPECT_TRUE(stop.was_open);
  }
}

/// A spur of the inner table below the tip does not keep the clutch engaged if the end of the drill is
/// through the bone around the spur.
TEST(Perforator, ASpurUnderTheTipDoesNotHoldIt) {
  const auto spurred = [](const dvec3& p) {
    const double spur = std::clamp((1 - std::hypot(p.x - 0.1, p.y - 0.2)) / 0.6 + 0.5, 0.0, 1.0);
    return p.z > 0.5 || p.z < -4 ? vault_at(p) : std::max(vault_at(p), 40 + 1660 * spur);
  };
  ToolBench bench(perforator({.diameter = 8, .inner = 6, .lead = 2, .feed = 3}), spurred, dvec3(0.6),
                  {-8, -8, -9}, {8, 8, 15});
  drill_to_the_stop(bench);
  const auto stops = bench.events<PerforatorStopped>();
  ASSERT_EQ(stops.size(), 1u);
  EXPECT_NEAR(stops[0].second.z, -0.4, 0.9);
}

/// On a ridge most of the drill's end is still outside the bone while its tip drills. The clutch does not
/// release there.
TEST(Perforator, ARidgeDoesNotReleaseItAtItsEntry) {
  const auto ridge = [](const dvec3& p) { return vault_at(p + dvec3(0, 0, 2 * std::abs(p.x - 0.1))); };
  ToolBench bench(perforator({.diameter = 14, .inner = 11, .feed = 3}), ridge, dvec3(0.7), {-10, -10, -16},
                  {10, 10, 17});
  drill_to_the_stop(bench);
  const auto stops = bench.events<PerforatorStopped>();
  ASSERT_EQ(stops.size(), 1u);
  EXPECT_NEAR(stops[0].first.depth, 7, 1);
}

/// The threshold finds bone down to a blurred edge, 1.2 mm below the upper face of the dura. If the scan has
/// labels, the clutch stops at the label of the dura.
TEST(Perforator, ABlurredEdgeBelowTheDuraDoesNotHoldIt) {
  const auto blurred = [](const dvec3& p) { return vault_at(p + dvec3(0, 0, 1.2)); };
  const auto tip_at_stop = [&](std::optional<double> dura) {
    ToolBench bench(perforator({.diameter = 8, .inner = 6, .lead = 2, .feed = 3}), blurred, dvec3(0.6),
                    {-8, -8, -9}, {8, 8, 15}, dura);
    drill_to_the_stop(bench);
    const auto stops = bench.events<PerforatorStopped>();
    EXPECT_EQ(stops.size(), 1u);
    return stops.empty() ? 99 : stops[0].second.z;
  };
  EXPECT_NEAR(tip_at_stop({}), -1.2, 0.8);
  EXPECT_NEAR(tip_at_stop(0), 0, 0.8);
  EXPECT_GT(tip_at_stop(0), tip_at_stop({}) + 0.5);
}

/// The vault with a hole of 10 mm at the origin.
double with_a_hole(const dvec3& p) {
  const double wall = std::clamp((std::hypot(p.x, p.y) - 5) / 0.8 + 0.5, 0.0, 1.0);
  return wall * vault_at(p) + (1 - wall) * (p.z > 7 ? -1000 : 40);
}

struct CraniotomeBench : ToolBench {
  explicit CraniotomeBench(const Craniotome& tool, double spacing = 0.6)
      : ToolBench(craniotome(tool), with_a_hole, dvec3(spacing), {-8, -12, -8}, {24, 20, 18}) {}
};

TEST(Craniotome, StartsOnlyInABurrHole) {
  const struct {
    dvec3 at;
    const char* why;
  } places[] = {{{14, 0, 3}, "in bone"}, {{2.8, 0, 2}, "foot"}, {{0, 0, 12}, "no bone"}};
  CraniotomeBench bench({});
  sim::Lockstep& run = *bench.run;
  std::size_t refused = 0;
  for (const auto& place : places) {
    // The hand starts at the position, without a path to it: a device may be anywhere when the button is
    // pressed.
    const double removed = run.engine().removed_mm3();
    sim::Lockstep there(sim::Engine(bench.scene, *bench.method, craniotome({}), 1e-3, bench.catalogue), {},
                        1000);
    for (int i = 0; i < 30; ++i) there.step(haptics::Pose{place.at, {1, 0, 0, 0}, i < 5 ? 0u : 1u});
    EXPECT_EQ(there.engine().removed_mm3(), removed);
    const sim::Chronicle& chronicle = there.engine().state().chronicle;
    for (std::size_t i = 0; i < chronicle.size(); ++i)
      if (const auto* event = chronicle[i].value.as<CraniotomeRefused>()) {
        ++refused;
        EXPECT_NE(event->reason.find(place.why), std::string::npos) << event->reason;
      }
  }
  EXPECT_EQ(refused, 3u);
}

/// Lowers the craniotome into the hole, with its foot below the vault.
void lower(sim::Lockstep& run) {
  for (int i = 0; i < 210; ++i)
    run.step(haptics::Pose{{0, 0, std::max(-1.0, 12 - 0.065 * i)}, {1, 0, 0, 0}, i < 205 ? 0u : 1u});
}
/// Pulls the craniotome for one tick: the hand is `by` mm from the proxy in direction `side`.
void pull(sim::Lockstep& run, const dvec3& side, double by = 4) {
  const dvec3 at = run.last_record().proxy_world + by * side;
  run.step(haptics::Pose{{at.x, at.y, -1}, {1, 0, 0, 0}, 1});
}

TEST(Craniotome, CutsAKerfOfItsWidthAboveItsFoot) {
  CraniotomeBench bench({}, 0.8);
  sim::Lockstep& run = *bench.run;
  const CraniotomeState& state = bench.state<CraniotomeState>();
  lower(run);
  for (int i = 0; i < 4000 && state.centre.x < 7; ++i) pull(run, {1, 0, 0});
  EXPECT_TRUE(bench.events<CraniotomeRefused>().empty());
  ASSERT_GE(state.centre.x, 7);
  EXPECT_LT(std::abs(state.centre.y), 0.1);
  for (const double x : {5.3, 5.8})
    for (const double z : {1.0, 3.0, 6.0}) {
      EXPECT_TRUE(bench.is_removed({x, 0, z})) << x << " " << z;
      for (const double side : {-1.0, 1.0}) {
        EXPECT_TRUE(bench.is_removed({x, 1.0 * side, z})) << x << " " << z;
        EXPECT_FALSE(bench.is_removed({x, 1.3 * side, z})) << x << " " << z;
      }
    }
  // The hand pulls the craniotome up. The foot, which is wider than the kerf, holds it.
  const double removed = run.engine().removed_mm3();
  const dvec3 at = run.last_record().proxy_world;
  for (int i = 0; i < 600; ++i) run.step(haptics::Pose{{at.x - 1, at.y, -1 + 1e-2 * i}, {1, 0, 0, 0}, 0});
  EXPECT_LT(run.last_record().proxy_world.z, 0.5);
  EXPECT_LT(run.last_record().force_world.z, -1);
  EXPECT_EQ(run.engine().removed_mm3(), removed);
}

TEST(Craniotome, TurnsAtMostAsTightAsItsFootAllows) {
  for (const double turning_radius : {2.0, 5.0}) {
    CraniotomeBench bench({.turning_radius = turning_radius}, 0.8);
    sim::Lockstep& run = *bench.run;
    const CraniotomeState& state = bench.state<CraniotomeState>();
    lower(run);
    for (int i = 0; i < 3000 && state.centre.x < 4.8; ++i) pull(run, {1, 0, 0});
    // Then the hand pulls obliquely to the side.
    double path = 0;
    dvec3 last = state.centre;
    const dvec3 before = state.heading;
    for (int i = 0; i < 4000 && path < 1.5; ++i) {
      pull(run, glm::normalize(state.heading + dvec3(-state.heading.y, state.heading.x, 0)));
      path += glm::length(state.centre - last);
      last = state.centre;
    }
    ASSERT_GE(path, 1.5);
    const double turned = std::acos(std::clamp(glm::dot(before, state.heading), -1.0, 1.0));
    EXPECT_LT(turned, 1.05 * path / turning_radius);
    EXPECT_GT(turned, 0.7 * path / turning_radius);
    EXPECT_GT(state.heading.y, 0);
    EXPECT_GT(state.centre.y, 0.05);
  }
}

TEST(Craniotome, CutsNothingBackwardSidewaysAndOutside) {
  CraniotomeBench bench({}, 0.8);
  sim::Lockstep& run = *bench.run;
  const CraniotomeState& state = bench.state<CraniotomeState>();
  lower(run);
  for (int i = 0; i < 3000 && state.centre.x < 5.5; ++i) pull(run, {1, 0, 0});
  const double removed = run.engine().removed_mm3();
  EXPECT_GT(removed, 10);
  for (const dvec3& side : {dvec3(-0.1, 1, 0), dvec3(-0.1, -1, 0)})
    for (int i = 0; i < 150; ++i) pull(run, glm::normalize(side), 2);
  // At most the last 0.2 mm at the end of the kerf are removed, and nothing at its sides.
  EXPECT_LT(run.engine().removed_mm3() - removed, 0.2 * 7 * 2.3 * 2);
  for (const double x : {5.0, 5.5, 6.0})
    for (const double side : {-1.0, 1.0})
      for (const double z : {1.0, 3.5, 6.0})
        EXPECT_FALSE(bench.is_removed({x, 1.35 * side, z})) << x << " " << z;
  // The hand lifts the craniotome out with the button pressed, and then presses it on the vault from above.
  for (int i = 0; i < 300; ++i)
    run.step(haptics::Pose{{0, 0, std::min(12.0, -1 + 0.05 * i)}, {1, 0, 0, 0}, 1});
  const double outside = run.engine().removed_mm3();
  for (int i = 0; i < 300; ++i)
    run.step(haptics::Pose{{7, 0, std::max(5.0, 12 - 0.05 * i)}, {1, 0, 0, 0}, 1});
  EXPECT_EQ(run.engine().removed_mm3(), outside);
}

/// A wall that the craniotome only touches does not set its direction. Back in the hole, the craniotome may
/// cut another wall.
TEST(Craniotome, OutOfItsKerfAnyDirectionIsOpen) {
  CraniotomeBench bench({}, 0.8);
  sim::Lockstep& run = *bench.run;
  const CraniotomeState& state = bench.state<CraniotomeState>();
  lower(run);
  for (int i = 0; i < 60; ++i) pull(run, {0, -1, 0}, 0.2);    // moves to a wall
  for (int i = 0; i < 40; ++i) pull(run, {0.3, -1, 0}, 0.2);  // moves along the wall
  EXPECT_LT(run.engine().removed_mm3(), 8);  // mm3: about a tenth of a millimetre of that wall
  for (int i = 0; i < 3000 && state.centre.x < 6; ++i)
    pull(run, glm::normalize(dvec3(1, -0.3 * run.last_record().proxy_world.y, 0)));
  ASSERT_GE(state.centre.x, 6);
  EXPECT_TRUE(bench.is_removed({5.5, 0, 3}));
  // Moves back through the hole with the button pressed, and cuts into the wall on its y side.
  for (int i = 0; i < 3000 && !(state.centre.y > 6); ++i) {
    const dvec3 at = run.last_record().proxy_world;
    pull(run, glm::normalize(at.x > 1 ? dvec3(-1, 0, 0) : dvec3(-0.3 * at.x, 1, 0)), at.x > 1 ? 0.5 : 4);
  }
  ASSERT_GE(state.centre.y, 6);
  EXPECT_TRUE(bench.is_removed({0, 5.5, 3}));
  EXPECT_FALSE(bench.is_removed({2, 6, 3}));
  EXPECT_FALSE(bench.is_removed({-2, 6, 3}));
}

/// The craniotome cuts along a circle from one burr hole to another, and back on the other side. The enclosed
/// piece is then detached automatically, and the craniotome can touch this piece.
TEST(Craniotome, JoinsBurrHolesAndDetachesTheEnclosedPiece) {
  constexpr double k_ring = 8.5, k_hole = 4;
  const auto with_holes = [&](const dvec3& p) {
    const double off = std::min(std::hypot(p.x - k_ring, p.y), std::hypot(p.x + k_ring, p.y));
    const double wall = std::clamp((off - k_hole) / 0.8 + 0.5, 0.0, 1.0);
    return wall * vault_at(p) + (1 - wall) * (p.z > 7 ? -1000 : 40);
  };
  ToolBench bench(craniotome({.turning_radius = 4}), with_holes, dvec3(0.8), {-15, -13, -8}, {15, 13, 18});
  sim::Lockstep& run = *bench.run;
  run.watch_pieces(50);
  const CraniotomeState& state = bench.state<CraniotomeState>();
  for (const double side : {1.0, -1.0}) {
    // Lowers the craniotome into one hole, and cuts along the ring to the middle of the other hole.
    for (int i = 0; i < 300; ++i)
      run.step(haptics::Pose{{side * k_ring, 0, std::max(-1.0, 14 - 0.1 * i)}, {1, 0, 0, 0}, 0});
    const auto has_come = [&] {
      const dvec3& at = run.last_record().proxy_world;
      return side * at.x < 0 && side * at.y < 0.3;
    };
    for (int i = 0; i < 6000 && !has_come(); ++i) {
      const dvec3 at = run.last_record().proxy_world, out = glm::normalize(dvec3(at.x, at.y, 0));
      const double off = std::hypot(at.x, at.y) - k_ring;
      pull(run, glm::normalize(dvec3(-out.y, out.x, 0) - 0.2 * off * out), 8);
    }
    ASSERT_TRUE(has_come()) << side << " " << state.centre.x << " " << state.centre.y;
    EXPECT_EQ(run.engine().state().undoable.bodies.size(), 0u);
    // The top of the bit lags behind: continue until the bit is upright in the hole, and then draw it out.
    for (int i = 0; i < 3000 && glm::length(run.last_record().turn_world) > 0.05; ++i)
      run.step(haptics::Pose{{-side * k_ring, -2 * side, -1}, {1, 0, 0, 0}, 1});
    for (int i = 0; i < 350; ++i)
      run.step(
          haptics::Pose{{-side * k_ring, 0, -1 + std::clamp(0.1 * (i - 150), 0.0, 15.0)}, {1, 0, 0, 0}, 0});
    ASSERT_GT(run.last_record().proxy_world.z, 10);
  }
  EXPECT_TRUE(bench.events<CraniotomeRefused>().empty());
  ASSERT_EQ(run.engine().state().undoable.bodies.size(), 1u);
  // `disc` is the disc inside the kerf. The piece is smaller, because the burr holes overlap the disc.
  const double mm3 = run.engine().state().undoable.bodies[0].piece->mm3,
               disc = 7 * 3.1416 * (k_ring - 1.15) * (k_ring - 1.15);
  EXPECT_LT(mm3, disc);
  EXPECT_GT(mm3, 0.6 * disc);
  // The piece is judged as a flap, although no command cut it.
  const std::optional<bone_flap::FlapState> flap = bone_flap::current_flap(run.engine().state());
  ASSERT_TRUE(flap);
  EXPECT_EQ(flap->flaps, 0);
  EXPECT_GT(std::abs(flap->normal.z), 0.99) << "a flat vault has no outer side";
  EXPECT_NEAR(flap->area, mm3 / 7, 0.05 * flap->area) << "the vault is 7 mm thick";
  double widest = 0;
  for (const dvec3& p : flap->outline) {
    widest = std::max(widest, std::hypot(p.x, p.y));
    EXPECT_LT(std::hypot(p.x, p.y), k_ring + 0.4);
  }
  EXPECT_NEAR(widest, k_ring, 0.4) << "the middle of the kerf";
  // The bit rests upright on the centre of the piece.
  for (int i = 0; i < 300; ++i) run.step(haptics::Pose{{0, 0, 14 - 0.04 * i}, {1, 0, 0, 0}, 0});
  EXPECT_TRUE(run.last_record().has_contact);
  EXPECT_NEAR(run.last_record().proxy_world.z, 7 + 2 * 1.15 * 0.5, 1.0);
}

TEST(Perforator, SetDownElsewhereItStartsAgain) {
  ToolBench bench(perforator({.diameter = 8, .inner = 6, .lead = 2, .feed = 3}), vault_at, dvec3(0.9),
                  {-14, -8, -9}, {14, 8, 15});
  sim::Lockstep& run = *bench.run;
  // Drills a shallow hole at one position, and moves through the air to another with the button pressed.
  for (int i = 0; i < 150; ++i)
    run.step(haptics::Pose{{-8, 0, std::max(7.0, 14 - 0.1 * i)}, {1, 0, 0, 0}, 1});
  const double first = run.engine().removed_mm3();
  EXPECT_GT(first, 5);
  for (int i = 0; i < 50; ++i) run.step(haptics::Pose{{-8 + 0.32 * i, 0, 14}, {1, 0, 0, 0}, 1});
  for (int i = 0; i < 60; ++i) run.step(haptics::Pose{{8, 0, std::max(8.5, 14 - 0.1 * i)}, {1, 0, 0, 0}, 1});
  for (const double x : {-3.0, 0.0, 3.0})
    for (const double z : {6.9, 5.0, 3.0}) EXPECT_FALSE(bench.is_removed({x, 0, z})) << x;  // no trench
  EXPECT_TRUE(bench.events<PerforatorStopped>().empty());
}

/// Undo restores bone around a burr and its shaft, which are in their hole, upright or tilted by 20 degrees.
/// The force stays small, the hand withdraws the tool freely, and the surface then stops the tool again.
TEST(BurrWithShaft, UndoAroundItReleasesTheTool) {
  const Burr burr{.diameter = 3, .removal_rate = 200, .is_round = true, .shaft = 12};
  for (const double degrees : {0.0, 20.0}) {
    ToolBench bench(drilling::burr(burr), vault_at, dvec3(0.6), {-8, -8, -9}, {8, 8, 15});
    sim::Lockstep& run = *bench.run;
    const glm::dquat tilt = glm::angleAxis(glm::radians(degrees), dvec3(0, 1, 0));
    const dvec3 ahead = tilt * dvec3(0, 0, -1), start = dvec3(0, 0, 9);
    const auto at = [&](double depth, unsigned buttons) {
      return run.step(haptics::Pose{start + depth * ahead, tilt, buttons});
    };
    for (int i = 0; i < 2500; ++i) at(std::min(7.0, 5e-3 * i), 1);
    ASSERT_GT(run.engine().removed_mm3(), 10);
    ASSERT_LT(run.last_record().proxy_world.z, 5.5) << "in its hole";
    at(7, 0);
    ASSERT_TRUE(run.undo().is_changed);
    double most = 0, turning = 0;
    for (int i = 0; i < 500; ++i) {
      const haptics::ServoRecord record = at(7, 0);
      most = std::max(most, glm::length(record.force_world));
      turning = std::max(turning, glm::length(record.torque_world));
      ASSERT_TRUE(std::isfinite(most) && std::isfinite(turning));
    }
    EXPECT_LT(most, 3.1) << turning;
    EXPECT_LT(turning, 5);
    EXPECT_EQ(run.last_record().faults, 0u);
    double pull = 0;  // N, force of the bone against the withdrawal
    for (int i = 0; i < 400; ++i) pull = std::max(pull, glm::dot(at(7 - 0.05 * i, 0).force_world, ahead));
    EXPECT_LT(pull, 0.2) << degrees;
    EXPECT_FALSE(run.last_record().has_contact);
    EXPECT_LT(glm::length(run.last_record().proxy_world - run.last_record().pose.position_world), 1e-9);
    for (int i = 0; i < 400; ++i) at(-13 + 0.05 * i, 0);
    EXPECT_TRUE(run.last_record().has_contact) << degrees;
    EXPECT_GT(run.last_record().proxy_world.z, 8) << degrees;
  }
}

TEST(CraniotomyTools, InvalidToolsAreRefused) {
  // The scene has a point as its tool: a valid craniotome and a valid perforator are refused as well.
  haptics::TouchScene scene;
  const sim::Instrument bad[] = {perforator({.diameter = 10, .inner = 12}),
                                 craniotome({.diameter = 3, .foot = 2}), craniotome({}), perforator({})};
  for (const sim::Instrument& tool : bad)
    EXPECT_TRUE(tool.type->check(tool.parameters.data(), scene).has_value());
  EXPECT_TRUE(sim::Value(Craniotome{.turning_radius = -1}).check().has_value());
  EXPECT_TRUE(sim::Value(Perforator{.feed = std::nan("")}).check().has_value());
}

}  // namespace
}  // namespace trephine::drilling
