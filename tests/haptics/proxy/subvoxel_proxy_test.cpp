#include "haptics/proxy/subvoxel_proxy.h"

#include <cmath>
#include <random>

#include "tests/haptics/proxy/method_play.h"

namespace trephine::haptics {
namespace {

using glm::dvec3;

struct SubvoxelPlay : Play {
  explicit SubvoxelPlay(TouchScene s) : Play("subvoxel", std::move(s)) {}
};

TEST(SubvoxelProxy, IsWithinAFiftiethOfAVoxelOfASphereAndFollowsTheHip) {
  for (const double shear : {0.0, 20.0}) {
    SubvoxelPlay play(scenes::phantom_scene("sphere", phantom_options(256, 1.5, shear)));
    play.no_friction();
    const double voxel = 120.0 / 256;
    const PosePath path = scenes::sphere_slide(45, 1.0, 100, 3);
    double sum = 0, worst_tangential = 0, angle = 0;
    long count = 0;
    for (const auto& sample : path.samples()) {
      const ProxyStep s = play.step(sample.pose.position_world);
      if (!s.has_contact || sample.t < 0.1) continue;
      const dvec3 hip = sample.pose.position_world;
      // Blur shrinks a sphere of radius R by about sigma^2 / R. sigma^2 is the sum of the variances of the
      // phantom's blur (1.5 voxels, squared) and of the spline (0.25 voxel^2).
      const double floor = (1.5 * 1.5 + 0.25) * voxel * voxel / 45;
      const double error = glm::length(s.proxy_world) - (45 - floor);
      sum += error * error;
      ++count;
      const double sine = glm::length(glm::cross(glm::normalize(s.proxy_world - hip), glm::normalize(hip)));
      angle += sine * sine;
      worst_tangential =
          std::max(worst_tangential, glm::length(glm::cross(s.proxy_world, glm::normalize(hip))));
    }
    EXPECT_GT(count, 2800);
    EXPECT_EQ(play.judge.fall_throughs(), 0);
    EXPECT_LT(std::sqrt(sum / static_cast<double>(count)), 0.02 * voxel);
    EXPECT_LT(std::sqrt(angle / static_cast<double>(count)), 0.5 / 57.3);
    EXPECT_LT(worst_tangential, 0.02);
  }
}

/// On torus, gyroid, groove, corner, cone and steps, sharp and blurred, the proxy equals the ideal proxy of
/// an independent search, verify::sweep_ideal_proxy().
TEST(SubvoxelProxy, RestsWhereTheIdealProxyRests) {
  const struct {
    const char* name;
    dvec3 begin, end;
    double psf;
  } cases[] = {
      {"torus", {49.2, 3, 14.5}, {20, 40, 5}, 1.5},      {"gyroid", {7.5, 0, 0}, {-6, 2, 1.5}, 1.0},
      {"groove", {0, 0, -5}, {6, 4, -30}, 0.7},          {"corner", {-10, -10, -10}, {-30, -24, -26}, 0.7},
      {"corner", {-10, -12, -10}, {-22, -30, -23}, 0.0}, {"cone", {1.4, -4.5, 24.5}, {1.5, -1.5, 8}, 1.0},
      {"groove", {0, 0, -8}, {-6, 6, -30}, 0.0},         {"steps", {1, 1, 3}, {9, 2, -3}, 1.0}};
  for (const auto& c : cases) {
    SubvoxelPlay play(scenes::phantom_scene(c.name, phantom_options(96, c.psf)));
    play.no_friction();
    const auto solid = verify::smooth_solid(play.scene.base, play.scene.items[0].field.shape(), play.version);
    const volume::Frame& frame = play.scene.base->frame;
    constexpr int k_steps = 240;
    dvec3 last = c.begin;
    int compared = 0;
    double worst = 0;
    for (int i = 0; i <= k_steps; ++i) {
      const dvec3 hip = c.begin + (static_cast<double>(i) / k_steps) * (c.end - c.begin);
      const dvec3 before = play.state.proxy_volume;
      const ProxyStep s = play.step(hip);
      if (i > 0 && i % 24 == 0 && s.has_contact) {
        const dvec3 ideal = verify::sweep_ideal_proxy(
            solid, frame.axes(), before, frame.volume_from_world(last), frame.volume_from_world(hip), 4);
        const double off = glm::length(ideal - play.state.proxy_volume);
        const auto e = [&](const dvec3& p) { return glm::length(frame.world_from_volume(p) - hip); };
        // Along the bottom of a valley the distance to the HIP hardly changes: an error of 1e-6 voxel in
        // this distance corresponds to an error of 1e-3 voxel in position.
        EXPECT_LT(off, 1e-3) << c.name << " psf " << c.psf << " step " << i;
        EXPECT_LT(e(play.state.proxy_volume) - e(ideal), 1e-6 * frame.spacing().x) << c.name << " " << i;
        worst = std::max(worst, off);
        ++compared;
      }
      last = hip;
    }
    EXPECT_GT(compared, 2) << c.name;
    EXPECT_EQ(play.judge.fall_throughs(), 0) << c.name;
    RecordProperty(c.name, std::to_string(worst));
  }
}

TEST(SubvoxelProxy, HoldsInADrilledCavityAndNeverSticksThere) {
  SubvoxelPlay play(scenes::phantom_scene("plane", phantom_options(96, 1, 0, {{"angle", 0}})));
  play.no_friction();
  volume::RemovalEditor editor(play.version, {play.scene.items[0].field});
  play.step({0, 0, 5});
  for (int i = 0; i < 100; ++i) play.step({0, 0, -6});
  EXPECT_NEAR(glm::length(play.step({0, 0, -6}).proxy_world - dvec3(0, 0, -6)), 6, 0.05);
  editor.remove({{0, 0, 2}, {0, 0, -8}, 4});
  play.set_version(editor.publish());
  for (int i = 0; i < 20; ++i) play.step({0, 0, -6});
  EXPECT_FALSE(play.step({0, 0, -6}).has_contact);
  // Presses from inside on the wall and the bottom of the hole. The bottom, below z = -8, is a hemisphere
  // with a known radius.
  double worst = 0;
  for (int i = 0; i < 4000; ++i) {
    const double a = i * 0.01;
    const dvec3 hip(8 * std::cos(a), 8 * std::sin(a), -9 - 5 * std::sin(0.37 * a));
    const ProxyStep s = play.step(hip);
    if (i < 2 || hip.z > -8) continue;
    // The spline shrinks the radius of a ball of R voxels by 1 / (4 R) voxels.
    const double voxel = 120.0 / 96, radius = 4 - 0.25 * voxel * voxel / 4;
    const dvec3 middle(0, 0, -8), ideal = middle + radius * glm::normalize(hip - middle);
    worst = std::max(worst, glm::length(s.proxy_world - ideal));
  }
  // 0.2 voxel. The HIP is at least one radius beyond the wall, so that errors of the normal count double.
  EXPECT_LT(worst, 0.2 * 120 / 96);
  EXPECT_EQ(play.judge.fall_throughs(), 0);
  EXPECT_GT(play.contacts, 3000);
}

TEST(SubvoxelProxy, FrictionHoldsStillAndTrailsByTheCone) {
  SubvoxelPlay play(scenes::phantom_scene("plane", phantom_options(128, 1.5, 0, {{"angle", 10}})));
  const dvec3 n(std::sin(10 / 57.29577951308232), 0, std::cos(10 / 57.29577951308232)), x(n.z, 0, -n.x);
  play.step(0.3 * x + 5.0 * n);
  for (int i = 0; i < 20; ++i) play.step(0.3 * x - 2.0 * n);
  const dvec3 held = play.step(0.3 * x - 2.0 * n).proxy_world;
  ProxyStep s;
  for (int i = 0; i < 2000; ++i) s = play.step(0.6 * x - 2.0 * n);
  EXPECT_LT(glm::length(s.proxy_world - held), 1e-9);  // no motion within the static cone
  double at = 0.6;
  for (int i = 0; i < 300; ++i) {
    at += 0.05;
    s = play.step(at * x - 2.0 * n);
  }
  const double depth = glm::dot(s.proxy_world, n) + 2;
  EXPECT_NEAR(at - glm::dot(s.proxy_world, x), 0.15 * depth, 0.02);
  EXPECT_EQ(play.judge.fall_throughs(), 0);
}

TEST(SubvoxelProxy, TwoShapesHoldTogether) {
  // Bone at z < 0 and a label at x < 0: the proxy rests in the edge between them.
  TouchScene scene;
  volume::Volume base = volume::make_volume(glm::ivec3(40), volume::Frame(), true).value();
  base.label_names = {"", "wall"};
  for (int z = 0; z < 40; ++z)
    for (int y = 0; y < 40; ++y)
      for (int x = 0; x < 40; ++x) {
        base.voxels[base.index(x, y, z)] = static_cast<std::int16_t>(300 + 200 * (20 - z));
        base.labels[base.index(x, y, z)] = x < 20;
      }
  scene.base = std::make_shared<const volume::Volume>(std::move(base));
  volume::Shape wall;
  wall.label = 1;
  for (const volume::Shape& shape : {volume::Shape{}, wall})
    scene.items.push_back(
        {volume::Field(*scene.base, shape),
         std::make_shared<const volume::Occupancy>(volume::Occupancy::build(*scene.base, shape)),
         Material{0.5, 0, 0, 0}, Side::front});
  SubvoxelProxy method;
  ProxyState state;
  const volume::Version version(scene.base);
  for (int i = 0; i <= 200; ++i) {
    const double t = i / 200.0;
    const dvec3 hip(28 - 12 * t, 15 + 4 * t, 26 - 9 * t);
    const ProxyStep s = method.step(scene, version, state, {hip});
    if (hip.x < 19 && hip.z < 19.5) {
      ASSERT_NEAR(s.proxy_world.x, 19.5, 1e-3) << i;
      ASSERT_NEAR(s.proxy_world.z, 20, 1e-3) << i;
      ASSERT_NEAR(s.proxy_world.y, hip.y, 1e-3) << i;
    }
  }
}

/// Labels 1 and 2 as shapes; `sides_of_first`: touchable sides of the first.
TouchScene scene_of_two_labels(std::shared_ptr<const volume::Volume> base, Side sides_of_first) {
  TouchScene scene;
  scene.base = std::move(base);
  for (const int label : {1, 2}) {
    volume::Shape shape;
    shape.label = label;
    scene.items.push_back(
        {volume::Field(*scene.base, shape),
         std::make_shared<const volume::Occupancy>(volume::Occupancy::build(*scene.base, shape)),
         Material{0.5, 0, 0, 0}, label == 1 ? sides_of_first : Side::front});
  }
  return scene;
}

/// Two labels meet in a tilted corner. On the stair-steps of the labels the proxy stays behind the HIP. On
/// the softened surfaces it slides along the edge.
TEST(SubvoxelProxy, TwoBinaryShapesInACornerLetItSlideOnceSoftened) {
  volume::Volume base = volume::make_volume(glm::ivec3(40, 60, 40), volume::Frame(), true).value();
  base.label_names = {"", "floor", "wall"};
  for (int z = 0; z < 40; ++z)
    for (int y = 0; y < 60; ++y)
      for (int x = 0; x < 40; ++x)
        base.labels[base.index(x, y, z)] = static_cast<std::uint8_t>(z < 20 + 0.23 * (y - 30)   ? 1
                                                                     : x < 20 + 0.17 * (y - 30) ? 2
                                                                                                : 0);
  const auto shared = std::make_shared<const volume::Volume>(std::move(base));
  for (const bool is_soft : {false, true}) {
    TouchScene scene = scene_of_two_labels(shared, Side::front);
    if (is_soft) soften(scene);
    SubvoxelProxy method;
    ASSERT_FALSE(method.prepare(scene));
    ProxyState state;
    const volume::Version version(scene.base);
    long behind = 0, contacts = 0;
    for (int i = 0; i <= 2000; ++i) {
      const double t = i / 2000.0, y = 15 + 30 * t, in = std::min(1.0, 20 * t);
      const dvec3 edge(20 + 0.17 * (y - 30), y, 20 + 0.23 * (y - 30));
      const dvec3 hip = edge + dvec3(3, 0, 3) - in * dvec3(5, 0, 5);
      const ProxyStep s = method.step(scene, version, state, {hip});
      contacts += s.has_contact;
      // On an exact edge the proxy would stay 0.7 mm behind the HIP. Bumps as large as a voxel add to this.
      behind += std::abs(s.proxy_world.y - hip.y) > 5;
    }
    EXPECT_GT(contacts, 1800);
    if (is_soft)
      EXPECT_EQ(behind, 0);
    else
      EXPECT_GT(behind, 200);
  }
}

/// A label that is touched from inside is softened without its neighbours, so that the tool moves freely up
/// to the next label.
TEST(SubvoxelProxy, AShapeTouchedFromInsideIsSoftenedByItself) {
  volume::Volume base = volume::make_volume(glm::ivec3(30), volume::Frame(), true).value();
  base.label_names = {"", "room", "wall"};
  for (int z = 0; z < 30; ++z)
    for (int y = 0; y < 30; ++y)
      for (int x = 0; x < 30; ++x) base.labels[base.index(x, y, z)] = x < 15 ? 1 : 2;
  TouchScene scene = scene_of_two_labels(std::make_shared<const volume::Volume>(std::move(base)), Side::back);
  soften(scene);
  for (const TouchItem& shape : scene.items) {
    const auto alone = volume::SoftField::build(*shape.bits);
    for (int x = 0; x < 30; ++x) EXPECT_EQ(shape.soft->at(x, 14, 14), alone->at(x, 14, 14)) << x;
  }
  scene.items[0].sides = Side::front;
  soften(scene);
  EXPECT_GT(scene.items[1].soft->at(13, 14, 14), 0);
}

/// The tip enters a shape that is touched only from inside through a face of the volume's border. This face
/// is also a face of a voxel: rounding must not hold the tip there.
TEST(SubvoxelProxy, EntersAShapeTouchedFromInsideThroughTheBorder) {
  glm::dmat3 axes(1.875);
  axes[2][1] = 0.23;
  volume::Volume block =
      volume::make_volume(glm::ivec3(14), volume::Frame::from_axes({3, -7, 11}, axes).value()).value();
  for (auto& v : block.voxels.span()) v = 1200;
  TouchScene scene = scenes::scene_of(std::move(block));
  scene.items[0].sides = Side::back;
  SubvoxelProxy method;
  ASSERT_FALSE(method.prepare(scene));
  const volume::Version version(scene.base);
  const volume::Frame& frame = scene.base->frame;
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> within(2.5, 10.5), beyond(0.6, 4);
  long held = 0;
  for (int i = 0; i < 20000; ++i) {
    dvec3 out, in;
    for (int a = 0; a < 3; ++a) out[a] = within(random), in[a] = within(random);
    out[i % 3] = i / 3 % 2 ? 13 + beyond(random) : -beyond(random);
    ProxyState state;
    method.step(scene, version, state, {frame.world_from_volume(out)});
    const ProxyStep s = method.step(scene, version, state, {frame.world_from_volume(in)});
    held += s.has_contact || s.is_buried || glm::length(s.proxy_world - frame.world_from_volume(in)) > 1e-9;
  }
  EXPECT_EQ(held, 0);
}

}  // namespace
}  // namespace trephine::haptics
