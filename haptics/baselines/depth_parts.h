// DepthParts: a concave object, divided into parts that six cameras see completely. This is the published
// solution for hidden surfaces (Kim et al. 2009: each object has its own workspace, and concave objects are
// decomposed).
#pragma once

#include "haptics/depth/depth_cube.h"

namespace trephine::haptics::baselines {

/// Boxes of a cube's lattice. A box is halved until no ray along at least one axis has more than one layer
/// of matter, or until it has one lattice point. Cameras on the faces of each box see only its contents.
/// Immutable when made; queries: any thread, no allocation, some 20 halvings, and three rays (twelve for
/// is_inside_smoothly()).
class DepthParts {
 public:
  /// Borrows the cube for this call only. Cost: n log n in its pixels.
  explicit DepthParts(const depth::DepthCube& cube);

  /// As DepthCube with Layers::outermost, but by the cameras of the box that contains p.
  bool is_inside(const depth::DepthCube& cube, const glm::dvec3& p) const noexcept;
  bool is_inside_smoothly(const depth::DepthCube& cube, const glm::dvec3& p) const noexcept;

  std::size_t count() const noexcept { return (nodes_.size() + 1) / 2; }
  std::size_t bytes() const noexcept { return nodes_.capacity() * sizeof(Node); }

 private:
  /// Lattice points, both ends included.
  struct Box {
    glm::ivec3 low, high;
  };
  struct Node {
    int axis = -1;             ///< the halved axis; -1: a part
    int split = 0;             ///< first lattice point of the second half
    std::uint32_t second = 0;  ///< node of the second half; the node of the first half follows its parent
  };
  void divide(const depth::DepthCube& cube, const Box& box);
  Box part_of(const glm::ivec3& size, const glm::ivec3& position) const noexcept;

  std::vector<Node> nodes_;
};

}  // namespace trephine::haptics::baselines
