// Wavefront .obj: the vertices and faces of a model.
#pragma once

#include "data-tools/mesh_reading.h"

namespace trephine::data_tools {

/// Reads the contents of a file, in its own units and axes. Faces may name corners as v, v/t, v//n or v/t/n,
/// count backward (negative), be concave, and go on over several lines. Materials, groups, normals, texture
/// coordinates, points and lines are ignored. Error for a face whose corner does not exist, and for numbers
/// that cannot be read; `name`: of the file, for errors.
volume::Result<PolygonModel> read_obj(std::string_view text, const std::string& name);

}  // namespace trephine::data_tools
