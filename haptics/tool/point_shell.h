// PointShell: surface of a rigid tool as points with inward normals, in a tree of bounding spheres.
#pragma once

#include <array>
#include <cstdint>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <span>
#include <vector>

#include "haptics/tool/tool_shape.h"
#include "volume/base/error.h"

namespace trephine::haptics {

/// Points of a closed surface (McNeely, Puterbaugh and Troy 1999), in the frame of the hand, mm. Corners and
/// sharp edges are sampled first, then faces by a Poisson disk pattern, in the same way on every machine.
/// Immutable; queries allocate nothing.
class PointShell {
 public:
  struct Point {
    glm::dvec3 position{0.0};  ///< mm
    glm::dvec3 inward{0.0};    ///< unit; the mean of the adjacent faces at edges and corners
    double area = 0;           ///< mm2 of the surface that is nearest to this point; 0 if areas are omitted
  };
  /// Node of the tree: bounding sphere of successive points. The points of an inner node are those of its
  /// child nodes.
  struct Node {
    glm::dvec3 centre{0.0};
    double radius = 0;                            ///< mm
    std::uint32_t begin = 0, end = 0;             ///< points
    std::uint32_t first_child = 0, children = 0;  ///< nodes; no children: a leaf
  };
  /// Mass distribution of the solid inside, for a density of 1 kg per mm3.
  struct Solid {
    double volume = 0;        ///< mm3
    glm::dvec3 centre{0.0};   ///< mm
    glm::dmat3 inertia{0.0};  ///< kg mm2, about the centre
  };
  static constexpr std::size_t k_max_points = 200'000;
  /// Whether points get areas, which doubles the time to sample the surface.
  enum class Areas : std::uint8_t { omitted, computed };
  static constexpr std::size_t k_leaf = 8, k_children = 8;
  /// Upper bound of the number of nodes that wait during a traversal.
  static constexpr std::size_t k_max_stack = 64;

  /// Samples a closed mesh whose triangles are counter-clockwise as viewed from outside. Every point of the
  /// surface is at most `spacing_mm` from a sample. Samples are at least half of `spacing_mm` apart, except
  /// at corners where sharp edges meet. Error if the mesh is open or empty, faces inward, or needs too many
  /// points. Cost: n log n for n candidates, about nine per point.
  static Result<SharedShell> of_mesh(std::span<const glm::dvec3> vertices,
                                     std::span<const std::uint32_t> triangles, double spacing_mm,
                                     Areas areas = Areas::omitted);
  /// Samples a body of revolution. Errors as of of_mesh() and check().
  static Result<SharedShell> of_profile(const ToolProfile& profile, Areas areas = Areas::omitted);
  /// Returns an error if the rings do not enclose a solid, or if its surface needs far too many points.
  static Status check(const ToolProfile& profile);

  /// Points in Morton order: neighbours in space are neighbours in the list.
  std::span<const Point> points() const noexcept { return points_; }
  /// The root is the last node.
  std::span<const Node> nodes() const noexcept { return nodes_; }
  const Node& root() const noexcept { return nodes_.back(); }
  double spacing() const noexcept { return spacing_; }  ///< mm
  double arm() const noexcept { return arm_; }          ///< mm, largest distance of a point from the HIP
  const Solid& solid() const noexcept { return solid_; }
  /// Hash of all points.
  std::uint64_t hash() const noexcept { return hash_; }

  /// Calls use(index) for each point, in increasing order, except those of nodes for which is_far(node)
  /// holds. `use` returns false to end the traversal.
  template <class IsFar, class Use>
  void visit(IsFar&& is_far, Use&& use) const noexcept {
    std::array<std::uint32_t, k_max_stack> stack;
    std::size_t depth = 0;
    stack[depth++] = static_cast<std::uint32_t>(nodes_.size() - 1);
    while (depth > 0) {
      const Node& node = nodes_[stack[--depth]];
      if (is_far(node)) continue;
      for (std::uint32_t c = node.children; c > 0; --c) stack[depth++] = node.first_child + c - 1;
      if (node.children > 0) continue;
      for (std::uint32_t i = node.begin; i < node.end; ++i)
        if (!use(i)) return;
    }
  }

 private:
  PointShell() = default;
  void build_tree();

  std::vector<Point> points_;
  std::vector<Node> nodes_;
  double spacing_ = 0, arm_ = 0;
  Solid solid_;
  std::uint64_t hash_ = 0;
};

}  // namespace trephine::haptics
