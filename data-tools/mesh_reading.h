// Polygonal models in, from the formats that scanners, atlases and modellers write.
#pragma once

#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "volume/error.h"

namespace trephine::data_tools {

/// Triangles over shared vertices, mm, in the patient's frame (LPS).
struct PolygonModel {
  std::vector<glm::dvec3> vertices;
  std::vector<std::uint32_t> triangles;  ///< three vertices each, counter-clockwise from outside
  std::vector<std::string> notices;      ///< what is odd about it: open, turned, of an odd size
};

/// Connectivity of its triangles, where corners in one place are one.
struct ModelFacts {
  std::size_t triangles = 0;
  std::size_t open_edges = 0;     ///< of one triangle only: the surface has a border there
  std::size_t crowded_edges = 0;  ///< of three and more
  std::size_t turned_edges = 0;   ///< whose triangles face opposite ways
  double volume = 0;              ///< mm3; below 0 the surface faces inward
  glm::dvec3 size{0.0};           ///< mm
};
ModelFacts facts_of(const PolygonModel& model);

/// Reads .ply, .ply.gz, .obj (both in our own code: VTK 9.1 crashes on some), .stl, .vtk or .vtp; polygons
/// and strips become triangles, `scale` (mm per unit) is applied. `frame`, "LPS" or "RAS", states the axes;
/// "" uses what the file states (3D Slicer writes SPACE=RAS into headers or field data), else LPS. Error when
/// there is no such file, it holds no polygon, or a coordinate is not finite.
volume::Result<PolygonModel> read_polygon_model(const std::string& path, double scale = 1,
                                                const std::string& frame = "");

/// By its ending.
bool is_polygon_model(const std::string& path);

}  // namespace trephine::data_tools
