#include "volume/fields/crease_builder.h"

namespace trephine::volume {

namespace {

/// Returns the axes of the cones: the vertices of an icosahedron and the middles of its edges. No direction
/// is farther than 20.1 degrees from the nearest axis.
const std::array<glm::dvec3, CreaseBuilder::k_cones>& axes() {
  static const auto result = [] {
    constexpr double k_short = 0.5257311121191336, k_long = 0.8506508083520399;
    std::array<glm::dvec3, CreaseBuilder::k_cones> all;
    std::size_t count = 0;
    for (int axis = 0; axis < 3; ++axis)
      for (const double s : {k_short, -k_short})
        for (const double l : {k_long, -k_long}) {
          glm::dvec3& vertex = all[count++];
          vertex = glm::dvec3(0);
          vertex[axis] = s, vertex[(axis + 1) % 3] = l;
        }
    // Two vertices share an edge if the cosine of their angle is 1 / sqrt(5); for all other pairs it is
    // negative.
    for (std::size_t i = 0; i < 12; ++i)
      for (std::size_t k = i + 1; k < 12; ++k)
        if (glm::dot(all[i], all[k]) > 0.4) all[count++] = glm::normalize(all[i] + all[k]);
    return all;
  }();
  return result;
}

}  // namespace

CreaseSheets::Mask CreaseBuilder::cones_of(const glm::dvec3& normal) noexcept {
  // The half angle of a cone is 23 degrees, so that the cones cover all directions.
  constexpr double k_cosine = 0.92;
  const double length = glm::length(normal);
  if (!(length > 0)) return (CreaseSheets::Mask{1} << k_cones) - 1;
  CreaseSheets::Mask cones = 0;
  for (std::size_t cone = 0; cone < k_cones; ++cone)
    if (glm::dot(axes()[cone], normal) >= k_cosine * length) cones |= CreaseSheets::Mask{1} << cone;
  return cones;
}

}  // namespace trephine::volume
