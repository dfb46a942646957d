// Stanford .ply: the vertices and faces of a model.
#pragma once

#include "data-tools/mesh_reading.h"

namespace trephine::data_tools {

/// Reads the contents of a file, in its own units and axes: text or bytes of either order, faces of any
/// number of corners, strips. In our own code, since VTK 9.1 crashes on corners that do not exist and accepts
/// files that are cut off. `name`: of the file, for errors.
volume::Result<PolygonModel> read_ply(const std::string& text, const std::string& name);

}  // namespace trephine::data_tools
