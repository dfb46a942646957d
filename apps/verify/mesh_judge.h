// judge_mesh(), MeshWall: independent judges of triangle meshes and of paths that cross them.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <set>
#include <span>
#include <unordered_map>
#include <vector>

namespace trephine::verify {

struct MeshVerdict {
  std::size_t boundary_edges = 0;        ///< edges of only one triangle
  std::size_t non_manifold_edges = 0;    ///< edges of more than two triangles
  std::size_t twisted_edges = 0;         ///< edges that two triangles use in the same direction
  std::size_t pinched_vertices = 0;      ///< the triangles around the vertex do not form one fan
  std::size_t degenerate_triangles = 0;  ///< triangles with two equal indices
  double signed_volume = 0;              ///< enclosed volume, positive when oriented outward
  bool is_closed_manifold() const {
    return boundary_edges + non_manifold_edges + twisted_edges + pinched_vertices + degenerate_triangles == 0;
  }
};
/// Checks that a mesh is closed, manifold and oriented, and computes its volume.
MeshVerdict judge_mesh(std::span<const glm::vec3> vertices, std::span<const std::uint32_t> triangles);

/// Finds the triangles of a mesh that a segment crosses. Every triangle near the segment is tested in
/// extended precision; triangles are found by the cubes that their boxes meet.
class MeshWall {
 public:
  /// Vertices in voxels, with cubes of one voxel.
  MeshWall(std::span<const glm::vec3> vertices, std::span<const std::uint32_t> triangles);
  /// `cube`: edge of the cubes, in the units of the vertices.
  MeshWall(std::span<const glm::dvec3> vertices, std::span<const std::uint32_t> triangles, double cube);
  bool is_crossed(const glm::dvec3& a, const glm::dvec3& b) const { return crossings(a, b) > 0; }
  /// Returns the number of triangles that the segment crosses.
  int crossings(const glm::dvec3& a, const glm::dvec3& b) const {
    return static_cast<int>(crossed(a, b).size());
  }
  /// Returns true if the segment crosses a triangle from its front.
  bool is_entered(const glm::dvec3& a, const glm::dvec3& b) const;
  /// Returns true if p is inside the closed mesh, by the crossings of a segment to the outside.
  bool is_inside(const glm::dvec3& p) const;
  /// Crossing of a segment with the mesh: share of the segment, and unit normal of the front there.
  struct Crossing {
    double at;
    glm::dvec3 normal;
  };
  /// Returns all crossings in order. Crossings at one position in the same direction count once, as at an
  /// edge between two triangles.
  std::vector<Crossing> crossings_along(const glm::dvec3& a, const glm::dvec3& b) const;
  /// Returns true if a triangle is within `reach` of p.
  bool is_near(const glm::dvec3& p, double reach) const;
  /// Returns the signed distance from p to the closed mesh, positive outside; `reach` if no triangle is
  /// within `reach`. The angle-weighted normal at the nearest point determines the sign.
  double distance(const glm::dvec3& p, double reach) const;
  /// Returns the unit directions in which triangles push a tool with its centre at p: away from the nearest
  /// point of the triangle, or along its normal if p is on it. Includes triangles that are at most `slack`
  /// farther from p than the nearest triangle. `reach`: distance within which triangles are searched.
  std::vector<glm::dvec3> pushes_near(const glm::dvec3& p, double slack, double reach) const;

 private:
  /// Calls each(i), with i the index of a triangle's first corner in `triangles_`, for the triangles in the
  /// cubes within `reach` of p, some of them more than once. Ends when `each` returns true.
  template <class Each>
  void for_near(const glm::dvec3& p, double reach, const Each& each) const;
  std::set<std::uint32_t> crossed(const glm::dvec3& a, const glm::dvec3& b) const;

  std::vector<glm::dvec3> vertices_;
  std::vector<std::uint32_t> triangles_;
  double cube_;
  struct Near {
    std::uint32_t triangle, next;  ///< next: entry of near_ in the same cube
  };
  std::vector<Near> near_;
  std::unordered_map<std::uint64_t, std::uint32_t> newest_in_cube_;  ///< indices in near_
  double top_ = -1e300;
  glm::ivec3 first_cube_{0}, last_cube_{-1};  ///< range of the cubes with triangles
};

}  // namespace trephine::verify
