#include "apps/view/tints.h"

#include <glm/common.hpp>
#include <iterator>

namespace trephine::view {

using glm::dvec3;

namespace {

/// Colours that users with any colour vision can distinguish. Bone and cut surfaces also differ in lightness.
constexpr Tint k_tints[] = {{{0.84, 0.71, 0.55}, {0.95, 0.90, 0.80}, {0.55, 0.20, 0.15}, {0.86, 0.60, 0.48}},
                            {{0.35, 0.55, 0.75}, {0.55, 0.75, 0.92}, {0.16, 0.30, 0.50}, {0.30, 0.48, 0.70}},
                            {{0.80, 0.62, 0.20}, {0.95, 0.80, 0.35}, {0.50, 0.36, 0.05}, {0.70, 0.52, 0.12}},
                            {{0.35, 0.62, 0.48}, {0.55, 0.80, 0.66}, {0.12, 0.36, 0.26}, {0.25, 0.52, 0.40}}};

}  // namespace

dvec3 colour_of(const Tint& tint, const VertexMatter& matter) {
  const auto density = static_cast<double>(matter.density);
  return glm::mix(glm::mix(tint.spongy, tint.compact, density),
                  glm::mix(tint.cut_spongy, tint.cut_compact, density),
                  static_cast<double>(matter.freshness));
}

Tint tint_of(std::size_t shape, const std::optional<dvec3>& colour) {
  if (!colour) return k_tints[shape % std::size(k_tints)];
  return {0.85 * *colour, glm::mix(*colour, dvec3(1), 0.2), 0.45 * *colour, 0.7 * *colour};
}

dvec3 bone_colour(const VertexMatter& matter) { return colour_of(k_tints[0], matter); }

}  // namespace trephine::view
