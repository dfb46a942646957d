// Triangles in a tree of boxes: which one does a way meet first? In double precision throughout, so that a
// mesh may be in metres or have edges of 10 um, and watertight at edges and vertices.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "haptics/god_object.h"

namespace trephine::haptics {

/// Immutable but for refit(). Queries: any thread, no allocation.
class MeshTree {
 public:
  MeshTree() = default;
  /// Triangles look to the free side counter-clockwise. Degenerate ones are kept and never met. n log n.
  MeshTree(std::vector<glm::dvec3> vertices, std::vector<std::uint32_t> triangles);

  /// The same triangles at other places: boxes anew, the tree as it is. Not while others look.
  void refit(std::span<const glm::dvec3> vertices);

  /// The first triangle that the way a .. b meets on a side that holds; `looked`: triangles that were asked.
  bool cast(const glm::dvec3& a, const glm::dvec3& b, bool is_front, bool is_back, FacetHit& hit,
            int& looked) const noexcept;

  std::size_t triangle_count() const noexcept { return triangles_.size() / 3; }
  std::size_t bytes() const noexcept;
  /// mm that a god-object keeps from facets: a thousandth of the shortest edge, at most 1e-5, above rounding.
  double gap() const noexcept { return gap_; }

 private:
  struct Node {
    glm::dvec3 low, high;
    std::uint32_t first;  ///< of its triangles, or its second child (the first follows it)
    std::uint32_t count;  ///< of triangles; 0: an inner node
  };
  static constexpr std::uint32_t k_leaf = 4;
  static constexpr int k_deepest = 64;

  std::uint32_t build(std::uint32_t begin, std::uint32_t end, std::span<const glm::dvec3> centres,
                      std::vector<std::uint32_t>& order, int depth);
  void bound_leaf(Node& node) const;

  std::vector<glm::dvec3> vertices_;
  std::vector<std::uint32_t> triangles_;  ///< in the leaves' order
  std::vector<Node> nodes_;
  double gap_ = 1e-5;
};

}  // namespace trephine::haptics
