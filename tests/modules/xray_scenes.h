// Objects to X-ray, given by formulas, for tests.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <memory>
#include <vector>

#include "haptics/mesh/mesh_tree.h"
#include "modules/fluoroscopy/c_arm.h"
#include "tests/hash_number.h"
#include "volume/scan/volume.h"

namespace trephine::fluoroscopy {

using glm::dvec2;
using glm::dvec3;
using glm::ivec3;

/// Returns a C-arm with a detector of `pixels` x `pixels` pixels of `mm` (mm).
inline CArm small_arm(int pixels = 96, double mm = 2) {
  CArm arm;
  arm.columns = arm.rows = pixels, arm.pixel = mm;
  return arm;
}

/// A scan given by a formula, in voxels that may be sheared.
inline std::shared_ptr<const volume::Volume> scan_of(const ivec3& size, const glm::dmat3& axes,
                                                     const std::function<double(const dvec3&)>& hounsfield) {
  const dvec3 origin = -0.5 * (axes * (dvec3(size) - 1.0));
  volume::Volume v = volume::make_volume(size, volume::Frame::from_axes(origin, axes).value()).value();
  v.is_hounsfield = true;
  for (int z = 0; z < size.z; ++z)
    for (int y = 0; y < size.y; ++y)
      for (int x = 0; x < size.x; ++x)
        v.voxels[v.index(x, y, z)] =
            static_cast<std::int16_t>(std::lround(hounsfield(v.frame.world_from_volume({x, y, z}))));
  return std::make_shared<const volume::Volume>(std::move(v));
}
/// Returns the axes of voxels of `mm` (mm) without shear.
inline glm::dmat3 straight(const dvec3& mm) {
  glm::dmat3 axes(0.0);
  axes[0].x = mm.x, axes[1].y = mm.y, axes[2].z = mm.z;
  return axes;
}

/// A closed box. The corners of each triangle are counter-clockwise as viewed from outside.
struct Box {
  std::vector<dvec3> vertices;
  std::vector<std::uint32_t> triangles{0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                                       2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
  Box(const dvec3& low, const dvec3& high) {
    for (int i = 0; i < 8; ++i)
      vertices.push_back({i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z});
  }
};
/// Returns the length of a segment inside a box, mm.
inline double chord(const dvec3& from, const dvec3& to, const dvec3& low, const dvec3& high) {
  double in = 0, out = 1;
  for (int a = 0; a < 3; ++a) {
    const double along = to[a] - from[a];
    if (along == 0) {
      if (from[a] < low[a] || from[a] > high[a]) return 0;
      continue;
    }
    const double s = (low[a] - from[a]) / along, t = (high[a] - from[a]) / along;
    in = std::max(in, std::min(s, t)), out = std::min(out, std::max(s, t));
  }
  return in < out ? (out - in) * glm::length(to - from) : 0;
}
/// Returns a closed cylinder around the axis from `from` to `to`, with `facets` flat sides.
inline haptics::MeshTree cylinder(const dvec3& from, const dvec3& to, double radius, int facets) {
  const dvec3 along = glm::normalize(to - from);
  const dvec3 u =
      glm::normalize(glm::cross(along, std::abs(along.x) < 0.9 ? dvec3(1, 0, 0) : dvec3(0, 1, 0)));
  const dvec3 v = glm::cross(along, u);
  std::vector<dvec3> vertices{from, to};
  std::vector<std::uint32_t> triangles;
  for (int i = 0; i < facets; ++i) {
    const double angle = 2 * 3.14159265358979323846 * i / facets;
    for (const dvec3& end : {from, to})
      vertices.push_back(end + radius * (std::cos(angle) * u + std::sin(angle) * v));
  }
  for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(facets); ++i) {
    const std::uint32_t a = 2 + 2 * i, b = 2 + 2 * ((i + 1) % static_cast<std::uint32_t>(facets));
    for (const std::uint32_t corner : {0u, b, a, 1u, a + 1, b + 1, a, b, a + 1, b, b + 1, a + 1})
      triangles.push_back(corner);
  }
  return {std::move(vertices), std::move(triangles)};
}

}  // namespace trephine::fluoroscopy
