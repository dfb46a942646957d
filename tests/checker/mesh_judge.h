// An independent judge of triangle meshes: closed, manifold, oriented, and how large a volume they bound.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>

namespace trephine::checker {

struct MeshVerdict {
  std::size_t boundary_edges = 0;        ///< used by one triangle
  std::size_t crowded_edges = 0;         ///< used by more than two
  std::size_t twisted_edges = 0;         ///< used twice in the same direction
  std::size_t pinched_vertices = 0;      ///< triangles around it do not form one fan
  std::size_t degenerate_triangles = 0;  ///< two equal indices
  double signed_volume = 0;              ///< positive when oriented outward
  bool is_closed_manifold() const {
    return boundary_edges + crowded_edges + twisted_edges + pinched_vertices + degenerate_triangles == 0;
  }
};
MeshVerdict judge_mesh(std::span<const glm::vec3> vertices, std::span<const std::uint32_t> triangles);

}  // namespace trephine::checker
