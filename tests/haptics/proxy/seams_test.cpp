// A ball divided among labels, windows, models and volumes is as closed as a ball of one shape.
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <gtest/gtest.h>

#include "apps/bench/scenes/scenes.h"
#include "haptics/mesh/mesh_tree.h"
#include "haptics/methods/methods.h"
#include "volume/cuts/removal.h"
#include "volume/surface/surface_nets.h"

namespace trephine::haptics {
namespace {

using glm::dvec3;
using glm::ivec3;

constexpr double k_radius = 16;  // mm

/// Voxels of 0.5 x 0.5 x 0.8 mm, rotated; the ball's centre is the origin.
volume::Frame oblique_frame(const ivec3& size) {
  const double a = 25 * 3.14159265358979 / 180, c = std::cos(a), s = std::sin(a);
  const dvec3 spacing(0.5, 0.5, 0.8);
  const glm::dmat3 axes(spacing.x * dvec3(c, s, 0.1), spacing.y * dvec3(-s, c, 0),
                        spacing.z * glm::normalize(dvec3(-0.1 * c, -0.1 * s, 1)));
  return volume::Frame::from_axes(-axes * (0.5 * dvec3(size - 1)), axes).value();
}

/// Returns a ball that is divided into labels 1 to 3 by the angle about z. At its surface, intensities rise
/// from -1000 to 1000 over `ramp` mm (0: in a step).
std::shared_ptr<const volume::Volume> divided_ball(double ramp) {
  const ivec3 size(90, 90, 70);
  volume::Volume v = volume::make_volume(size, oblique_frame(size), true).value();
  v.label_names = {"background", "part1", "part2", "part3"};
  for (int z = 0; z < size.z; ++z)
    for (int y = 0; y < size.y; ++y)
      for (int x = 0; x < size.x; ++x) {
        const dvec3 p = v.frame.world_from_volume({x, y, z});
        const double depth = k_radius - glm::length(p);
        const std::size_t i = v.index(x, y, z);
        v.voxels[i] = static_cast<std::int16_t>(ramp > 0    ? std::clamp(2000 * depth / ramp, -1000.0, 1000.0)
                                                : depth > 0 ? 1000
                                                            : -1000);
        const double turn = std::atan2(p.y, p.x) / (2 * 3.14159265358979) + 1;
        v.labels[i] = depth > 0 ? static_cast<std::uint8_t>(1 + static_cast<int>(3 * turn) % 3) : 0;
      }
  return std::make_shared<const volume::Volume>(std::move(v));
}

TouchItem item_of_shape(const volume::Volume& base, const volume::Shape& shape) {
  return {volume::Field(base, shape),
          std::make_shared<const volume::Occupancy>(volume::Occupancy::build(base, shape)), Material{},
          Side::front};
}
volume::Shape label_of(int label) {
  volume::Shape shape;
  shape.name = "part" + std::to_string(label);
  shape.label = label;
  return shape;
}
volume::Shape window_from(double low) {
  volume::Shape shape;
  shape.name = "bone";
  shape.low = low;
  return shape;
}

/// A metal ball of 8 mm radius that protrudes from the surface of the divided ball by 2 mm.
TouchItem metal_ball() {
  const haptics::TouchScene sphere = scenes::phantom_scene("sphere", [] {
    data_tools::PhantomOptions o;
    o.size = ivec3(64), o.parameters = {{"radius", 8}};
    return o;
  }());
  const volume::Mesh net = volume::surface_net({&sphere.items[0].field, nullptr, sphere.items[0].bits.get()});
  std::vector<dvec3> vertices;
  for (const glm::vec3& v : net.vertices.span())
    vertices.push_back(sphere.base->frame.world_from_volume(dvec3(v)) + dvec3(10, 0, 0));
  return mesh_item("metal", std::make_shared<MeshTree>(
                                std::move(vertices),
                                std::vector<std::uint32_t>(net.triangles.data(),
                                                           net.triangles.data() + net.triangles.size())));
}

struct Division {
  const char* name;
  TouchScene scene;
  bool is_of_one_volume = true, has_models = false;
};
std::vector<Division> divisions() {
  const auto binary = divided_ball(0), grey = divided_ball(4);
  std::vector<Division> all;
  all.reserve(8);  // references stay valid
  const auto add = [&](const char* name, const auto& base) -> TouchScene& {
    all.push_back({name, {}});
    all.back().scene.base = base;
    return all.back().scene;
  };
  TouchScene& labels = add("three labels", binary);
  for (int k = 1; k <= 3; ++k) labels.items.push_back(item_of_shape(*binary, label_of(k)));
  TouchScene& overlap = add("a window and a label in it", binary);
  overlap.items = {item_of_shape(*binary, window_from(0)), item_of_shape(*binary, label_of(1))};
  TouchScene& mixed = add("a grey window and a label in it", grey);
  mixed.items = {item_of_shape(*grey, window_from(0)), item_of_shape(*grey, label_of(1))};
  TouchScene& metal = add("three labels and a model", binary);
  metal.items = labels.items;
  metal.items.push_back(metal_ball());
  all.back().has_models = true;
  TouchScene& two = add("two volumes", binary);
  two.others = {grey};
  two.items = {item_of_shape(*binary, label_of(1)), item_of_shape(*binary, label_of(2)),
               item_of_shape(*grey, label_of(3))};
  all.back().is_of_one_volume = false;
  for (Division& division : all) {
    for (TouchItem& item : division.scene.items) item.material = {0.5, 0.001, 0.2, 0.15};
    soften(division.scene);
  }
  return all;
}

/// Circles the divided ball at 60 mm/s, across every seam at several latitudes. The hand is such that the
/// surface of the tool would be 0.6 to 1.8 mm inside the ball. Returns the number of ticks in which nothing
/// holds the tool, or in which the tool is too deep. is_lost(i): true plants a lost contact in tick i.
/// `rate`: Hz.
template <class IsLost>
long count_lost(const TouchScene& scene, const ProxyMethod& method, double rate, IsLost&& is_lost) {
  const auto seen = std::make_shared<const TouchState>(uncut_version(scene));
  ProxyState state;
  long lost = 0;
  const long count = static_cast<long>(7 * rate);
  for (long i = 0; i < count; ++i) {
    const double t = static_cast<double>(i) / rate, angle = 3.7 * t, tilt = 0.5 * std::sin(2.8 * t);
    const dvec3 u(std::cos(angle) * std::cos(tilt), std::sin(angle) * std::cos(tilt), std::sin(tilt));
    const double in = std::min(1.0, t / 0.3) * (4.2 + 0.6 * std::sin(15 * t)) - 3 - scene.tool->radius();
    ProxyStep step = method.step(scene, *seen, state, {(k_radius - in) * u});
    if (is_lost(i)) step.has_contact = false;
    // Protruding parts hold the tool farther out.
    const double depth = k_radius - glm::length(step.proxy_world);
    constexpr double k_deep = 0.9;  // mm, allowed since surfaces of labels and thick slices are coarse
    lost += (in + scene.tool->radius() > 0.6 && !step.has_contact) ||
            (step.has_contact && depth + scene.tool->radius() > k_deep);
  }
  return lost;
}

TEST(Seams, NothingFallsThroughWhereShapesMeet) {
  for (Division& division : divisions())
    for (const double radius : {0.0, 1.5}) {
      if (radius > 0 && set_tool_radius(division.scene, radius)) continue;
      for (const char* name : {"subvoxel", "scene"}) {
        const auto method = make_method(name).value();
        if (method->prepare(division.scene)) {
          EXPECT_STREQ(name, "subvoxel");
          EXPECT_TRUE(division.has_models || !division.is_of_one_volume) << division.name;
          continue;
        }
        for (const double rate : {100.0, 1000.0, 5000.0})
          EXPECT_EQ(count_lost(division.scene, *method, rate, [](long) { return false; }), 0)
              << division.name << ", " << name << ", " << rate << " Hz, ball of " << radius << " mm";
      }
    }
}

/// Presses along the line where three labels meet, from the pole toward the centre, in small circles about
/// the line.
TEST(Seams, NoChannelLeadsInWhereThreeLabelsMeet) {
  Division division = std::move(divisions().front());
  for (const double radius : {0.0, 1.5}) {
    ASSERT_FALSE(set_tool_radius(division.scene, radius));
    for (const char* name : {"subvoxel", "scene", "implicit", "explicit", "mesh", "depth"}) {
      const auto method = make_method(name).value();
      if (method->prepare(division.scene)) {
        EXPECT_EQ(std::string(name) == "depth", radius > 0) << name;
        continue;
      }
      const auto seen = std::make_shared<const TouchState>(uncut_version(division.scene));
      ProxyState state;
      double deepest = -1e9;
      for (int i = 0; i < 8000; ++i) {
        const double along = k_radius + 3 - 0.002 * i, wide = 0.4 * std::sin(0.0031 * i);
        const dvec3 hip(wide * std::cos(0.05 * i), wide * std::sin(0.05 * i), along);
        const ProxyStep step = method->step(division.scene, *seen, state, {hip});
        deepest = std::max(deepest, k_radius - glm::length(step.proxy_world));
      }
      EXPECT_LT(deepest + radius, 0.9) << name << ", ball of " << radius << " mm";
    }
  }
}

/// The tool starts inside one label, which covers the seam of two other labels, and presses on this seam.
TEST(Seams, TheShapeThatTheToolIsInDoesNotHideASeam) {
  volume::Volume result =
      volume::make_volume(ivec3(40), volume::Frame::from_axes(dvec3(0), glm::dmat3(1)).value(), true).value();
  result.label_names = {"background", "part1", "part2", "part3"};
  for (int z = 0; z < 40; ++z)
    for (int y = 0; y < 40; ++y)
      for (int x = 0; x < 40; ++x)
        result.labels[result.index(x, y, z)] = static_cast<std::uint8_t>(z >= 20 ? 1 : x < 20 ? 2 : 3);
  TouchScene scene;
  scene.base = std::make_shared<const volume::Volume>(std::move(result));
  for (int label = 1; label <= 3; ++label) scene.items.push_back(item_of_shape(*scene.base, label_of(label)));
  soften(scene);
  for (const char* name : {"explicit", "depth"}) {
    const auto method = make_method(name).value();
    ASSERT_FALSE(method->prepare(scene));
    const auto seen = std::make_shared<const TouchState>(uncut_version(scene));
    ProxyState state;
    double lowest = 1e9;
    for (int i = 0; i < 4000; ++i)
      lowest = std::min(
          lowest, method->step(scene, *seen, state, {{19.5 + 0.1 * std::sin(0.05 * i), 20.2, 26 - 0.004 * i}})
                      .proxy_world.z);
    EXPECT_NEAR(lowest, 19.5, 0.1) << name;
  }
}

/// A trough is cut across the seam of a label and the window next to it. A frictionless tool on its floor
/// meets no obstacle where the field of the label ends and that of the window begins.
TEST(Seams, ATroughAcrossASeamIsSmooth) {
  volume::Volume result =
      volume::make_volume(ivec3(40), volume::Frame::from_axes(dvec3(0), glm::dmat3(1)).value(), true).value();
  result.label_names = {"background", "part1"};
  for (int z = 0; z < 40; ++z)
    for (int y = 0; y < 40; ++y)
      for (int x = 0; x < 40; ++x) {
        const std::size_t i = result.index(x, y, z);
        result.voxels[i] = z >= 20 ? -1000 : x < 20 ? 100 : 1000;
        result.labels[i] = z < 20 && x < 20;
      }
  const auto base = std::make_shared<const volume::Volume>(std::move(result));
  for (const double low : {300.0, 990.0})
    for (const bool is_label_first : {true, false}) {
      TouchScene scene;
      scene.base = base;
      scene.items = {item_of_shape(*base, window_from(low)), item_of_shape(*base, label_of(1))};
      if (is_label_first) std::swap(scene.items[0], scene.items[1]);
      for (TouchItem& item : scene.items) item.material = {0.5, 0.001, 0, 0};
      soften(scene);
      volume::RemovalEditor editor(
          std::make_shared<volume::Version>(base, volume::CutLattice::for_burr(*base, 4).value()),
          solids_of(scene));
      editor.remove({{10, 20, 19}, {30, 20, 19}, 2});
      for (const char* name : {"subvoxel", "scene"}) {
        const auto method = make_method(name).value();
        ASSERT_FALSE(method->prepare(scene));
        const auto seen = std::make_shared<const TouchState>(editor.freeze());
        ProxyState state;
        double behind = 0, lowest = 1e9, highest = 0;
        const auto go = [&](const dvec3& from, const dvec3& to, bool is_judged) {
          for (int i = 0; i <= 800; ++i) {
            const dvec3 hip = from + i / 800.0 * (to - from);
            const ProxyStep step = method->step(scene, *seen, state, {hip});
            if (!is_judged) continue;
            behind = std::max(behind, std::abs(step.proxy_world.x - hip.x));
            lowest = std::min(lowest, step.proxy_world.z), highest = std::max(highest, step.proxy_world.z);
          }
        };
        go({28, 20.3, 30}, {28, 20.3, 15.5}, false);
        go({28, 20.3, 15.5}, {12, 20.4, 15}, true);
        go({12, 20.4, 15}, {28, 20.1, 14.6}, true);
        EXPECT_LT(behind, 0.05) << name << ", from " << low << ", label first: " << is_label_first;
        EXPECT_GT(lowest, 16.9) << name;
        EXPECT_LT(highest, 17.1) << name;
      }
    }
}

TEST(Seams, LostContactsAreCounted) {
  Division division = std::move(divisions().front());
  const auto method = make_method("subvoxel").value();
  ASSERT_FALSE(method->prepare(division.scene));
  EXPECT_EQ(count_lost(division.scene, *method, 100, [](long i) { return i == 300 || i == 500; }), 2);
}

}  // namespace
}  // namespace trephine::haptics
