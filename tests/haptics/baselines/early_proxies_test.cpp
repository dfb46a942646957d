#include "haptics/baselines/early_proxies.h"

#include <cmath>

#include "tests/haptics/proxy/method_play.h"

namespace trephine::haptics::baselines {
namespace {

using glm::dvec3;

/// Returns a scene with a cube of 20 voxels per edge. Its two halves along x differ in intensity and are two
/// shapes.
TouchScene two_shapes() {
  TouchScene scene;
  volume::Volume base = volume::make_volume(glm::ivec3(40), volume::Frame()).value();
  for (int z = 0; z < 40; ++z)
    for (int y = 0; y < 40; ++y)
      for (int x = 0; x < 40; ++x) {
        const bool is_in = std::min({x, y, z}) >= 10 && std::max({x, y, z}) < 30;
        base.voxels[base.index(x, y, z)] = static_cast<std::int16_t>(!is_in ? -1000 : x < 20 ? 100 : 900);
      }
  scene.base = std::make_shared<const volume::Volume>(std::move(base));
  for (const auto& [low, high] : {std::pair(0.0, 300.0), std::pair(301.0, 2000.0)}) {
    volume::Shape shape;
    shape.low = low, shape.high = high;
    scene.items.push_back(
        {volume::Field(*scene.base, shape),
         std::make_shared<const volume::Occupancy>(volume::Occupancy::build(*scene.base, shape)), Material{},
         Side::both});
  }
  return scene;
}

TEST(RaystepProxy, ReportsShapeSideAndNormalInOnePass) {
  const TouchScene scene = two_shapes();
  const volume::Version version(scene.base);
  RaystepProxy method;
  for (const int wanted : {0, 1}) {
    ProxyState state;
    const double x = wanted == 0 ? 14 : 25;
    method.step(scene, version, state, {{x, 20, 35}});
    const ProxyStep s = method.step(scene, version, state, {{x, 20, 28}});
    EXPECT_TRUE(s.has_contact);
    EXPECT_EQ(s.shape, wanted);
    EXPECT_EQ(s.side, Side::front);
    EXPECT_NEAR(s.normal_world.z, 1, 1e-12);
    // The proxy is half a voxel above the centre of the last voxel.
    EXPECT_NEAR(s.proxy_world.z, 29.5, 1.001 * RaystepProxy::k_step);
    // A constant number of samples per millimetre, at any speed.
    EXPECT_NEAR(s.counters.voxels, 5.5 / RaystepProxy::k_step, 2);
  }
}

TEST(RaystepProxy, FlipsTheNormalOnTheBackAndRestsAtOnceWithoutMotion) {
  const TouchScene scene = two_shapes();
  const volume::Version version(scene.base);
  RaystepProxy method;
  ProxyState state;
  method.step(scene, version, state, {{5, 20, 20}});
  // Without motion and contact it returns before it reads a voxel.
  EXPECT_EQ(method.step(scene, version, state, {{5, 20, 20}}).counters.voxels, 0);
  // With a window of intensities between air and bone, the blurred edge of the ball is a shell. A hand inside
  // the ball touches the back of this shell.
  TouchScene shell = scenes::phantom_scene("sphere", phantom_options(96, 1.5));
  volume::Shape shape;
  shape.low = 0, shape.high = 600;
  shell.items[0] = {volume::Field(*shell.base, shape),
                    std::make_shared<const volume::Occupancy>(volume::Occupancy::build(*shell.base, shape)),
                    Material{}, Side::both};
  const volume::Version uncut(shell.base);
  state = {};
  method.step(shell, uncut, state, {{30, 0, 0}});
  const ProxyStep s = method.step(shell, uncut, state, {{47, 0, 0}});
  EXPECT_TRUE(s.has_contact);
  EXPECT_EQ(s.side, Side::back);
  EXPECT_LT(s.normal_world.x, -0.99);
}

TEST(PlaneProxy, ConvergesToAPlaneOverTicks) {
  TouchScene scene = scenes::phantom_scene("plane", phantom_options(96, 1.5, 0, {{"angle", 0}}));
  const volume::Version version(scene.base);
  PlaneProxy method;
  ProxyState state;
  ProxyStep s;
  for (int i = 0; i < 40; ++i) s = method.step(scene, version, state, {{0, 0, 1 - 0.05 * i}});
  EXPECT_TRUE(s.has_contact);
  EXPECT_NEAR(s.proxy_world.z, 0, 0.1);
  EXPECT_LT(glm::length(s.normal_world - dvec3(0, 0, 1)), 0.05);
}

TEST(GradientProxy, PushesAlongTheGradientAndPopsThroughThinMatter) {
  const TouchScene scene =
      scenes::phantom_scene("plate", phantom_options(128, 1, 0, {{"thickness", 2}, {"angle", 0}}));
  const volume::Version version(scene.base);
  GradientProxy method;
  ProxyState state;
  method.step(scene, version, state, {{0, 0, 5}});
  const ProxyStep above = method.step(scene, version, state, {{0, 0, 0.5}});
  EXPECT_TRUE(above.has_contact);
  EXPECT_GT(above.normal_world.z, 0.99);
  const ProxyStep below = method.step(scene, version, state, {{0, 0, -0.5}});
  EXPECT_LT(below.normal_world.z, -0.99);  // its known fault: past the middle it pushes onward
}

}  // namespace
}  // namespace trephine::haptics::baselines
