// X-ray images from surfaces alone (shader of Luo 2014, equations 6.1 and 6.2): lengths of rays within closed
// meshes of uniform attenuation, and an edge term for dense outer bone.
#pragma once

#include <span>
#include <vector>

#include "modules/fluoroscopy/mesh_crossings.h"

namespace trephine::fluoroscopy {

struct SurfaceObject {
  std::vector<glm::dvec3> vertices_world, normals_world;  ///< mm; unit normals, one per vertex
  std::vector<std::uint32_t> triangles;                   ///< three indices per triangle
  /// Per triangle: true on the border of the scan, where there is no edge term; may be empty.
  std::vector<std::uint8_t> is_on_border = {};
  double weight = 0.02;  ///< attenuation, 1/mm
  double edge = 0;       ///< edge term of a grazing ray (no unit); the term is 0 for a ray along the normal
};

/// Sums per pixel over all objects: `within` is the length of the ray in an object times its weight, `edges`
/// the edge term. The transmission of a pixel is exp(-(within + edges)). Row by row of the whole view; pixels
/// outside the opening of the collimators are 0.
struct SurfaceXray {
  std::vector<double> within, edges;
  /// Number of rays that do not leave an object as often as they enter it, over all objects: 0 if all objects
  /// are closed surfaces.
  std::int64_t unbalanced = 0;
};
/// Projects all objects. The terms of an object are summed as integers, so that the order of its triangles
/// changes no bit. Error if an object reaches the plane through the source that is parallel to the detector.
Result<SurfaceXray> project_surfaces(const View& view, std::span<const SurfaceObject> objects);

/// Returns the unit normals of a mesh's vertices, weighted by the areas of their triangles.
std::vector<glm::dvec3> vertex_normals(const ProjectedMesh& mesh);

}  // namespace trephine::fluoroscopy
