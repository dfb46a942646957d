// Colours of shapes and of bone in the picture.
#pragma once

#include <optional>

#include "apps/view/chunk_meshes.h"

namespace trephine::view {

/// Colours of a shape, RGB from 0 to 1.
struct Tint {
  glm::dvec3 spongy, compact, cut_spongy, cut_compact;
};
/// Returns the tint of a shape: derived from its own colour, or chosen by its index.
Tint tint_of(std::size_t shape, const std::optional<glm::dvec3>& colour);

/// Returns the colour of a vertex in open light, shares of 1.
glm::dvec3 colour_of(const Tint& tint, const VertexMatter& matter);
glm::dvec3 bone_colour(const VertexMatter& matter);

}  // namespace trephine::view
