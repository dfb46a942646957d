// MovingModel: depth of a position in a drawn model, from the solid angles of its triangles. behind_pixels():
// depth of a position behind a depth image.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

namespace trephine::verify {

/// Closed model that moves linearly from key to key, in one `beat` each, s.
class MovingModel {
 public:
  MovingModel(std::vector<std::vector<glm::dvec3>> keys, std::vector<std::uint32_t> triangles, double beat,
              bool is_repeating);
  /// Returns the depth of p (model frame) in matter at `time` (s), mm. If p is free: minus its distance from
  /// matter.
  double depth(const glm::dvec3& p, double time) const;

 private:
  std::vector<std::vector<glm::dvec3>> keys_;
  std::vector<std::uint32_t> triangles_;
  double beat_;
  bool is_repeating_;
};

/// Returns the distance of z behind the surface that the four pixels around it show, mm. The surface is
/// between their depths: z is compared with the farthest, and may be free if the result is negative. NaN
/// (unknown) at an outline, or where nothing was drawn.
double behind_pixels(const double (&depths)[4], double z);

}  // namespace trephine::verify
