#include "modules/fluoroscopy/surface_xray.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace trephine::fluoroscopy {

using glm::dvec3;

Result<SurfaceXray> project_surfaces(const View& view, std::span<const SurfaceObject> objects) {
  const std::size_t count = static_cast<std::size_t>(view.columns) * static_cast<std::size_t>(view.rows);
  SurfaceXray image{std::vector<double>(count, 0), std::vector<double>(count, 0), 0};
  std::vector<std::int64_t> depth(count), edge(count);
  std::vector<std::int32_t> balance(count);
  constexpr double k_steps =
      0x1p44;  // fixed point: units per length of a ray in `depth`, and per 1 in `edge`
  for (const SurfaceObject& object : objects) {
    std::fill(depth.begin(), depth.end(), 0), std::fill(edge.begin(), edge.end(), 0);
    std::fill(balance.begin(), balance.end(), 0);
    const bool is_projected =
        for_crossings(view, {object.vertices_world, object.triangles}, [&](const Crossing& c) {
          const std::size_t pixel = static_cast<std::size_t>(c.column) +
                                    static_cast<std::size_t>(view.columns) * static_cast<std::size_t>(c.row);
          depth[pixel] -= c.into * std::llround(c.t * k_steps);
          balance[pixel] += c.into;
          if (object.edge <= 0 || (!object.is_on_border.empty() && object.is_on_border[c.triangle])) return;
          const std::uint32_t* corner = object.triangles.data() + 3 * std::size_t{c.triangle};
          const dvec3 normal = c.a * object.normals_world[corner[0]] + c.b * object.normals_world[corner[1]] +
                               c.c * object.normals_world[corner[2]];
          const dvec3 along = view.pixel(c.column, c.row) - view.source;
          const double size = glm::length(normal) * glm::length(along);
          // Fourth power of the sine between normal and ray: an edge is narrow.
          const double sine = size > 0 ? glm::length(glm::cross(normal, along)) / size : 0;
          edge[pixel] += std::llround(sine * sine * sine * sine * k_steps);
        });
    if (!is_projected)
      return Error{.what = "an object reaches the C-arm's source",
                   .where = "objects",
                   .expected = "all objects in front of the source",
                   .remedy = "move the C-arm"};
    for (int row = view.open.row_low; row < view.open.row_high; ++row)
      for (int column = view.open.column_low; column < view.open.column_high; ++column) {
        const std::size_t pixel = static_cast<std::size_t>(column) +
                                  static_cast<std::size_t>(view.columns) * static_cast<std::size_t>(row);
        image.unbalanced += balance[pixel] != 0;
        const double length = glm::length(view.pixel(column, row) - view.source);
        image.within[pixel] += object.weight * length * static_cast<double>(depth[pixel]) / k_steps;
        image.edges[pixel] += object.edge * static_cast<double>(edge[pixel]) / k_steps;
      }
  }
  return image;
}

std::vector<dvec3> vertex_normals(const ProjectedMesh& mesh) {
  std::vector<dvec3> normals(mesh.vertices_world.size(), dvec3(0.0));
  for (std::size_t t = 0; t + 2 < mesh.triangles.size(); t += 3) {
    const std::uint32_t* v = mesh.triangles.data() + t;
    const dvec3 a = mesh.vertices_world[v[0]];
    const dvec3 area = glm::cross(mesh.vertices_world[v[1]] - a, mesh.vertices_world[v[2]] - a);
    for (int k = 0; k < 3; ++k) normals[v[k]] += area;
  }
  for (dvec3& n : normals) n = glm::length(n) > 0 ? glm::normalize(n) : dvec3(0, 0, 1);
  return normals;
}

}  // namespace trephine::fluoroscopy
