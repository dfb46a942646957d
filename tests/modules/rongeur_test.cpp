// Rongeur and Kerrison on a lamina: a plate of bone with a canal below it and an edge to bite.
#include "modules/rongeur/rongeur.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <numbers>

#include "apps/bench/scenes/scenes.h"
#include "haptics/methods/methods.h"
#include "sim/drivers/lockstep.h"

namespace trephine::rongeur {
namespace {

using glm::dvec3;
constexpr double k_thick = 4;  // mm

/// Bone where 0 < z < k_thick and x < 0.
struct Lamina {
  haptics::TouchScene scene;
  std::unique_ptr<haptics::ProxyMethod> method;
  RongeurModule module;
  sim::Catalogue catalogue;

  explicit Lamina(const dvec3& spacing) : catalogue(std::vector<const sim::Module*>{&module}) {
    // Intensity rises from 0 to 600 HU at a blurred edge. The middle of the edge is at 300 HU.
    const auto hounsfield = [&](const dvec3& p) {
      const auto share = [](double in, double width) { return std::clamp(0.5 + in / width, 0.0, 1.0); };
      return 600 * std::min({share(p.z, 2 * spacing.z), share(k_thick - p.z, 2 * spacing.z),
                             share(-p.x, 2 * spacing.x)});
    };
    scene = scenes::scene_of(scenes::sampled({-16, -10, -8}, {10, 10, 16}, spacing, hounsfield));
    EXPECT_FALSE(haptics::set_smallest_burr(scene, 3).has_value());
    method = haptics::make_method(haptics::k_default_method).value();
    EXPECT_FALSE(method->prepare(scene).has_value());
  }
  sim::Lockstep with(const Rongeur& tool) const {
    return {sim::Engine(scene, *method, rongeur(tool), 1e-3, catalogue), {}, 1000};
  }
};

template <class Event>
std::vector<Event> events(const sim::Lockstep& run) {
  std::vector<Event> all;
  const sim::Chronicle& chronicle = run.engine().state().chronicle;
  for (std::size_t i = 0; i < chronicle.size(); ++i)
    if (const auto* one = chronicle[i].value.as<Event>()) all.push_back(*one);
  return all;
}

/// Holds the rongeur for `ticks` ticks; `squeeze` below 0: the button is pressed.
void hold(sim::Lockstep& run, const dvec3& at, double squeeze, int ticks = 500,
          const glm::dquat& turn = {1, 0, 0, 0}) {
  haptics::Pose pose{at, turn, squeeze < 0 ? 1u : 0u};
  pose.axes[0] = static_cast<float>(std::max(0.0, squeeze));
  for (int i = 0; i < ticks; ++i) run.step(pose);
}

TEST(Rongeur, AKerrisonBitesTheBoneInItsJaws) {
  for (const dvec3& spacing : {dvec3(0.4), dvec3(0.6), dvec3(0.5, 0.5, 1.25)}) {
    const Lamina lamina(spacing);
    const Rongeur tool{.kind = Kind::kerrison, .width = 4, .opening = 6};
    sim::Lockstep run = lamina.with(tool);
    // The foot is just under the edge, and half of the jaws is over bone: the bite is half a cylinder through
    // the lamina.
    hold(run, {0, 0, -0.6}, 0, 10);
    hold(run, {0, 0, -0.6}, -1);
    const auto bites = events<Bite>(run);
    ASSERT_EQ(bites.size(), 1u) << spacing.z;
    const double exact = 0.5 * std::numbers::pi * 4 * k_thick;
    EXPECT_NEAR(bites[0].size / exact, 1, spacing.z > 1 ? 0.05 : 0.03) << spacing.z;
    EXPECT_NEAR(run.engine().removed_mm3(), bites[0].size, 1e-9);
    // Closed jaws do not bite again. Jaws that open and close again bite bone between them.
    hold(run, {0, 0, -0.6}, -1);
    hold(run, {-1, 0, -0.6}, 0, 10);
    EXPECT_EQ(events<Bite>(run).size(), 1u);
    hold(run, {-1, 0, -0.6}, -1);
    EXPECT_EQ(events<Bite>(run).size(), 2u);
    // Undo restores the bone of the last stroke, which was one bite.
    hold(run, {-1, 0, -0.6}, 0, 10);
    run.undo();
    EXPECT_NEAR(run.engine().removed_mm3(), bites[0].size, 1e-9);
  }
}

/// A bite that would remove more than `max_bite` is refused. The reason states this limit.
TEST(Rongeur, ABiteHasALargestSize) {
  const double exact = 0.5 * std::numbers::pi * 4 * k_thick;
  for (const double share : {0.8, 1.2}) {
    const Lamina lamina(dvec3(0.4));
    sim::Lockstep run =
        lamina.with({.kind = Kind::kerrison, .width = 4, .opening = 6, .max_bite = share * exact});
    hold(run, {0, 0, -0.6}, 0, 10);
    hold(run, {0, 0, -0.6}, -1);
    EXPECT_EQ(events<Bite>(run).size(), share > 1 ? 1u : 0u) << share;
    const auto refused = events<BiteRefused>(run);
    ASSERT_EQ(refused.size(), share > 1 ? 0u : 1u);
    if (refused.empty()) continue;
    EXPECT_NE(refused[0].reason.find("more than the " + std::to_string(std::lround(share * exact))),
              std::string::npos)
        << refused[0].reason;
    EXPECT_EQ(run.engine().removed_mm3(), 0);
  }
}

TEST(Rongeur, ASqueezeClosesTheJaws) {
  const Lamina lamina(dvec3(0.5));
  sim::Lockstep run = lamina.with({.kind = Kind::kerrison});
  const dvec3 at(0, 0, -0.6);
  // A tool that is grasped with closed jaws must open before it can bite. After an invalid position the state
  // of the hand is unknown, so that the jaws must open again.
  hold(run, at, 1);
  hold(run, at * std::nan(""), 0, 3);
  hold(run, at, 1);
  EXPECT_TRUE(events<Bite>(run).empty());
  run.reset();
  hold(run, at, 0, 10);
  hold(run, at, 0.5);
  hold(run, at, 0.9);
  EXPECT_TRUE(events<Bite>(run).empty());
  hold(run, at, 1);
  EXPECT_EQ(events<Bite>(run).size(), 1u);
  // Jaws that are half open do not count as open.
  hold(run, at + dvec3(-1, 0, 0), 0.5);
  hold(run, at + dvec3(-1, 0, 0), 1);
  EXPECT_EQ(events<Bite>(run).size(), 1u);
  hold(run, at + dvec3(-1, 0, 0), 0.1);
  hold(run, at + dvec3(-1, 0, 0), 1);
  EXPECT_EQ(events<Bite>(run).size(), 2u);
}

TEST(Rongeur, BlockedJawsBiteNothing) {
  const Lamina lamina(dvec3(0.5));
  const struct {
    Rongeur tool;
    dvec3 at;
    const char* why;
  } cases[] = {{{.kind = Kind::kerrison, .opening = 3}, {-1, 0, -0.6}, "thicker"},
               {{.kind = Kind::kerrison}, {-1, 0, 5}, "foot"},
               {{.kind = Kind::rongeur, .opening = 3}, {-4, 0, 3}, "wider"}};
  for (const auto& c : cases) {
    sim::Lockstep run = lamina.with(c.tool);
    hold(run, c.at, 0, 10);
    hold(run, c.at, -1);
    const auto refused = events<BiteRefused>(run);
    ASSERT_EQ(refused.size(), 1u) << c.why;
    EXPECT_NE(refused[0].reason.find(c.why), std::string::npos) << refused[0].reason;
    EXPECT_EQ(run.engine().removed_mm3(), 0);
    EXPECT_EQ(run.engine().measures().back().value, 1);
  }
}

TEST(Rongeur, TwoCupsBiteAnEdgeBetweenThem) {
  const Lamina lamina(dvec3(0.5));
  // The rongeur comes from the side, with its shaft along +x. One cup is above the edge and one below it; the
  // edge is thinner than the opening of the cups.
  const Rongeur tool{.width = 4, .opening = 6};
  sim::Lockstep run = lamina.with(tool);
  const double half = std::sqrt(0.5);
  const glm::dquat turn(half, 0, half, 0);  // turns the shaft to x, and the tool's x axis to -z
  hold(run, {3, 0, 2}, 0, 10, turn);
  hold(run, {-2, 0, 2}, -1, 500, turn);
  const auto bites = events<Bite>(run);
  ASSERT_EQ(bites.size(), 1u);
  // The throat stops at the edge; all bone between the cups is removed.
  EXPECT_NEAR(bites[0].size / (std::numbers::pi * 4 * k_thick), 1, 0.05);
}

TEST(Rongeur, InvalidToolsAreRefused) {
  const Lamina lamina(dvec3(0.5));
  sim::Lockstep run = lamina.with({});
  EXPECT_TRUE(run.apply(Rongeur{.width = 2}).refused);  // the scene allows burrs of at least 3 mm
  EXPECT_TRUE(run.apply(Rongeur{.opening = std::nan("")}).refused);
  EXPECT_FALSE(run.apply(Rongeur{.width = 3}).refused);
}

}  // namespace
}  // namespace trephine::rongeur
