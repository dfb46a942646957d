// Colours of shapes and of bone in the picture.
#pragma once

#include <optional>

#include "apps/view/chunk_meshes.h"

namespace trephine::view {

/// Colours of a shape, RGB from 0 to 1.
struct Tint {
  glm::dvec3 spongy, compact, cut_spongy, cut_compact;
};
/// Returns the tint of a shape: derived from `colour`, or, without a colour, chosen by the index `shape`.
Tint tint_of(std::size_t shape, const std::optional<glm::dvec3>& colour);

/// Returns the colour (RGB, 0 to 1) of a vertex before it is darkened by near walls (DrawMesh::openness).
glm::dvec3 colour_of(const Tint& tint, const VertexMatter& matter);
/// Returns colour_of() for the tint of bone.
glm::dvec3 bone_colour(const VertexMatter& matter);

}  // namespace trephine::view
