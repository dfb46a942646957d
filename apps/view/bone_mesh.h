// Meshes of bone as VTK draws them: colours by density, distance to cuts and occlusion; lighting.
#pragma once

#include <vector>
#include <vtkActor.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include "apps/view/tints.h"

namespace trephine::view {

/// Merges meshes into one data set with normals and colours. `tint`: colours of the meshes that have no
/// colours per vertex.
vtkSmartPointer<vtkPolyData> to_poly_data(const std::vector<const DrawMesh*>& meshes, const Tint& tint);

/// Makes triangles that appear reversed keep their normals if these point towards the viewer. The rounding of
/// coordinates to fractions of a pixel reverses some narrow triangles; VTK lights these from inside, which
/// gives single dark pixels.
void light_reversed_triangles(vtkActor* actor);

}  // namespace trephine::view
