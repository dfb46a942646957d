// Meshes of bone as VTK draws them, with colours by density, distance to cuts and occlusion.
#pragma once

#include <vector>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include "apps/view/tints.h"

namespace trephine::view {

/// Merges meshes into one data set with normals and colours. `tint`: colours of the meshes that have no
/// colours per vertex.
vtkSmartPointer<vtkPolyData> to_poly_data(const std::vector<const DrawMesh*>& meshes, const Tint& tint);

}  // namespace trephine::view
