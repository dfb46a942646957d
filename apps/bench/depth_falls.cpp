// Counts the segments of proxy paths that cross a thin wall.
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "apps/bench/depth.h"
#include "apps/bench/scenes/closed_models.h"
#include "apps/bench/scenes/scenes.h"
#include "apps/verify/mesh_judge.h"
#include "data-tools/phantoms/phantoms.h"
#include "haptics/mesh/mesh_tree.h"
#include "haptics/methods/methods.h"
#include "volume/base/deterministic_math.h"

namespace trephine::bench {

using glm::dvec3;
using namespace haptics;
using depth::ball;
using depth::box;
using depth::Model;

namespace {

/// An object, and a sheet in the middle of its walls that a correct proxy never crosses. The sheet ends
/// before edges, around which a proxy may move.
struct Object {
  const char* name;
  double wall;
  Model model, middle;
  dvec3 start;  ///< free position at which runs begin: inside a tube or a hollow ball, above a plate
};

std::vector<Object> test_objects() {
  std::vector<Object> all;
  for (const double wall : {0.1, 0.3, 1.0, 2.5}) {
    Object plate{"plate", wall, box({-8, -8, -0.5 * wall}, {8, 8, 0.5 * wall}), {}, dvec3(0, 0, 3)};
    plate.middle = box({-6, -6, 0}, {6, 6, 0});
    all.push_back(plate);
  }
  // A tube along z. Between its ends, a path into or out of the tube must cross a wall.
  const auto square = [](double half, double z) { return box({-half, -half, -z}, {half, half, z}); };
  for (const double wall : {0.3, 1.0}) {
    Object tube{"tube", wall, {}, {}, dvec3(0)};
    for (const double s : {-1.0, 1.0}) {
      const double a = s * 0.6, b = s * (0.6 + wall);
      tube.model.add(box({std::min(a, b), -0.6 - wall, -7}, {std::max(a, b), 0.6 + wall, 7}));
      tube.model.add(box({-0.6, std::min(a, b), -7}, {0.6, std::max(a, b), 7}));
    }
    tube.middle = square(0.6 + 0.5 * wall, 5);
    tube.middle.triangles.erase(tube.middle.triangles.begin(), tube.middle.triangles.begin() + 12);
    all.push_back(tube);
  }
  for (const double wall : {0.3, 1.0}) {
    Object hollow{"calabash", wall, ball(dvec3(0), 6, 90), ball(dvec3(0), 6 - 0.5 * wall, 90), dvec3(0)};
    hollow.model.add(ball(dvec3(0), 6 - wall, 90).inward());
    all.push_back(hollow);
  }
  // Tilted, so that no face is aligned with pixels.
  const glm::dquat turn = glm::normalize(glm::dquat(1, 0.15, -0.3, 0.2));
  for (Object& object : all) {
    for (Model* m : {&object.model, &object.middle})
      for (dvec3& p : m->vertices) p = turn * p;
    object.start = turn * object.start;
  }
  return all;
}

}  // namespace

std::vector<FallRow> run_depth_falls(bool is_quick) {
  std::vector<FallRow> rows;
  for (const Object& object : test_objects()) {
    FallRow row;
    row.object = object.name, row.wall = object.wall;
    row.steps = is_quick ? 3'000 : 100'000;
    TouchScene scene = scenes::phantom_scene("sphere", [] {
      data_tools::PhantomOptions o;
      o.size = glm::ivec3(16);
      return o;
    }());
    scene.items = {
        mesh_item("object", std::make_shared<const MeshTree>(object.model.vertices, object.model.triangles))};
    scene.items[0].material.static_friction = scene.items[0].material.dynamic_friction = 0;
    const auto version = uncut_version(scene);
    const volume::Frame& frame = scene.base->frame;
    const verify::MeshWall middle(object.middle.vertices, object.middle.triangles, 1.0);
    for (const char* name : {"lomi", "lomi-parts", "depth", "mesh"}) {
      const auto method = make_method(name).value();
      if (method->prepare(scene)) continue;
      FallRow::Method one;
      one.name = name;
      std::uint64_t n = 1;
      const auto random = [&] { return static_cast<double>(hash_bits(n++) >> 11) * 0x1p-53; };
      const auto random_point = [&] {  // the order of arguments is unspecified, that of statements is not
        const double x = random(), y = random();
        return dvec3(x, y, random());
      };
      ProxyState state;
      dvec3 hip(0);
      for (long i = 0; i < row.steps; ++i) {
        if (i % 200 == 0) {  // restarts, at the start of the object and at a random free position in turn
          state = {};
          do hip = i % 400 == 0 ? object.start : 9.0 * (2.0 * random_point() - 1.0);
          while (std::abs(depth::winding(object.model, hip)) > 0.5);
        }
        const bool was_fresh = !state.has_proxy;
        // Up to 1 mm per tick along each axis (1.7 m/s), or a tenth of it.
        const double mm = was_fresh ? 0 : i % 3 == 0 ? 1 : 0.1;
        const dvec3 direction = 2.0 * random_point() - 1.0;
        hip = glm::clamp(hip + mm * direction, dvec3(-10), dvec3(10));
        const ProxyStep s = method->step(scene, *version, state, {hip});
        one.contact_steps += s.has_contact;
        for (int k = 1; !was_fresh && k < s.waypoint_count; ++k) {
          const auto at = [&](int w) {
            return frame.world_from_volume(s.path_volume[static_cast<std::size_t>(w)]);
          };
          one.passed += middle.is_crossed(at(k - 1), at(k));
        }
      }
      row.methods.push_back(one);
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace trephine::bench
