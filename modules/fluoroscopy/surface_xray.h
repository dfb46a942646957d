// X-ray images by surfaces alone (Luo 2014's shader, equations 6.1 and 6.2): how far rays pass within closed
// meshes of one attenuation each, and an edge that stands for dense outer bone.
#pragma once

#include <span>
#include <vector>

#include "modules/fluoroscopy/mesh_crossings.h"

namespace trephine::fluoroscopy {

struct SurfaceObject {
  std::vector<glm::dvec3> vertices_world, normals_world;  ///< unit, one a vertex
  std::vector<std::uint32_t> triangles;
  std::vector<std::uint8_t> is_wall =
      {};                ///< one a triangle: where a scan ends; they have no edge; empty: none
  double weight = 0.02;  ///< 1/mm
  double edge = 0;       ///< what a ray that only grazes it counts (no unit); squarely met: nothing
};

/// Sum of signed depths times weight (the ray's way within), and with it the edges: a pixel's transmission
/// is exp(-(within + edges)). Row by row of the whole view; closed pixels 0.
struct SurfaceXray {
  std::vector<double> within, edges;
  /// Rays that leave an object not as often as they enter it, over all objects: 0 for closed meshes.
  std::int64_t unbalanced = 0;
};
/// Whole numbers are summed: the order of triangles changes no bit. An object that reaches the source: error.
volume::Result<SurfaceXray> project_surfaces(const View& view, std::span<const SurfaceObject> objects);

/// Unit normals of a mesh's vertices, by the areas of their triangles.
std::vector<glm::dvec3> vertex_normals(const ProjectedMesh& mesh);

}  // namespace trephine::fluoroscopy
