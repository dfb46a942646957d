// Hand: a hand that touches one object by depth images, which are drawn every ten ticks.
#pragma once

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include "apps/bench/scenes/scenes.h"
#include "haptics/depth/depth_model.h"
#include "haptics/depth/depth_rules.h"
#include "haptics/methods/methods.h"
#include "tests/haptics/depth/model_play.h"
#include "volume/base/deterministic_math.h"

namespace trephine::haptics::depth {

using glm::ivec3;

/// Returns a model with one key, which does not move.
inline std::shared_ptr<const DepthModel> at_rest(const Model& m) {
  ModelKeys keys;
  keys.triangles = m.triangles;
  keys.keys = {m.vertices};
  return DepthModel::of(std::move(keys)).value();
}

/// A hand in a scene of one object. A set of depth images of the object is drawn every ten ticks, and the
/// hand uses this set from `lag` ticks later on.
struct Hand {
  TouchScene scene = scenes::phantom_scene("sphere", [] {
    data_tools::PhantomOptions o;
    o.size = ivec3(16);
    o.spacing_mm = dvec3(0.5);
    return o;
  }());
  std::unique_ptr<ProxyMethod> method = make_method("scene").value();
  std::shared_ptr<const volume::Version> version;
  TouchState seen{nullptr};
  ProxyState state;
  int tick = 0;
  int lag = 0;  ///< ticks from the drawing of a set to its use
  std::shared_ptr<const DepthSet> next;
  bool knows_motion = true;  ///< false: a set does not move until the next one (planted fault)
  double room = 1;           ///< factor by which the clip volume exceeds the published rule
  double pixel = 0.2;        ///< mm

  explicit Hand(std::shared_ptr<const DepthSource> source, double radius = 0, double rough = 0) {
    scene.items.clear();
    scene.items.push_back(depth_item("thing", source, std::make_shared<const MeshTree>()));
    scene.items[0].mover = source->is_moving(0) ? 0 : -1;
    scene.items[0].material.static_friction = scene.items[0].material.dynamic_friction = rough;
    scene.tool = std::make_shared<const ToolShape>(radius);
    version = uncut_version(scene);
    seen = TouchState(version);
    seen.depths.resize(1);
    EXPECT_FALSE(method->prepare(scene));
  }
  ProxyStep step(const dvec3& hip) {
    const double time = 0.001 * tick;
    const dvec3 proxy = state.has_proxy ? version->base().frame.world_from_volume(state.proxy_volume) : hip;
    if (tick % 10 == 0) {
      DepthView view;
      view.middle = 0.5 * (hip + proxy);
      view.touch = proxy;
      view.pixel = pixel;
      view.edge = room * clip_volume({1000, 1 / (0.01 + 0.001 * lag), 1000}) + glm::length(hip - proxy);
      view.time = time;
      auto set = std::make_shared<DepthSet>(scene.items[0].depth->draw(view, 1).value());
      if (!knows_motion) set->motion = {};
      set->follow(next.get());
      next = std::move(set);
    }
    if (next && tick % 10 == lag) seen.depths[0] = next;
    ProxyInput input{hip};
    input.time = time;
    ++tick;
    return method->step(scene, seen, state, input);
  }
};

}  // namespace trephine::haptics::depth
