// An independent judge of triangle meshes: closed, manifold, oriented, and how large a volume they bound.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <set>
#include <span>
#include <unordered_map>
#include <vector>

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

/// Does a way cross a mesh? Every triangle near it is asked, in extended precision; triangles are found by
/// the cubes that their boxes meet.
class MeshWall {
 public:
  /// In voxels: cubes of one.
  MeshWall(std::span<const glm::vec3> vertices, std::span<const std::uint32_t> triangles);
  MeshWall(std::span<const glm::dvec3> vertices, std::span<const std::uint32_t> triangles, double cube);
  bool is_crossed(const glm::dvec3& a, const glm::dvec3& b) const { return crossings(a, b) > 0; }
  /// Triangles that the way crosses.
  int crossings(const glm::dvec3& a, const glm::dvec3& b) const {
    return static_cast<int>(crossed(a, b).size());
  }
  /// Does the way cross a triangle from its front?
  bool is_entered(const glm::dvec3& a, const glm::dvec3& b) const;
  /// Is p inside the closed mesh? By the crossings of a way out.
  bool is_inside(const glm::dvec3& p) const;
  /// A place at which a way crosses the mesh: a share of the way, and the unit normal of the front there.
  struct Crossing {
    double at;
    glm::dvec3 normal;
  };
  /// All of them, by rising place; triangles that meet at one place are one.
  std::vector<Crossing> crossings_along(const glm::dvec3& a, const glm::dvec3& b) const;
  /// Is any triangle within `reach` of p?
  bool is_near(const glm::dvec3& p, double reach) const;
  /// Returns the signed distance from p to the closed mesh, positive outside; `reach` where no triangle is as
  /// near. The sign is that of the angle-weighted normal at the nearest place.
  double distance(const glm::dvec3& p, double reach) const;
  /// Returns the directions, unit, in which the triangles push a tool with its middle at p that are at most
  /// `slack` farther from p than the nearest one: away from their nearest places; of those that p lies on,
  /// their normals.
  std::vector<glm::dvec3> pushes_near(const glm::dvec3& p, double slack, double reach) const;

 private:
  /// Calls each(corner, corner, corner) for the triangles in the cubes within `reach` of p, some of them more
  /// than once. Ends when `each` returns true.
  template <class Each>
  void for_near(const glm::dvec3& p, double reach, const Each& each) const;
  std::set<std::uint32_t> crossed(const glm::dvec3& a, const glm::dvec3& b) const;

  std::vector<glm::dvec3> vertices_;
  std::vector<std::uint32_t> triangles_;
  double cube_;
  struct Near {
    std::uint32_t triangle, next;  ///< of the same cube
  };
  std::vector<Near> near_;
  std::unordered_map<std::uint64_t, std::uint32_t> newest_in_cube_;  ///< of near_
  double top_ = -1e300;
  glm::ivec3 first_cube_{0}, last_cube_{-1};  ///< with triangles
};

}  // namespace trephine::checker
