// ModelPlay: a hand on closed models at rest, by any method.
#pragma once

#include <initializer_list>
#include <memory>

#include "apps/bench/scenes/closed_models.h"
#include "haptics/mesh/mesh_tree.h"
#include "tests/haptics/proxy/method_play.h"
#include "tests/hash_number.h"

namespace trephine::haptics::depth {

/// Returns the n-th of a reproducible sequence of random points, with coordinates between -within and within.
inline dvec3 place(std::uint64_t n, double within) {
  return within * (2.0 * dvec3(number(3 * n), number(3 * n + 1), number(3 * n + 2)) - 1.0);
}

/// A scene of models only, in a volume without solid voxels.
inline TouchScene models(std::initializer_list<Model> all) {
  TouchScene scene = scenes::phantom_scene("sphere", phantom_options(16, 1));
  scene.items.clear();
  for (const Model& m : all) {
    scene.items.push_back(mesh_item("model", std::make_shared<const MeshTree>(m.vertices, m.triangles)));
    scene.items.back().material.static_friction = scene.items.back().material.dynamic_friction = 0;
  }
  return scene;
}
/// Steps a method in a scene, without the judge that Play has for volumes.
struct ModelPlay {
  TouchScene scene;
  std::unique_ptr<ProxyMethod> method;
  TouchState seen;
  ProxyState state;

  ModelPlay(const std::string& name, TouchScene s)
      : scene(std::move(s)), method(make_method(name).value()), seen(uncut_version(scene)) {
    const Status error = method->prepare(scene);
    EXPECT_FALSE(error) << error->what;
  }
  ProxyStep step(const dvec3& hip) { return method->step(scene, seen, state, {hip}); }
};

}  // namespace trephine::haptics::depth
