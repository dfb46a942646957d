// write_mesh(): writes meshes in the formats of printers, viewers and other programs.
#pragma once

#include <string>

#include "volume/surface/surface_nets.h"

namespace trephine::data_tools {

/// Writes a mesh atomically, in world coordinates (LPS, mm), triangles counter-clockwise from outside. The
/// extension selects the format: .stl (binary), .ply (binary), .obj, .vtp, or .glb (glTF 2.0, in its units
/// and axes: metres, y up, the patient facing z).
Status write_mesh(const std::string& path, const volume::Mesh& mesh, const volume::Frame& frame);

}  // namespace trephine::data_tools
