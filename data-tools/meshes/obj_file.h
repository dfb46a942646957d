// read_obj(): reads vertices and faces of a Wavefront .obj model.
#pragma once

#include "data-tools/meshes/mesh_reading.h"

namespace trephine::data_tools {

/// Reads the contents of a file, in the file's units and axes. Corners of a face have the form v, v/t, v//n
/// or v/t/n and may count backward (negative); faces may be concave and continue over several lines.
/// Materials, groups, normals, texture coordinates, points and lines are ignored. Error for corners that do
/// not exist and invalid numbers. `name`: name of the file, for errors.
Result<PolygonModel> read_obj(std::string_view text, const std::string& name);

}  // namespace trephine::data_tools
