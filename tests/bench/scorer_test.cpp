// Scorer: each planted fault of a proxy increases the columns of the chart that measure it.
#include "apps/bench/scorer.h"

#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include "haptics/methods/methods.h"

namespace trephine::bench {
namespace {

using glm::dvec3;
using haptics::ProxyStep;

FeelScene scene_named(const std::string& id) {
  std::optional<FeelScene> found;
  for_feel_scenes(true, id, [&](FeelScene&& s) {
    if (feel_id(s) != id) return true;
    found = std::move(s);
    return false;
  });
  return std::move(found).value();
}

/// Steps of the default method in a scene, and their score after `spoil` has changed each step.
class Scored {
 public:
  explicit Scored(const std::string& id) : scene_(scene_named(id)), ideal_(scene_) {
    const auto method = haptics::make_method(haptics::k_default_method).value();
    EXPECT_FALSE(method->prepare(scene_.scene));
    const haptics::TouchState touch_state = scene_.touch_state();
    haptics::ProxyState state;
    for (const auto& sample : scene_.path.samples())
      steps_.push_back(method->step(scene_.scene, touch_state, state, {sample.pose.position_world}));
  }
  using Spoil = std::function<void(std::size_t, ProxyStep&)>;
  FeelRow score(const Spoil& spoil = [](std::size_t, ProxyStep&) {}) const {
    Scorer scorer(scene_, ideal_, &ideal_.on_smooth_solid());
    for (std::size_t i = 0; i < steps_.size(); ++i) {
      ProxyStep step = steps_[i];
      spoil(i, step);
      scorer.judge_step(i, step);
    }
    FeelRow row;
    scorer.finish(row);
    return row;
  }
  const std::vector<ProxyStep>& steps() const { return steps_; }
  const std::vector<dvec3>& exact() const { return ideal_.on_shape().proxies; }
  double voxel() const { return ideal_.voxel(); }

 private:
  FeelScene scene_;
  IdealProxies ideal_;
  std::vector<ProxyStep> steps_;
};

TEST(Scorer, DetectsAProxyThatSticksInAGrooveAndAtRest) {
  const Scored scored("groove-90-psf-1-circle-held");
  EXPECT_EQ(scored.score().stuck, 0);
  EXPECT_EQ(scored.score().other_rest, 0);
  // In every 300 steps the proxy stays in place for 40 steps. The hand is at rest during most of these.
  const FeelRow stuck = scored.score([&](std::size_t i, ProxyStep& step) {
    if (i % 300 >= 240 && i % 300 < 280) step.proxy_world = scored.steps()[i / 300 * 300 + 239].proxy_world;
  });
  EXPECT_GE(stuck.stuck, 3);
  EXPECT_GT(stuck.method_error_voxels.value(), 1);
}

TEST(Scorer, DetectsAStuckBallInABurrHole) {
  const Scored scored("burr-hole-psf-1.5-radius-2-mm-round-its-wall");
  // The exact proxy is in the hole, and touches its wall in many steps.
  long on_wall = 0;
  for (std::size_t i = 200; i < scored.exact().size(); ++i) {
    const dvec3& p = scored.exact()[i];
    EXPECT_LT(p.z, 0);
    EXPECT_LT(std::hypot(p.x, p.y), 2.001);
    on_wall += std::hypot(p.x, p.y) > 1.99;
  }
  EXPECT_GT(on_wall, 300);
  EXPECT_EQ(scored.score().stuck, 0);
  const FeelRow stuck = scored.score([&](std::size_t i, ProxyStep& step) {
    if (i > 400 && i < 480 && step.has_contact) step.proxy_world = scored.steps()[400].proxy_world;
  });
  EXPECT_GE(stuck.stuck, 1);
}

TEST(Scorer, CountsMissedContact) {
  const Scored scored("sphere-psf-1.5-slide-100-mm-s");
  const FeelRow right = scored.score();
  EXPECT_EQ(right.missed, 0);
  const FeelRow row = scored.score([](std::size_t i, ProxyStep& step) {
    if (i >= 500 && i < 520) step = ProxyStep{};
  });
  EXPECT_EQ(row.missed, 20);
  EXPECT_GT(row.force_rms_n.value(), 1.5 * right.force_rms_n.value());
}

/// A proxy that stays on the surface after the hand has left it.
TEST(Scorer, CountsGhostContact) {
  const Scored scored("sphere-psf-1.5-poke");
  EXPECT_EQ(scored.score().ghosts, 0);
  std::size_t last_contact = 0;
  const FeelRow row = scored.score([&](std::size_t i, ProxyStep& step) {
    if (step.has_contact)
      last_contact = i;
    else if (last_contact > 0)
      step = scored.steps()[last_contact];
  });
  EXPECT_GT(row.ghosts, 100);
  EXPECT_GT(row.force_rms_n.value(), 0.3);
  EXPECT_GT(row.stuck, 0);
}

/// A proxy that passes a plate between two steps is detected on its path.
TEST(Scorer, DetectsAPlateThatIsPassed) {
  const Scored scored("plate-2.0-voxels-cross-at-2-m-s");
  EXPECT_EQ(scored.score().fall_throughs, 0);
  const FeelRow row = scored.score([](std::size_t, ProxyStep& step) { step = ProxyStep{}; });
  EXPECT_GE(row.fall_throughs, 3);
  EXPECT_GE(row.other_rest, 1);  // the proxy is free behind the plate and counts as at rest elsewhere
  EXPECT_GE(row.missed, 20);
}

TEST(Scorer, DetectsOneJumpAmongAllSteps) {
  const Scored scored("sphere-psf-1.5-slide-100-mm-s");
  const FeelRow right = scored.score();
  EXPECT_LT(right.method_error_voxels.value(), 1e-4);
  EXPECT_LT(right.max_change_n, 0.05);
  // One of 1500 steps, which may be the last, is displaced by 3 mm along the surface.
  for (const std::size_t leap : {777u, 1499u}) {
    const FeelRow row = scored.score([leap](std::size_t i, ProxyStep& step) {
      if (i != leap) return;
      const dvec3 aside = 3.0 * glm::normalize(glm::cross(step.normal_world, dvec3(1, 2, 3)));
      step.proxy_world = glm::length(step.proxy_world) * glm::normalize(step.proxy_world + aside);
    });
    EXPECT_NEAR(row.method_error_voxels.value() * scored.voxel(), 3, 0.1);
    EXPECT_NEAR(row.max_deviation_mm.value(), 3, 0.1);
    EXPECT_GT(row.max_change_n, 1);
  }
}

/// A proxy that trembles by 0.3 mm along the surface, a proxy that trembles by 0.3 mm across it, and a proxy
/// that is half a voxel too deep in each step.
TEST(Scorer, MeasuresTremblingAndDepth) {
  const Scored scored("sphere-psf-1.5-slide-100-mm-s");
  const FeelRow right = scored.score();
  const FeelRow trembling = scored.score([](std::size_t i, ProxyStep& step) {
    if (!step.has_contact) return;
    const dvec3 aside = (i % 2 ? 0.3 : -0.3) * glm::normalize(glm::cross(step.normal_world, dvec3(1, 2, 3)));
    step.proxy_world = glm::length(step.proxy_world) * glm::normalize(step.proxy_world + aside);
  });
  EXPECT_NEAR(trembling.tangential_p50_mm.value(), 0.3, 0.05);
  EXPECT_NEAR(trembling.tangential_p99_mm.value(), 0.3, 0.05);
  EXPECT_GT(trembling.direction_rms_deg.value(), right.direction_rms_deg.value() + 3);
  EXPECT_GT(trembling.rendered_rms_n.value(), right.rendered_rms_n.value() + 0.005);
  EXPECT_GT(trembling.rough_n, 2 * right.rough_n);
  EXPECT_GT(trembling.max_change_n, right.max_change_n + 0.1);
  // The proxy is alternately 0.3 mm too high and too deep. The magnitude of the force alternates, also after
  // smoothing and when the proxy enters another voxel.
  const FeelRow rough = scored.score([](std::size_t i, ProxyStep& step) {
    if (step.has_contact) step.proxy_world += (i % 2 ? 0.3 : -0.3) * glm::normalize(step.proxy_world);
  });
  EXPECT_GT(rough.rough_n, right.rough_n + 0.1);
  EXPECT_GT(rough.rough_smoothed_n, right.rough_smoothed_n + 0.02);
  EXPECT_GT(rough.jump_n, right.jump_n + 0.1);
  const double voxel = scored.voxel();
  const FeelRow deep = scored.score([voxel](std::size_t, ProxyStep& step) {
    if (step.has_contact) step.proxy_world -= 0.5 * voxel * glm::normalize(step.proxy_world);
  });
  EXPECT_NEAR(deep.deepest_voxels.value(), right.deepest_voxels.value() + 0.5, 0.02);
  EXPECT_NEAR(deep.total_rms_voxels.value(), right.total_rms_voxels.value() + 0.5, 0.03);
}

TEST(Scorer, ScoresExactAnswersAsExactAndHalfAMillimetreAsHalf) {
  const FeelScene scene = scene_named("sphere-psf-1.5-slide-100-mm-s");
  const IdealProxies ideal(scene);
  for (const double off : {0.0, 0.5}) {
    Scorer scorer(scene, ideal);
    for (std::size_t i = 0; i < ideal.on_shape().proxies.size(); ++i) {
      const dvec3& exact = ideal.on_shape().proxies[i];
      scorer.judge_step(i, step_from_proxy(exact + off * glm::normalize(exact),
                                           scene.path.samples()[i].pose.position_world));
    }
    FeelRow row;
    scorer.finish(row);
    EXPECT_NEAR(row.total_rms_voxels.value() * ideal.voxel(), off, 1e-6);
    EXPECT_NEAR(row.max_deviation_mm.value(), off, 1e-6);
    EXPECT_NEAR(row.tangential_p99_mm.value(), 0, 1e-6);
    EXPECT_EQ(row.fall_throughs + row.stuck + row.missed, 0);
  }
}

TEST(Scorer, CountsAProxyInMatterAsAFall) {
  const auto sunk = [](double mm) {
    return [mm](std::size_t i, ProxyStep& step) {
      if (i == 800) step.proxy_world -= mm * glm::normalize(step.proxy_world);
    };
  };
  const Scored point("sphere-psf-1.5-slide-100-mm-s");
  EXPECT_EQ(point.score(sunk(0.5 * point.voxel())).fall_throughs, 0);
  EXPECT_EQ(point.score(sunk(1.2 * point.voxel())).fall_throughs, 1);
  // The tolerance for a ball is a tenth of a voxel plus 2 % of the radius.
  const Scored ball("sphere-psf-1.5-radius-2-mm-slide-100-mm-s");
  EXPECT_EQ(ball.score().fall_throughs, 0);
  EXPECT_EQ(ball.score(sunk(0.25 * ball.voxel())).fall_throughs, 1);
}

}  // namespace
}  // namespace trephine::bench
