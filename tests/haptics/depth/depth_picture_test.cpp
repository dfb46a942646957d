// Depth pictures of a screen: surfaces that the pictures show, touch while the view turns, and hidden
// surfaces.
#include "haptics/depth/depth_picture.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <gtest/gtest.h>

#include "apps/bench/scenes/scenes.h"
#include "haptics/depth/depth_rules.h"
#include "haptics/methods/methods.h"

namespace trephine::haptics::depth {
namespace {

using glm::dvec3;

// Radius of the ball, distance from its centre to the camera, size of a pixel at this distance; mm.
constexpr double k_radius = 30, k_far = 500, k_pixel = 0.4;

/// Returns a picture of a ball at the origin. The camera is turned about y by `degrees` (0: viewed from -z),
/// and its pixels are centred on `touch`.
DepthPicture picture_of_ball(double degrees, const dvec3& touch) {
  DepthPicture picture;
  const glm::dquat turn = glm::angleAxis(degrees * 3.14159265358979 / 180, dvec3(0, 1, 0));
  picture.placement = {turn * dvec3(0, 0, -k_far), turn};
  constexpr int k_side = 120;
  const double f = k_far / k_pixel;
  const dvec3 at = picture.placement.local_from_world(touch);
  picture.camera = {
      k_side, k_side, f, f, 0.5 * (k_side - 1) - f * at.x / at.z, 0.5 * (k_side - 1) - f * at.y / at.z};
  std::vector<double> depths;
  const dvec3 middle = picture.placement.local_from_world(dvec3(0));
  for (int j = 0; j < k_side; ++j)
    for (int i = 0; i < k_side; ++i) {
      const dvec3 way = picture.camera.unproject(i, j, 1);
      const double a = glm::dot(way, way), b = glm::dot(way, middle),
                   c = glm::dot(middle, middle) - k_radius * k_radius, root = b * b - a * c;
      // Depth as stored in a 24-bit depth buffer.
      const double depth = root > 0 ? (b - std::sqrt(root)) / a : 0, near = 300, far = 800;
      if (depth <= 0) {
        depths.push_back(0);
        continue;
      }
      const double buffer = std::round((far - far * near / depth) / (far - near) * 0x1p24) * 0x1p-24;
      depths.push_back(perspective_distance(near, far, buffer));
    }
  picture.set_depths(depths);
  return picture;
}

/// A hand that touches the pictures that it adopts.
struct ScreenHand {
  TouchScene scene = scenes::phantom_scene("sphere", [] {
    data_tools::PhantomOptions o;
    o.size = glm::ivec3(16);
    o.spacing_mm = dvec3(0.5);
    return o;
  }());
  std::unique_ptr<ProxyMethod> method = make_method("scene").value();
  std::shared_ptr<const volume::Version> version;
  TouchState touch_state{nullptr};
  ProxyState state;
  int tick = 0;
  int hidden = 0;  ///< pictures that were not adopted
  dvec3 proxy{0.0};

  explicit ScreenHand(double radius) {
    scene.items.clear();
    scene.items.push_back(
        depth_item("background", std::make_shared<IncomingDepths>(), std::make_shared<const MeshTree>()));
    scene.tool = std::make_shared<const ToolShape>(radius);
    version = uncut_version(scene);
    touch_state = TouchState(version);
    touch_state.depths.resize(1);
    EXPECT_FALSE(method->prepare(scene));
  }
  /// Adopts a picture as a window does, unless the picture does not show the position of the proxy, or the
  /// proxy is hidden: more than 1 mm and two pixels behind the surface in the picture.
  void adopt_picture(double degrees) {
    const DepthPicture picture = picture_of_ball(degrees, proxy);
    const auto behind = picture.behind(proxy);
    if (!behind || *behind > 1 + 2 * k_pixel) {
      ++hidden;
      return;
    }
    DepthView view;
    view.middle = view.touch = proxy;
    view.edge = std::min(24.0, picture.known_cube_edge(proxy));
    view.pixel = k_pixel;
    view.time = 0.001 * tick;
    auto set = std::make_shared<DepthSet>(set_of(view, picture));
    set->follow(touch_state.depths[0].get());
    touch_state.depths[0] = set;
  }
  ProxyStep step(const dvec3& hip) {
    ProxyInput input{hip};
    input.time = 0.001 * tick++;
    const ProxyStep result = method->step(scene, touch_state, state, input);
    proxy = result.proxy_world;
    return result;
  }
};

TEST(DepthPicture, TheTouchedSurfaceStaysWhileTheViewTurns) {
  for (const double radius : {0.0, 1.5}) {
    ScreenHand hand(radius);
    const dvec3 out = glm::normalize(dvec3(0.1, 0.2, -1));
    hand.proxy = (k_radius + radius + 3) * out;
    hand.adopt_picture(0);
    for (int i = 0; i < 100; ++i) hand.step((k_radius + radius + 3 - 0.05 * i) * out);
    const dvec3 first = hand.proxy;
    EXPECT_NEAR(glm::length(first), k_radius + radius, 0.02) << radius;
    dvec3 last = first;
    double worst = 0, leap = 0;
    // The view turns by 60 degrees in a second, with a picture every 16 ms.
    for (int i = 0; i < 1000; ++i) {
      if (i % 16 == 0) hand.adopt_picture(0.06 * i);
      const ProxyStep step = hand.step((k_radius + radius - 2) * out);
      ASSERT_TRUE(step.has_contact) << i;
      worst = std::max(worst, std::abs(glm::length(hand.proxy) - k_radius - radius));
      leap = std::max(leap, glm::length(hand.proxy - last));
      last = hand.proxy;
    }
    EXPECT_LT(worst, 0.1) << radius;  // mm; on a slope of 60 degrees, a pixel covers 0.8 mm of the surface
    EXPECT_LT(leap, 0.5) << radius;
    EXPECT_LT(glm::length(last - first), 0.5) << radius;
    EXPECT_EQ(hand.hidden, 0);
    // Viewed from behind, the touched side is hidden: the last set that shows this side stays in use.
    const auto before = hand.touch_state.depths[0];
    for (int i = 0; i < 100; ++i) {
      if (i % 16 == 0) hand.adopt_picture(120 + 0.5 * i);
      ASSERT_TRUE(hand.step((k_radius + radius - 2) * out).has_contact) << i;
    }
    EXPECT_EQ(hand.hidden, 7);
    EXPECT_EQ(hand.touch_state.depths[0], before);
    EXPECT_LT(glm::length(hand.proxy - last), 0.05);
  }
}

/// A hand moves in and out of the ball at up to 0.3 m/s. The proxy is never more than 0.05 mm inside the
/// ball.
TEST(DepthPicture, NoSurfaceIsPassedThrough) {
  ScreenHand hand(0);
  hand.proxy = {0, 0, -k_radius - 4};
  hand.adopt_picture(0);
  double deepest = 0;
  long in_contact = 0;
  for (int i = 0; i < 4000; ++i) {
    const double a = 0.011 * i, b = 0.037 * i;
    const dvec3 hip(6 * std::sin(a), 5 * std::sin(b), -k_radius + 4 * std::sin(0.05 * i));
    if (i % 50 == 0) hand.adopt_picture(5 * std::sin(0.001 * i));
    in_contact += hand.step(hip).has_contact;
    deepest = std::max(deepest, k_radius - glm::length(hand.proxy));
  }
  EXPECT_GT(in_contact, 1000);
  EXPECT_LT(deepest, 0.05);
}

TEST(DepthPicture, KeepsDepthsAndRefusesInvalidPictures) {
  DepthPicture picture = picture_of_ball(0, {0, 0, -k_radius});
  EXPECT_FALSE(check(picture));
  EXPECT_LT(picture.mm_per_step, 0.001);
  // Depth at the centre of the picture, after rounding to the 24 bits of the depth buffer and to the 16 bits
  // of the picture.
  EXPECT_NEAR(picture.depth(59, 59), k_far - k_radius, 0.003);
  EXPECT_NEAR(*picture.behind({0, 0, -k_radius + 2}), 2, 0.01);
  EXPECT_FALSE(picture.behind({0, 0, -k_far - 10}));
  EXPECT_FALSE(picture.behind({300, 0, 0}));
  EXPECT_GT(picture.known_cube_edge({0, 0, -k_radius}), 20);
  EXPECT_EQ(picture.known_cube_edge({0, 0, -k_far - 10}), 0);
  EXPECT_EQ(picture.known_cube_edge({40, 0, -k_radius}), 0);
  // A picture without measurements is valid, and shows no surface.
  DepthPicture dark = picture;
  dark.set_depths(std::vector<double>(120 * 120, 0));
  EXPECT_FALSE(check(dark));
  EXPECT_FALSE(dark.behind({0, 0, -k_radius}));
  EXPECT_EQ(set_of(DepthView(), dark).crossings, 0u);
  const auto refused = [&](auto&& change) {
    DepthPicture other = picture;
    change(other);
    return check(other).has_value();
  };
  EXPECT_TRUE(refused([](DepthPicture& p) { p.values.pop_back(); }));
  EXPECT_TRUE(refused([](DepthPicture& p) { p.camera.fx = 0; }));
  EXPECT_TRUE(refused([](DepthPicture& p) { p.camera.width = 1; }));
  EXPECT_TRUE(refused([](DepthPicture& p) { p.mm_per_step = std::nan(""); }));
  EXPECT_TRUE(refused([](DepthPicture& p) { p.nearest = 0; }));
  EXPECT_FALSE(IncomingDepths().draw({}).is_ok());
}

}  // namespace
}  // namespace trephine::haptics::depth
