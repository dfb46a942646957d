// Is a place within what is drawn at a moment, and how deep? By solid angles over all of its triangles, or by
// the four pixels around it: no image, no net, no tree.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

namespace trephine::checker {

/// A closed model that goes straight from key to key, a beat each.
class MovingModel {
 public:
  MovingModel(std::vector<std::vector<glm::dvec3>> keys, std::vector<std::uint32_t> triangles, double beat,
              bool is_repeating);
  /// mm that p (its frame) lies within matter; below 0 it is free, by at least that.
  double depth(const glm::dvec3& p, double time) const;

 private:
  std::vector<std::vector<glm::dvec3>> keys_;
  std::vector<std::uint32_t> triangles_;
  double beat_;
  bool is_repeating_;
};

/// mm that z lies behind the surface that four pixels around it show, which is between their depths: behind
/// the farthest of them; below 0 it may be free. NaN: at an outline, or where nothing was seen, nobody knows.
double behind_pixels(const double (&depths)[4], double z);

}  // namespace trephine::checker
