// A concave thing as several parts, each of which six cameras see whole: the published way around what hides
// from them (Kim et al. 2009: a workspace for each object, concave objects decomposed).
#pragma once

#include "haptics/depth/depth_cube.h"

namespace trephine::haptics::depth {

/// Boxes of a cube's lattice, halved until along one axis at least no camera on a face finds anything behind
/// what it sees first. Cameras stand on the faces of each box and see what lies in it. Immutable when made;
/// queries: any thread, no allocation, some 20 halvings and three rays.
class DepthParts {
 public:
  /// Borrows the cube for this call alone. n log n in its pixels.
  explicit DepthParts(const DepthCube& cube);

  /// As DepthCube with Layers::outermost, but each place by the cameras of its own box.
  bool is_inside(const DepthCube& cube, const glm::dvec3& p) const noexcept;
  bool is_inside_smoothly(const DepthCube& cube, const glm::dvec3& p) const noexcept;

  std::size_t count() const noexcept { return (nodes_.size() + 1) / 2; }
  std::size_t bytes() const noexcept { return nodes_.capacity() * sizeof(Node); }

 private:
  /// Whole places, both ends within.
  struct Box {
    glm::ivec3 low, high;
  };
  struct Node {
    int axis = -1;             ///< that is halved; -1: a part
    int split = 0;             ///< the first place of the second half
    std::uint32_t second = 0;  ///< the first half follows its node
  };
  void divide(const DepthCube& cube, const Box& box);
  Box part_of(const glm::ivec3& size, const glm::ivec3& place) const noexcept;

  std::vector<Node> nodes_;
};

}  // namespace trephine::haptics::depth
