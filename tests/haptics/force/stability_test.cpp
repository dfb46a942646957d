// No proxy falls through, generated energy is bounded, and bad input from a device never causes more than a
// latched fault.
#include "apps/bench/stability.h"

#include <cmath>
#include <cstdlib>
#include <limits>
#include <map>
#include <set>

#include "apps/bench/attack.h"
#include "apps/verify/force_judge.h"
#include "haptics/force/passivity.h"
#include "haptics/servo/servo_core.h"
#include "tests/haptics/proxy/method_play.h"
#include "tests/scenes/golden.h"
#include "tests/whole.h"
#include "volume/base/deterministic_math.h"

namespace trephine::haptics {
namespace {

using glm::dvec3;

/// Returns the number of steps of a random attack. Slow builds make fewer steps, since each step takes about
/// twenty times as long. The environment variable TREPHINE_ATTACK_STEPS overrides the number.
long attack_steps() {
  if (const char* wanted = std::getenv("TREPHINE_ATTACK_STEPS")) return std::atol(wanted);
  return k_is_fast_build ? 300'000 : 60'000;
}

TEST(Stability, NothingFallsThroughInRandomStepsCutAndUndoneUnderTheTool) {
  bench::AttackOptions options;
  options.steps = attack_steps();
  long steps = 0, contacts = 0, buried = 0, undos = 0, by_shape = 0;
  double fastest = 0;
  for (const bench::AttackRow& row : bench::run_attack(options)) {
    EXPECT_EQ(row.fall_throughs, 0) << row.method << " on " << row.scene;
    EXPECT_EQ(row.too_deep, 0) << row.method << " on " << row.scene;
    EXPECT_EQ(row.not_finite, 0) << row.method << " on " << row.scene;
    by_shape += row.judged_by_shape;
    if (row.steps > 2000) {  // with more than one start
      EXPECT_GT(row.contacts, row.steps / 100) << row.method << " on " << row.scene;
    }
    undos += row.undos;
    fastest = std::max(fastest, row.fastest_mm_s);
    steps += row.steps, contacts += row.contacts, buried += row.buried;
  }
  EXPECT_GE(steps,
            options.steps * 7 / 10);  // methods refuse scenes with models or burrs that they do not support
  EXPECT_GT(contacts, steps / 4);
  EXPECT_GT(by_shape, contacts / 2);
  EXPECT_GT(fastest, 9000);
  EXPECT_GT(undos, steps / 4000);
  if (steps > 200'000) {
    EXPECT_GT(buried, 0);  // undo restored matter over the tool
  }
}

/// Planted fault: the proxy is moved to the HIP, through walls. The judge of each kind of solid detects it,
/// also from inside a solid and with fine cuts.
TEST(Stability, TheAttackCatchesAProxyThatIsMovedThroughWalls) {
  bench::AttackOptions options;
  options.steps = 36'000;
  options.seed = 5;  // a seed that reaches contact in every scene
  long contacts = 0;
  options.spoil = [&](ProxyStep& step, const dvec3& hip_volume, const dvec3& hip_world) {
    if (!step.has_contact || ++contacts % 10 != 0) return;
    step.proxy_world = hip_world;
    step.path_volume[0] = hip_volume;
    step.waypoint_count = 1;
  };
  long sunk = 0, by_shape = 0;
  std::set<std::string> seen;
  for (const bench::AttackRow& row : bench::run_attack(options)) {
    if (row.contacts > 30) {
      EXPECT_GT(row.fall_throughs, 0) << row.method << " on " << row.scene << ", " << row.contacts;
      seen.insert(row.scene), seen.insert(row.method);
    }
    sunk += row.too_deep, by_shape += row.judged_by_shape;
  }
  for (const MethodInfo& info : method_catalogue()) {
    EXPECT_TRUE(info.solid == MethodInfo::Solid::nothing || seen.contains(info.name)) << info.name;
  }
  for (const char* name : {"gyroid, from within", "gyroid, two shapes", "gyroid, ball of 3 mm",
                           "gyroid, fine cuts", "corner, slices 1:8, fine cuts", "gyroid pierced by a mesh"})
    EXPECT_TRUE(seen.contains(name)) << name;
  EXPECT_GT(sunk, by_shape / 200);
}

/// Planted fault: a tool that follows the hand and reports that it is buried, although no matter grew.
TEST(Stability, TheAttackCatchesBurialsWithoutGrowth) {
  bench::AttackOptions options;
  options.steps = 9'000;
  options.methods = {"chain"};
  long contacts = 0;
  options.spoil = [&](ProxyStep& step, const dvec3&, const dvec3& hip_world) {
    if (!step.has_contact || ++contacts % 20 != 0) return;
    step.proxy_world = hip_world;
    step.is_buried = true;
  };
  long falls = 0;
  for (const bench::AttackRow& row : bench::run_attack(options)) falls += row.fall_throughs;
  EXPECT_GT(falls, contacts / 100);
}

/// Baselines that guarantee no solid fall through walls, and the judge detects it.
TEST(Stability, TheAttackCatchesMethodsThatPromiseNothing) {
  bench::AttackOptions options;
  options.steps = 36'000;
  options.methods = {"raystep", "plane", "gradient"};
  std::map<std::string, long> falls;
  for (const bench::AttackRow& row : bench::run_attack(options)) falls[row.method] += row.fall_throughs;
  for (const std::string& method : options.methods) EXPECT_GT(falls[method], 10) << method;
}

/// Simulates an hour of contact, or a minute in slow builds.
TEST(Stability, AnHourOfContactDoesNotDriftAndGivesTheSameBitsOnEveryCompiler) {
  const bool is_whole = k_is_fast_build;
  const bench::SoakRow soak = bench::run_contact_soak(is_whole ? 3'600'000 : bench::SoakRow::k_early);
  EXPECT_EQ(soak.not_finite, 0);
  EXPECT_GT(soak.contacts, soak.steps / 4);
  EXPECT_LT(soak.drift_mm, 1e-9);
  EXPECT_GT(soak.frictionless_contacts, soak.frictionless_steps / 4);
  EXPECT_LT(soak.max_generated, 0.02);  // N mm: the energy of one step, 0.5 N/mm x 2 mm x 0.02 mm
  EXPECT_EQ(soak.early_hash, scenes::golden("soak, its first minute"));
  if (is_whole) {
    EXPECT_EQ(soak.hash, scenes::golden("soak, its hour"));
  }
}

TEST(Stability, StiffnessMapsAgreeWithTheory) {
  long rows = 0, of_encoders = 0;
  for (const bench::StiffnessRow& row : bench::run_stiffness_maps({})) {
    SCOPED_TRACE(testing::Message() << row.surface << ", " << row.what << ", " << row.rate_hz << " Hz, alpha "
                                    << row.alpha << ", late " << row.delay_s << ", encoder "
                                    << row.encoder_mm);
    ++rows;
    const double of_encoder = row.encoder_mm > 0 ? 2 * row.coulomb_n / row.encoder_mm : 0;
    if (of_encoder > row.theory) {
      // Coulomb friction adds to the damping, up to the limit 2 f / d that the step d of the encoder sets.
      EXPECT_GT(row.simulated, 0.98 * row.theory);
      EXPECT_LT(row.simulated, 1.02 * of_encoder);
      continue;
    }
    of_encoders += of_encoder > 0;
    EXPECT_NEAR(row.simulated / row.theory, 1, 0.05);
    EXPECT_GT(row.simulated, 0.98 * row.rule);  // the rule of thumb errs on the safe side
  }
  EXPECT_EQ(rows, 3 * 6 * 7);
  EXPECT_GE(of_encoders, 3 * 3);
}

TEST(Stability, EnergyIsBoundedInsideTheBoundAndHeldByTheControllerBeyond) {
  double step_inside = 0;  // largest energy of a step, N mm, with a stiffness below the bound
  for (const bench::EnergyRow& row : bench::run_energy_test()) {
    SCOPED_TRACE(row.surface + ", " + std::to_string(row.stiffness_over_bound) + " times the bound, delay " +
                 std::to_string(row.delay_ticks));
    EXPECT_GT(row.contact_share, 0.05);  // beyond the bound, the hand chatters on the surface
    if (row.delay_ticks == 0 && row.stiffness_over_bound < 1) {
      EXPECT_GE(row.balance_without_controller, -1e-6);
      EXPECT_LE(row.max_generated, row.most_work);
      step_inside = row.most_work;
    }
    // Planted fault: beyond the bound, and with delay, energy is generated without the controller.
    if (row.stiffness_over_bound > (row.delay_ticks > 0 ? 0.8 : 2)) {
      EXPECT_GT(row.max_generated, 10 * step_inside);
      EXPECT_LT(row.balance_without_controller, -2);
    }
    // With the controller, at most the energy of one step is generated. If forces are delayed, the controller
    // detects it late, and the limit is higher.
    EXPECT_LT(row.max_generated_with_controller,
              (row.delay_ticks > 0 ? 1.2 : 1) * row.most_work_with_controller);
    if (row.delay_ticks == 0) {
      EXPECT_LT(row.max_generated_with_controller, 1.5 * step_inside);
      EXPECT_GE(row.balance_with_controller, -1e-6);
    }
    // The controller does not remove the surface: the hand stays in contact.
    EXPECT_GT(row.contact_share_with_controller, 0.9);
    EXPECT_GT(row.force_scale, row.delay_ticks > 0 ? 0.025 : 0.999);
  }
}

TEST(Passivity, ASpringThatReturnsMoreThanItTookIsLimited) {
  // The hand moves in along x against 1 N/mm, and out with 2 N/mm.
  PassivityController controller;
  double given = 0, last_force = 0, last_x = 0;
  for (int i = 0; i <= 400; ++i) {
    const double x = i <= 200 ? -0.01 * i : -0.01 * (400 - i);
    given += last_force * (x - last_x);
    const double wanted = (i <= 200 ? 1.0 : 2.0) * -x;
    last_force = controller.step(dvec3{wanted, 0, 0}, {x, 0, 0}, dvec3(0)).force_world.x;
    last_x = x;
    EXPECT_LE(last_force, wanted + 1e-12);
  }
  EXPECT_NEAR(given, controller.energy(), 1e-9);
  EXPECT_LT(given, 0.05);
  EXPECT_GT(controller.limited_ticks(), 0);
  // A sampled spring generates the energy K x dx = 0.02 N mm. With an allowance of 0.021 N mm, the controller
  // leaves it unchanged.
  PassivityController quiet(0.021);
  for (int i = 0; i <= 400; ++i) {
    const double x = i <= 200 ? -0.01 * i : -0.01 * (400 - i);
    EXPECT_NEAR(quiet.step(dvec3{-x, 0, 0}, {x, 0, 0}, dvec3(0)).force_world.x, -x, 1e-9);
  }
}

/// A hand turns a torsional spring, which returns more energy than it took: the torque of the spring is
/// limited, as forces are.
TEST(Passivity, ATorqueThatReturnsMoreThanItTookIsLimited) {
  PassivityController controller;
  double given = 0, last_torque = 0, last_angle = 0;
  for (int i = 0; i <= 400; ++i) {
    const double angle = i <= 200 ? -0.001 * i : -0.001 * (400 - i);
    given += last_torque * (angle - last_angle);
    const double wanted = (i <= 200 ? 400.0 : 800.0) * -angle;  // N mm
    const glm::dquat hand(std::cos(0.5 * angle), std::sin(0.5 * angle), 0, 0);
    const Wrench rendered = controller.step({dvec3(0), dvec3(wanted, 0, 0)}, dvec3(0), dvec3(0), hand);
    EXPECT_EQ(rendered.force_world, dvec3(0));
    last_torque = rendered.torque_world.x;
    last_angle = angle;
    EXPECT_LE(last_torque, wanted + 1e-9);
  }
  EXPECT_NEAR(given, controller.energy(), 1e-3);
  EXPECT_LT(given, 0.5);  // N mm; 8 N mm without a controller
  EXPECT_GT(controller.limited_ticks(), 0);
}

/// A hand moves in and out of a spring whose force is one tick late. Each cycle generates energy, and the
/// controller softens the spring until no more energy is generated. Out of contact the spring becomes firm
/// again. The judge computes the softening by itself, and detects a controller that does not soften.
TEST(Passivity, ALateActiveSpringIsSoftened) {
  for (const bool is_wrong : {false, true}) {
    PassivityController controller(0, 1);
    verify::ForceLaw law;
    law.alpha = 1, law.slew = 1e9, law.is_passive = true, law.delay_ticks = 1;
    verify::ForceJudge judge(law);
    double softest = 1, energy = 0;
    dvec3 last_x(0), last_force(0);
    for (int i = 0; i < 6000; ++i) {
      if (i == 700) {  // lost ticks
        controller.on_lost_ticks();
        judge.restart(false);
      }
      // In slowly, and out at once.
      const double z = i < 3000 && i % 50 < 49 ? -0.02 * (i % 50) : 0.5, k = 2;
      const dvec3 x(0, 0, z), proxy(0, 0, std::max(0.0, z)), wanted = k * (proxy - x);
      dvec3 force = controller.step(wanted, x, proxy).force_world;
      softest = std::min(softest, controller.force_scale());
      if (is_wrong && controller.force_scale() > 0) force /= controller.force_scale();
      energy += i > 0 ? glm::dot(last_force, x - last_x) : 0;
      verify::ForceTick tick;
      tick.position = x, tick.proxy = proxy, tick.normal = {0, 0, 1}, tick.force = force;
      tick.stiffness = k, tick.has_contact = z < 0, tick.contact_energy = energy;
      judge.judge_tick(tick);
      controller.set_rendered(force);
      last_x = x, last_force = force;
    }
    EXPECT_LT(softest, 0.9);
    EXPECT_GT(controller.force_scale(), 0.99);
    EXPECT_EQ(judge.wrong_forces() > 0, is_wrong) << judge.worst_force_n();
  }
}

/// A slow hand on a soft wall with a late force generates energy only by rounding: nothing is softened.
TEST(Passivity, ALatePassiveSpringStaysFirm) {
  for (const int delay : {1, 2, 4})
    for (const double hz : {0.5, 2.0}) {
      PassivityController controller(0, delay);
      dvec3 wanted(0);
      double softest = 1;
      for (int i = 0; i < 8000; ++i) {
        const dvec3 x(0, 0, std::sin(2 * 3.14159265 * hz * 1e-3 * i)), proxy(0, 0, std::max(0.0, x.z));
        wanted = 0.3 * 0.1 * (proxy - x) + 0.7 * wanted;
        controller.step(wanted, x, proxy);
        softest = std::min(softest, controller.force_scale());
      }
      EXPECT_GT(softest, 0.99) << delay << " " << hz;
    }
}

TEST(Passivity, AResetClearsTheStoreButNotForcesInFlight) {
  PassivityController controller(0, 2);
  for (int i = 0; i < 10; ++i) controller.step(dvec3{1, 0, 0}, {-0.01 * i, 0, 0}, dvec3(0));
  EXPECT_LT(controller.energy(), 0);
  controller.reset();
  EXPECT_EQ(controller.energy(), 0);
  controller.step(dvec3{0, 0, 0}, {0, 0, 0},
                  dvec3(0));  // the force of two ticks ago is still rendered
  EXPECT_NEAR(controller.energy(), 0.09, 1e-12);
}

/// Energy that was lost to friction must not be returned. A surface that generates energy is limited to the
/// energy of one step, without and with 150 mm of sliding before.
TEST(Passivity, FrictionLossIsNotReturned) {
  double most[2] = {0, 0};
  for (const double slide : {0.0, 150.0}) {
    PassivityController controller;
    double given = 0;  // work of the normal force on the hand, N mm
    dvec3 x(0, 0, -0.1), last_x = x, force(0);
    const auto tick = [&](const dvec3& to, double stiffness) {
      x = to;
      given += force.z * (x.z - last_x.z);
      // The proxy is on the plane z = 0 and trails the hand by its friction.
      const dvec3 proxy(x.x - 0.3 * -x.z, 0, 0);
      force = controller.step(stiffness * (proxy - x), x, proxy).force_world;
      last_x = x;
    };
    for (int i = 0; i <= 1000; ++i) tick({slide * i / 1000, 0, -0.1}, 12);
    // The hand moves in against 6 N/mm and out with 12 N/mm: without a controller, each cycle generates 3 N
    // mm.
    for (int push = 0; push < 5; ++push)
      for (int i = 0; i <= 200; ++i)
        tick({slide, 0, -0.1 - 0.01 * (i <= 100 ? i : 200 - i)}, i <= 100 ? 6 : 12);
    most[slide > 0] = given;
  }
  EXPECT_LT(most[0], 0.15);
  EXPECT_LT(most[1], 0.15);  // N mm; the energy of one step is 12 N/mm x 1.1 mm x 0.01 mm
}

/// The controller computes the energy from the rendered force, even if it differs from the requested force.
TEST(Passivity, CountsTheRenderedForceInsteadOfTheRequested) {
  PassivityController controller;
  controller.step(dvec3{1, 0, 0}, {0, 0, 0}, dvec3(0));
  controller.set_rendered(dvec3{3, 0, 0});
  controller.step(dvec3{0, 0, 0}, {0.5, 0, 0}, dvec3(0));
  EXPECT_NEAR(controller.energy(), 1.5, 1e-12);
  // After lost ticks, generated energy (positive) is kept, and stored energy (negative) is discarded.
  controller.on_lost_ticks();
  EXPECT_NEAR(controller.energy(), 1.5, 1e-12);
  controller.step(dvec3{1, 0, 0}, {0, 0, 0}, dvec3(0));
  controller.set_rendered(dvec3{1, 0, 0});
  controller.step(dvec3{1, 0, 0}, {-5, 0, 0}, dvec3(0));
  EXPECT_NEAR(controller.energy(), -3.5, 1e-12);
  controller.on_lost_ticks();
  EXPECT_EQ(controller.energy(), 0);
}

/// For any input the output is finite and within the limit, and a fault is latched until reset.
TEST(Poison, NoInputGivesANonFiniteOutput) {
  for (const MethodInfo& info : method_catalogue()) {
    TouchScene scene = scenes::phantom_scene("gyroid", phantom_options(48, 0.7));
    if (info.takes_shells) {
      ASSERT_FALSE(set_tool(scene, std::make_shared<const ToolShape>(ToolProfile{{{-5, 2}, {5, 2}}, 1})));
    } else if (!info.takes(*scene.tool)) {
      ASSERT_FALSE(set_tool(scene, 2, {{-5, 0, 0}, {0, 0, 0}, {5, 0, 0}}));
    }
    const auto method = make_method(info.name).value();
    ASSERT_FALSE(method->prepare(scene).has_value());
    const ServoScene seen = scene_for_one(scene, *method, std::make_shared<volume::Version>(scene.base));
    ServoCore core({}, 1e-3);
    const double nan = std::nan(""), inf = std::numeric_limits<double>::infinity(),
                 tiny = std::numeric_limits<double>::denorm_min();
    const double poison[] = {nan, inf, -inf, tiny, -tiny, 1e300, -1e300, 1e9, 1e-300, 0, -0.0};
    for (int i = 0; i < 6000; ++i) {
      ServoInput input;
      const auto random = [&](int k) { return hash_normal(11, static_cast<std::uint64_t>(4 * i + k)); };
      input.pose.position_world = 30.0 * dvec3(random(0), random(1), random(2));
      if (i % 7 == 3)
        input.pose.position_world[i % 3] = poison[static_cast<std::size_t>(i / 7) % std::size(poison)];
      const ServoRecord record = core.step(seen, input);
      const double force = glm::length(record.force_world);
      ASSERT_TRUE(std::isfinite(force)) << info.name << " " << i;
      ASSERT_LE(force, 8 + 1e-9);
      ASSERT_TRUE(std::isfinite(record.proxy_world.x + record.proxy_world.y + record.proxy_world.z))
          << info.name;
      // A fault stays latched until reset().
      if (record.faults & k_latched_faults) {
        EXPECT_EQ(record.force_world, dvec3(0));
        EXPECT_NE(core.step(seen, {}).faults & k_latched_faults, 0u);
        core.reset();
        EXPECT_EQ(core.step(seen, {}).faults & k_latched_faults, 0u);
      }
    }
  }
}

TEST(Poison, OddScenesAreTouchedWithoutHarm) {
  struct Odd {
    const char* what;
    glm::ivec3 size;
    double spacing, origin;
    int filling;  ///< 0 empty, 1 all bone, 2 a ball
    double low, high;
  };
  const Odd odd[] = {{"empty", {24, 24, 24}, 1, 0, 0, 300, 1e308},
                     {"all bone", {24, 24, 24}, 1, 0, 1, 300, 1e308},
                     {"fine", {24, 24, 24}, 1e-3, 0, 2, 300, 1e308},
                     {"coarse", {24, 24, 24}, 1e3, 0, 2, 300, 1e308},
                     {"far away", {24, 24, 24}, 1, 1e6, 2, 300, 1e308},
                     {"one voxel", {1, 1, 1}, 1, 0, 1, 300, 1e308},
                     {"a window of no width", {24, 24, 24}, 1, 0, 2, 500, 500},
                     {"flat", {24, 1, 24}, 1, 0, 1, 300, 1e308}};
  for (const Odd& o : odd) {
    volume::Volume result =
        volume::make_volume(o.size, volume::Frame::from_spacing(dvec3(o.origin), dvec3(o.spacing)).value())
            .value();
    for (int z = 0; z < o.size.z; ++z)
      for (int y = 0; y < o.size.y; ++y)
        for (int x = 0; x < o.size.x; ++x) {
          const double r = glm::length(dvec3(x, y, z) - 11.5);
          result.voxels[result.index(x, y, z)] =
              static_cast<std::int16_t>(o.filling == 0   ? -1000
                                        : o.filling == 1 ? 1500
                                                         : std::clamp(500 - 400 * (r - 8), -1000.0, 1500.0));
        }
    TouchScene scene;
    scene.base = std::make_shared<const volume::Volume>(std::move(result));
    volume::Shape shape;
    shape.low = o.low, shape.high = o.high;
    scene.items.push_back(
        {volume::Field(*scene.base, shape),
         std::make_shared<const volume::Occupancy>(volume::Occupancy::build(*scene.base, shape)), Material{},
         Side::front});
    for (const MethodInfo& info : method_catalogue()) {
      if (!info.takes_points) continue;
      Play play(info.name, scene);
      for (int i = 0; i < 600; ++i) {
        const auto random = [&](int k) { return hash_normal(5, static_cast<std::uint64_t>(3 * i + k)); };
        const dvec3 v = 0.5 * dvec3(o.size) + 0.6 * dvec3(o.size) * dvec3(random(0), random(1), random(2));
        const ProxyStep s = play.step(scene.base->frame.world_from_volume(v));
        ASSERT_TRUE(std::isfinite(s.proxy_world.x + s.proxy_world.y + s.proxy_world.z))
            << o.what << " " << info.name;
      }
      if (info.solid != MethodInfo::Solid::nothing) {
        EXPECT_EQ(play.judge.fall_throughs(), 0) << o.what << " " << info.name;
      }
    }
  }
}

}  // namespace
}  // namespace trephine::haptics
