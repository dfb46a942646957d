// Performer: times, tremor and overshoot of simulated persons, against closed forms.
#include "apps/workbench/performer.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <numbers>

namespace trephine::workbench {
namespace {

using haptics::PosePath;

/// A hand that waits, moves 20 mm along x within `seconds`, and waits.
PosePath slide(double seconds) {
  return PosePath::from_samples({{0, {}}, {1, {}}, {1 + seconds, {{20, 0, 0}}}, {9, {{20, 0, 0}}}}, "")
      .value();
}

TEST(Performer, WithoutErrorsFollowsThePlan) {
  const Performer exact(Skill{"exact"}, 1, 9);
  const PosePath planned = slide(2), performed = exact.perform(planned, 0);
  for (double t = 0; t < 9; t += 0.01) {
    EXPECT_NEAR(exact.time_of(t), t, 1e-12);
    EXPECT_NEAR(glm::distance(performed.at(t).position_world, planned.at(t).position_world), 0, 0.06) << t;
  }
  Place place{"site", {1, 2, 3}};
  exact.displace(place);
  EXPECT_EQ(place.point, glm::dvec3(1, 2, 3));
  EXPECT_EQ(place.outward, glm::dvec3(0, 0, 1));
}

TEST(Performer, TimesIncreaseAndPausesHoldTheHand) {
  const Skill* novice = find_skill("novice");
  ASSERT_NE(novice, nullptr);
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    const Performer performer(*novice, seed, 30);
    double last = -1, expected = 0;
    for (double t = 0; t <= 30; t += 0.01) {
      EXPECT_GT(performer.time_of(t), last);
      last = performer.time_of(t);
      expected = novice->slowness * t;
      EXPECT_GE(last, expected - 1e-9);
    }
    // In each of 30 seconds a pause of 0.8 s on average has a probability of 0.15. The tolerance is four
    // standard deviations of the total duration.
    EXPECT_NEAR(last - expected, 30 * 0.15 * 0.8, 4 * std::sqrt(30 * 0.15) * 0.9);
  }
  // A motion with a slowness of 2, without pauses, is at time 2 t where the plan is at time t.
  Skill slow{"slow"};
  slow.slowness = 2;
  const PosePath planned = slide(2), performed = Performer(slow, 1, 9).perform(planned, 0);
  for (double t = 0; t < 9; t += 0.1)
    EXPECT_NEAR(performed.at(2 * t).position_world.x, planned.at(t).position_world.x, 0.06);
}

TEST(Performer, TremorHasTheRequestedSizeAndRate) {
  Skill shaky{"shaky"};
  shaky.tremor = 0.25;
  const PosePath still = PosePath::from_samples({{0, {}}, {40, {}}}, "").value();
  const PosePath path = Performer(shaky, 3, 40).perform(still, 0);
  double squares = 0, crossings = 0, last = 0;
  int count = 0;
  for (double t = 0; t < 40; t += 0.005, ++count) {
    const double x = path.at(t).position_world.x;
    squares += x * x;
    crossings += x * last < 0;
    last = x;
  }
  EXPECT_NEAR(std::sqrt(squares / count), 0.25, 0.01);
  EXPECT_NEAR(crossings / 2 / 40, 10, 2) << "Hz";
  // The tremor depends on seed and hand only.
  const auto x_at_1s = [&](std::uint64_t seed, std::size_t hand) {
    return Performer(shaky, seed, 40).perform(still, hand).at(1).position_world.x;
  };
  EXPECT_EQ(x_at_1s(3, 0), path.at(1).position_world.x);
  EXPECT_NE(x_at_1s(3, 1), path.at(1).position_world.x);
  EXPECT_NE(x_at_1s(4, 0), path.at(1).position_world.x);
}

/// Step response of a second-order system: overshoot e^(-pi z / sqrt(1 - z^2)) (Ogata 2010, equation 5-21).
TEST(Performer, OvershootIsThatOfTheDampingRatio) {
  for (const double damping : {0.3, 0.45, 0.7, 1.0}) {
    Skill skill{"response"};
    skill.bandwidth = 2.5, skill.damping = damping;
    const PosePath path = Performer(skill, 1, 9).perform(slide(1e-6), 0);
    double farthest = 0;
    for (double t = 0; t < 9; t += 0.005) farthest = std::max(farthest, path.at(t).position_world.x);
    const double expected =
        damping < 1 ? std::exp(-std::numbers::pi * damping / std::sqrt(1 - damping * damping)) : 0;
    EXPECT_NEAR(farthest / 20 - 1, expected, 0.015) << damping;
    EXPECT_NEAR(path.at(9).position_world.x, 20, 1e-3);
  }
}

TEST(Performer, PlacesAreDisplacedByTheErrorOfTheSkill) {
  for (const Skill& skill : skills()) {
    double squares = 0, tilts = 0;
    constexpr int k_count = 2000;
    for (int seed = 0; seed < k_count; ++seed) {
      Place place{"site", {5, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 0}};
      Performer(skill, static_cast<std::uint64_t>(seed), 1).displace(place);
      EXPECT_EQ(place.point.x, 5) << "the height over the surface is kept";
      squares += place.point.y * place.point.y;
      const double tilt = std::acos(std::min(1.0, place.outward.x));
      tilts += tilt * tilt / 2;  // two axes
      EXPECT_NEAR(glm::dot(place.along, place.outward), 0, 1e-12);
      EXPECT_NEAR(glm::dot(glm::cross(place.along, place.across), place.outward), 1, 1e-12);
    }
    EXPECT_NEAR(std::sqrt(squares / k_count), skill.place_error, 0.06 * skill.place_error) << skill.name;
    EXPECT_NEAR(std::sqrt(tilts / k_count), skill.tilt, 0.06 * skill.tilt) << skill.name;
  }
}

}  // namespace
}  // namespace trephine::workbench
