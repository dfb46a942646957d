// Features that a scene does not use have no cost. The tests compare the number of instructions per tick of
// the same contact, with and without features in the program, in the operation's past, and in its plan.
#include <cstdio>

#include "apps/bench/instructions.h"
#include "haptics/proxy/subvoxel_proxy.h"
#include "modules/catalogue.h"
#include "tests/sim/session_fixture.h"

namespace trephine::sim {
namespace {

constexpr int k_ticks = 4;

/// A hand that presses on a plate and slides along it; its burr is off.
class FrugalScene {
 public:
  explicit FrugalScene(const Catalogue& catalogue, std::shared_ptr<const volume::SurgicalPlan> plan = nullptr,
                       SessionWriter* recorder = nullptr) {
    EXPECT_FALSE(method_->prepare(*scene_));
    HandStart hand{haptics::ServoHand(scene_, method_, haptics::TouchState(nullptr)), drilling::burr(k_burr)};
    run_ = std::make_unique<Lockstep>(Engine({std::move(hand)}, 1e-3, catalogue, {}, std::move(plan)),
                                      haptics::ForceOptions{}, 1000, recorder);
  }
  Lockstep& run() { return *run_; }
  /// Moves the free hand.
  void hover() {
    for (int i = 0; i < 30; ++i) step(0, 8);
  }
  /// Number of instructions per tick of a slide in contact; 0 if processes may not be traced.
  long cost() {
    for (int i = 0; i <= 250; ++i) step(0, 8 - 0.03 * i);
    const auto slide = [this] {
      for (int i = 0; i < k_ticks; ++i) step(0.05 * std::abs(i - k_ticks / 2), 0.5);
    };
    for (int i = 0; i < 10; ++i) slide();
    EXPECT_TRUE(run_->last_record().has_contact);
    return bench::count_instructions(slide).value_or(0) / k_ticks;
  }

 private:
  std::shared_ptr<const haptics::TouchScene> scene_ =
      std::make_shared<const haptics::TouchScene>(small_bone());
  std::shared_ptr<haptics::SubvoxelProxy> method_ = std::make_shared<haptics::SubvoxelProxy>();
  void step(double x, double z) { run_->step({{x, 0, z}, {1, 0, 0, 0}, 0}); }

  std::unique_ptr<Lockstep> run_;
};

std::shared_ptr<const volume::SurgicalPlan> large_plan() {
  auto plan = std::make_shared<volume::SurgicalPlan>();
  for (int i = 0; i < 40; ++i) {
    volume::PlannedTrajectory trajectory;
    trajectory.name = "trajectory " + std::to_string(i);
    trajectory.entry_world = {i, 0, 5}, trajectory.target_world = {i, 0, -40};
    plan->trajectories.push_back(trajectory);
  }
  return plan;
}

TEST(Frugal, AFeatureThatASceneDoesNotHoldCostsNoInstruction) {
  FrugalScene alone(drilling_catalogue());
  const long base = alone.cost();
  if (base == 0) GTEST_SKIP() << "processes may not be traced here";
  ASSERT_GT(base, 1000);
  const auto differs = [&](const char* name, long cost) {
    std::printf("%-40s %6ld instructions per tick, %+ld\n", name, cost, cost - base);
    return std::abs(cost - base) > base / 200;  // 0.5 %
  };
  EXPECT_FALSE(differs("drilling alone, again", FrugalScene(drilling_catalogue()).cost()));
  EXPECT_FALSE(differs("all modules in the program", FrugalScene(modules::catalogue()).cost()));
  EXPECT_FALSE(differs("a plan", FrugalScene(drilling_catalogue(), large_plan()).cost()));
  const auto apply = [](FrugalScene& scene, const Command& command) {
    const Outcome outcome = scene.run().apply_and_finish(command);
    EXPECT_EQ(outcome.refused ? outcome.refused->message() : "", "");
    scene.hover();
  };
  const std::string burr = drilling::burr(k_burr).parameters.words();
  {
    FrugalScene scene(drilling_catalogue());
    apply(scene, TakeInstrument{"burr", "diameter=2 round=yes shaft=8"});
    apply(scene, TakeInstrument{"burr", burr});
    EXPECT_FALSE(differs("a whole tool, and a point again", scene.cost()));
  }
  {
    FrugalScene scene(drilling_catalogue());
    apply(scene, SetEffect{Id{1}, "viscous damping=0.002"});
    EXPECT_TRUE(differs("planted: a viscous effect", scene.cost())) << "no difference is detected";
    apply(scene, SetEffect{Id{1}, ""});
    EXPECT_FALSE(differs("an effect that ended", scene.cost()));
  }
  {
    FrugalScene scene(modules::catalogue());
    apply(scene, TakeInstrument{"perforator", ""});
    apply(scene, TakeInstrument{"burr", burr});
    EXPECT_FALSE(differs("another instrument, and the burr again", scene.cost()));
  }
}

}  // namespace
}  // namespace trephine::sim
