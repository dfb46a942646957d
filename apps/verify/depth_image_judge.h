// MovingModel: depth of a position in a moving model, for judges of depth images. The solid angles of the
// triangles determine whether the position is inside. behind_pixels(): depth of a position behind a depth
// image.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

namespace trephine::verify {

/// Closed model whose vertices move linearly from one key to the next. `beat`: time from key to key, s.
/// `is_repeating`: the first key follows the last one; otherwise the model stops at the last key.
class MovingModel {
 public:
  MovingModel(std::vector<std::vector<glm::dvec3>> keys, std::vector<std::uint32_t> triangles, double beat,
              bool is_repeating);
  /// Returns the depth of p (model frame) in matter at `time` (s), mm. If p is outside matter, returns the
  /// negative distance from p to matter.
  double depth(const glm::dvec3& p, double time) const;

 private:
  std::vector<std::vector<glm::dvec3>> keys_;
  std::vector<std::uint32_t> triangles_;
  double beat_;
  bool is_repeating_;
};

/// Returns the distance of a position behind a surface that four pixels around it show, mm. `z`: depth of the
/// position. The surface is somewhere between the four depths, so z is compared with the farthest one: a
/// position with a positive result is behind the surface, one with a negative result may be in front of it.
/// Returns NaN (unknown) at an outline, or if nothing was drawn.
double behind_pixels(const double (&depths)[4], double z);

}  // namespace trephine::verify
