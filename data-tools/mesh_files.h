// Meshes out, in the formats that printers, viewers and other programs read.
#pragma once

#include <string>

#include "volume/surface_nets.h"

namespace trephine::data_tools {

/// Writes a mesh in world coordinates (LPS, mm), outward counter-clockwise; the extension chooses: .stl
/// (binary), .ply (binary), .obj, .vtp, or .glb (glTF 2.0: metres, y up, the patient facing z, as it wants).
/// Written atomically.
volume::Status write_mesh(const std::string& path, const volume::Mesh& mesh, const volume::Frame& frame);

}  // namespace trephine::data_tools
