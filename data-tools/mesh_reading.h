// Polygonal models in, from the formats that scanners, atlases and modellers write.
#pragma once

#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "volume/error.h"

namespace trephine::data_tools {

/// Triangles over shared vertices, as the file counts and measures.
struct PolygonModel {
  std::vector<glm::dvec3> vertices;
  std::vector<std::uint32_t> triangles;  ///< three vertices each, counter-clockwise from outside
};

/// Reads .ply, .ply.gz (in our own code: VTK 9.1 crashes on damaged ones), .obj, .stl, .vtk or .vtp; polygons
/// and strips become triangles, `scale` (mm per unit) is applied. Error when there is no such file, nothing
/// to touch in it, or a corner is no place.
volume::Result<PolygonModel> read_polygon_model(const std::string& path, double scale = 1);

}  // namespace trephine::data_tools
