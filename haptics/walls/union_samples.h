// UnionSamples: several shapes of one lattice as one surface.
#pragma once

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "haptics/scene/shape_set.h"
#include "volume/surface/cell_samples.h"

namespace trephine::haptics {

/// Samples of the union of shapes. Where three regions meet, such as two labels and the air, or three labels,
/// the surfaces of the single shapes leave a gap that the surface of the union does not have.
/// `samples_of(s)` returns the samples of shape s (see volume/surface/cell_samples.h). Any thread; allocates
/// nothing.
template <class SamplesOf>
class UnionSamples {
 public:
  UnionSamples(const SamplesOf& samples_of, const ShapeSet& members) noexcept
      : samples_of_(samples_of), members_(members) {}

  bool is_solid(const glm::ivec3& v) const noexcept { return owner(v) < ShapeSet::k_max; }
  void place(const glm::ivec3& cell, const volume::NetCase& net, glm::vec3* out) const noexcept {
    volume::place_between_crossings(*this, cell, net, out);
  }
  float crossing(const glm::ivec3& solid, const glm::ivec3& air) const noexcept {
    float farthest = 0;
    for (int s = members_.next(0); s < ShapeSet::k_max; s = members_.next(s + 1))
      if (const auto samples = samples_of_(s); samples.is_solid(solid))
        farthest = std::max(farthest, samples.crossing(solid, air));
    return farthest;
  }
  /// Returns the first member that is solid at v; ShapeSet::k_max if no member is solid there.
  int owner(const glm::ivec3& v) const noexcept {
    int s = members_.next(0);
    while (s < ShapeSet::k_max && !samples_of_(s).is_solid(v)) s = members_.next(s + 1);
    return s;
  }
  /// Returns the member with the solid corner nearest to a point on the surface of the union.
  int owner_near(const glm::dvec3& p) const noexcept {
    const glm::ivec3 cell(glm::floor(p));
    int nearest = members_.next(0);
    double least = 1e300;
    for (int i = 0; i < 8; ++i) {
      const glm::ivec3 corner = cell + glm::ivec3(i & 1, i >> 1 & 1, i >> 2 & 1);
      const glm::dvec3 offset = glm::dvec3(corner) - p;
      const double distance = glm::dot(offset, offset);
      if (const int s = owner(corner); s < ShapeSet::k_max && distance < least) least = distance, nearest = s;
    }
    return nearest;
  }

 private:
  SamplesOf samples_of_;
  ShapeSet members_;
};

}  // namespace trephine::haptics
