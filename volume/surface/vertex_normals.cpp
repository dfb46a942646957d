#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "volume/base/parallel.h"
#include "volume/surface/surface_nets.h"

namespace trephine::volume {

Buffer<glm::vec3> vertex_normals(const SurfaceSource& source, const Mesh& mesh, int threads) {
  Buffer<glm::vec3> normals(mesh.vertices.size());
  const Frame& frame = source.field->volume().frame;
  const bool is_cut = source.version != nullptr && !source.version->is_uncut();
  // A vertex within `rim` (mm) of both surfaces is on their common edge; k_rim: share of a lattice step.
  constexpr double k_rim = 0.25;
  double rim = 0;
  if (is_cut) {
    const glm::dvec3& step = source.version->lattice().frame().spacing();
    rim = k_rim * std::min({step.x, step.y, step.z});
  }
  const auto in_world = [&frame](const glm::dvec3& gradient) {
    return frame.gradient_world_from_volume(gradient);
  };
  constexpr std::size_t k_task = 4096;
  const int tasks = static_cast<int>((mesh.vertices.size() + k_task - 1) / k_task);
  parallel_for(tasks, threads, [&](int task) {
    const std::size_t begin = static_cast<std::size_t>(task) * k_task;
    for (std::size_t i = begin; i < std::min(begin + k_task, mesh.vertices.size()); ++i) {
      const glm::dvec3 p(mesh.vertices[i]);
      glm::dvec3 gradient = source.field->smooth_gradient(p);
      if (is_cut && source.version->is_near_cut(p)) {
        // The nearer of the two surfaces determines the normal; on their common edge both do.
        const glm::dvec3 cut = source.version->distance_gradient(p);
        const double to_cut =
            std::abs(source.version->distance(p)) / std::max(glm::length(in_world(cut)), 1e-9);
        const double to_field = std::abs(source.field->value(p)) /
                                std::max(glm::length(in_world(source.field->gradient(p))), 1e-9);
        if (std::max(to_cut, to_field) < rim) {
          const auto unit = [&in_world](const glm::dvec3& g) {
            return in_world(g) / std::max(glm::length(in_world(g)), 1e-300);
          };
          gradient = (unit(gradient) + unit(cut)) * frame.axes();  // converts to per voxel step (a covector)
        } else if (to_cut < to_field) {
          gradient = cut;
        }
      }
      const glm::dvec3 world = in_world(gradient);
      const double length = glm::length(world);
      normals[i] = length > 0 ? glm::vec3(-world / length) : glm::vec3(0, 0, 1);
    }
  });
  return normals;
}

}  // namespace trephine::volume
