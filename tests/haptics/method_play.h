// A proxy method at play, each step judged by what the method promises not to enter.
#pragma once

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include "haptics/methods.h"
#include "tests/checker/mesh_judge.h"
#include "tests/checker/volume_samples.h"
#include "tests/scenes/scenes.h"
#include "volume/removal.h"
#include "volume/surface_nets.h"

namespace trephine::haptics {

inline data_tools::PhantomOptions grid(int size, double psf, double shear = 0,
                                       std::map<std::string, double> parameters = {}) {
  data_tools::PhantomOptions o;
  o.size = glm::ivec3(size);
  o.psf_sigma_voxels = psf;
  o.shear_degrees = shear;
  o.parameters = std::move(parameters);
  return o;
}

struct Play {
  TouchScene scene;
  std::shared_ptr<const volume::Version> version;
  std::unique_ptr<ProxyMethod> method;
  MethodInfo::Solid solid;
  ProxyState state;
  checker::FallThroughJudge judge;
  long contacts = 0;

  Play(const std::string& name, TouchScene s)
      : scene(std::move(s)),
        version(std::make_shared<volume::Version>(scene.base)),
        method(make_method(name).value()),
        solid(find_method(name)->solid),
        judge([this](const glm::dvec3& a, const glm::dvec3& b) { return meets_solid(a, b); }) {
    EXPECT_FALSE(method->prepare(scene).has_value());
    set_version(version);
  }
  void no_friction() {
    for (TouchShape& shape : scene.shapes)
      shape.material.static_friction = shape.material.dynamic_friction = 0;
  }
  /// Goes on with another version, as a servo does between two steps.
  void set_version(std::shared_ptr<const volume::Version> next) {
    version = std::move(next);
    const volume::Shape& shape = scene.shapes[0].field.shape();
    smooth = std::make_unique<checker::SmoothSolid>(
        checker::smooth_solid(scene.base, shape, version, scene.shapes[0].soft));
    cubes = std::make_unique<checker::FallThroughJudge>(scene.base->size,
                                                        checker::solid_voxels(scene.base, shape, version));
    if (solid != MethodInfo::Solid::net) return;
    const volume::Mesh mesh =
        volume::surface_net({&scene.shapes[0].field, version.get(), scene.shapes[0].bits.get()});
    net = std::make_unique<checker::MeshWall>(mesh.vertices.span(), mesh.triangles.span());
  }
  ProxyStep step(const glm::dvec3& hip_world) {
    const ProxyStep s = method->step(scene, *version, state, {hip_world});
    judge.look({std::span(s.path_volume.data(), static_cast<std::size_t>(s.waypoint_count)),
                scene.base->frame.volume_from_world(hip_world), s.has_contact, s.is_buried});
    contacts += s.has_contact;
    return s;
  }

 private:
  bool meets_solid(const glm::dvec3& a, const glm::dvec3& b) const {
    if (solid == MethodInfo::Solid::smooth) return !smooth->is_free(a, b);
    if (solid != MethodInfo::Solid::net) return cubes->meets_solid(a, b);
    return a == b ? net->is_inside(a) : net->is_crossed(a, b);
  }
  std::unique_ptr<checker::SmoothSolid> smooth;
  std::unique_ptr<checker::FallThroughJudge> cubes;
  std::unique_ptr<checker::MeshWall> net;
};

}  // namespace trephine::haptics
