// Play: steps a proxy method and judges each step by the solid that the method guarantees not to enter.
#pragma once

#include <algorithm>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include "apps/bench/scenes/guaranteed_solid.h"
#include "apps/bench/scenes/scenes.h"
#include "haptics/methods/methods.h"
#include "volume/cuts/removal.h"

namespace trephine::haptics {

inline data_tools::PhantomOptions phantom_options(int size, double psf, double shear = 0,
                                                  std::map<std::string, double> parameters = {}) {
  data_tools::PhantomOptions o;
  o.size = glm::ivec3(size);
  o.psf_sigma_voxels = psf;
  o.shear_degrees = shear;
  o.parameters = std::move(parameters);
  return o;
}

/// Returns the suffix of test names for a method, such as "explicit_cubes".
inline std::string name_suffix(const testing::TestParamInfo<const char*>& info) {
  std::string name = info.param;
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

struct Play {
  TouchScene scene;
  std::shared_ptr<const volume::Version> version;
  std::shared_ptr<const TouchState> touch_state;  ///< the version with the fields of a round tool
  std::unique_ptr<ProxyMethod> method;
  ProxyState state;
  verify::FallThroughJudge judge;
  long contacts = 0;

  Play(const std::string& name, TouchScene s)
      : scene(std::move(s)),
        version(std::make_shared<volume::Version>(scene.base)),
        method(make_method(name).value()),
        judge([this](const glm::dvec3& a, const glm::dvec3& b) { return solid->meets(a, b); }) {
    EXPECT_FALSE(method->prepare(scene).has_value());
    set_version(version);
  }
  void no_friction() {
    for (TouchItem& shape : scene.items) shape.material.static_friction = shape.material.dynamic_friction = 0;
  }
  /// Continues with another version, as a servo does between two steps.
  void set_version(std::shared_ptr<const volume::Version> next, TouchState::OffsetFields offsets = {}) {
    version = std::move(next);
    touch_state = std::make_shared<TouchState>(version, std::move(offsets));
    solid = std::make_unique<scenes::GuaranteedSolid>(*find_method(method->name()), scene, touch_state);
    judge.solid_changed();
  }
  ProxyStep step(const glm::dvec3& hip_world) {
    const ProxyStep s = method->step(scene, *touch_state, state, {hip_world});
    judge.judge_step({std::span(s.path_volume.data(), static_cast<std::size_t>(s.waypoint_count)),
                      scene.base->frame.volume_from_world(hip_world), s.has_contact, s.is_buried});
    contacts += s.has_contact;
    return s;
  }

 private:
  std::unique_ptr<scenes::GuaranteedSolid> solid;
};

}  // namespace trephine::haptics
