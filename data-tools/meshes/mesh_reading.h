// PolygonModel: polygonal models from the file formats of scanners, atlases and modelling programs.
#pragma once

#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "volume/base/error.h"

namespace trephine::data_tools {

/// Triangles over shared vertices, mm, in the patient's frame (LPS).
struct PolygonModel {
  std::vector<glm::dvec3> vertices;
  std::vector<std::uint32_t> triangles;  ///< three vertices each, counter-clockwise from outside
  std::vector<std::string> notices;      ///< for the user: open edges, orientation, unusual size
};

/// Reads .ply, .ply.gz, .obj (with our own readers: VTK 9.1 crashes on some files), .stl, .vtk or .vtp.
/// Polygons and strips become triangles; `scale` (mm per unit) is applied. `frame`, "LPS" or "RAS", states
/// the axes; "" uses the file's own statement (3D Slicer writes SPACE=RAS into headers or field data), else
/// LPS. Error if the file does not exist, is damaged or contains no polygon, or if a coordinate is not finite
/// or exceeds 1e6 mm (1 km).
Result<PolygonModel> read_polygon_model(const std::string& path, double scale = 1,
                                        const std::string& frame = "");

/// Returns true if the extension is that of a polygonal model.
bool is_polygon_model(const std::string& path);

}  // namespace trephine::data_tools
