// Meshes of bone as VTK draws them, with colours by density, age of the cut and occlusion.
#pragma once

#include <optional>
#include <vector>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include "apps/view/chunk_meshes.h"

namespace trephine::view {

/// Colours of a shape, RGB from 0 to 1.
struct Tint {
  glm::dvec3 spongy, compact, cut_spongy, cut_compact;
};
/// Returns the tint of a shape: of its own colour, or one by its index.
Tint tint_of(std::size_t shape, const std::optional<glm::dvec3>& colour);

/// Returns the colour of a vertex in open light, shares of 1.
glm::dvec3 bone_colour(const VertexMatter& matter);

/// Returns meshes as one, with normals and colours.
vtkSmartPointer<vtkPolyData> to_poly_data(const std::vector<const DrawMesh*>& meshes, const Tint& tint);

}  // namespace trephine::view
