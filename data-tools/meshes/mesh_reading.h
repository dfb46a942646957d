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

/// Connectivity of a model's triangles; vertices with equal coordinates count as one.
struct ModelFacts {
  std::size_t triangles = 0;
  std::size_t open_edges = 0;     ///< with a single triangle: border of the surface
  std::size_t crowded_edges = 0;  ///< with three or more triangles
  std::size_t turned_edges = 0;   ///< with triangles of opposite orientation
  double volume = 0;              ///< mm3; negative if the surface faces inward
  glm::dvec3 size{0.0};           ///< of the bounding box, mm
};
/// Computes the facts of a model. Takes n log n time.
ModelFacts facts_of(const PolygonModel& model);

/// Reads .ply, .ply.gz, .obj (with our own readers: VTK 9.1 crashes on some files), .stl, .vtk or .vtp.
/// Polygons and strips become triangles; `scale` (mm per unit) is applied. `frame`, "LPS" or "RAS", states
/// the axes; "" uses the file's own statement (3D Slicer writes SPACE=RAS into headers or field data), else
/// LPS. Error if the file does not exist or contains no polygon, or a coordinate is not finite.
Result<PolygonModel> read_polygon_model(const std::string& path, double scale = 1,
                                        const std::string& frame = "");

/// Returns true if the extension is that of a polygonal model.
bool is_polygon_model(const std::string& path);

}  // namespace trephine::data_tools
