#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "volume/parallel.h"
#include "volume/surface_nets.h"

namespace trephine::volume {

Buffer<glm::vec3> vertex_normals(const SurfaceSource& source, const Mesh& mesh, int threads) {
  Buffer<glm::vec3> normals(mesh.vertices.size());
  const Frame& frame = source.field->volume().frame;
  const bool is_cut = source.version != nullptr && !source.version->is_untouched();
  // Voxel steps within which a vertex lies on both surfaces: a part of a lattice step.
  constexpr double k_rim = 0.2;
  double rim = 0;
  if (is_cut) {
    const glm::dvec3& k = source.version->lattice().scale();
    rim = k_rim / std::max({k.x, k.y, k.z});
  }
  constexpr std::size_t k_task = 4096;
  const int tasks = static_cast<int>((mesh.vertices.size() + k_task - 1) / k_task);
  parallel_for(tasks, threads, [&](int task) {
    const std::size_t begin = static_cast<std::size_t>(task) * k_task;
    for (std::size_t i = begin; i < std::min(begin + k_task, mesh.vertices.size()); ++i) {
      const glm::dvec3 p(mesh.vertices[i]);
      glm::dvec3 gradient = source.field->smooth_gradient(p);
      if (is_cut && source.version->is_near_cut(p)) {
        // The nearer of the two surfaces shapes this vertex; on their common edge both do.
        const glm::dvec3 cut = source.version->distance_gradient(p);
        const double to_cut = std::abs(source.version->distance(p)) / std::max(glm::length(cut), 1e-9);
        const double to_field =
            std::abs(source.field->value(p)) / std::max(glm::length(source.field->gradient(p)), 1e-9);
        if (std::max(to_cut, to_field) < rim) {
          const auto unit = [&frame](const glm::dvec3& g) {
            const glm::dvec3 world = frame.gradient_world_from_volume(g);
            return world / std::max(glm::length(world), 1e-300);
          };
          gradient = (unit(gradient) + unit(cut)) * frame.axes();  // back in steps: a covector
        } else if (to_cut < to_field) {
          gradient = cut;
        }
      }
      const glm::dvec3 world = frame.gradient_world_from_volume(gradient);
      const double length = glm::length(world);
      normals[i] = length > 0 ? glm::vec3(-world / length) : glm::vec3(0, 0, 1);
    }
  });
  return normals;
}

}  // namespace trephine::volume
