// read_ply(): reads vertices and faces of a Stanford .ply model.
#pragma once

#include "data-tools/meshes/mesh_reading.h"

namespace trephine::data_tools {

/// Reads the contents of a file, in the file's units and axes: text or binary of either byte order, faces
/// with any number of corners, strips. VTK 9.1 is not used: it crashes on corners that do not exist and
/// accepts truncated files. `name`: name of the file, for errors.
Result<PolygonModel> read_ply(const std::string& text, const std::string& name);

}  // namespace trephine::data_tools
