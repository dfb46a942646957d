#include "apps/verify/depth_image_judge.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <iterator>

namespace trephine::verify {

using glm::dvec3;

MovingModel::MovingModel(std::vector<std::vector<dvec3>> keys, std::vector<std::uint32_t> triangles,
                         double beat, bool is_repeating)
    : keys_(std::move(keys)), triangles_(std::move(triangles)), beat_(beat), is_repeating_(is_repeating) {}

double MovingModel::depth(const dvec3& p, double time) const {
  const auto count = static_cast<double>(keys_.size());
  double key = std::max(0.0, time / beat_);
  key = is_repeating_ ? std::fmod(key, count) : std::min(key, count - 1);
  const auto first = std::min(static_cast<std::size_t>(key), keys_.size() - 1);
  const std::size_t second = first + 1 < keys_.size() ? first + 1 : is_repeating_ ? 0 : first;
  const double share = key - static_cast<double>(first);
  const auto corner = [&](std::uint32_t v) {
    return (1 - share) * keys_[first][v] + share * keys_[second][v];
  };
  double solid_angle = 0, nearest = 1e300;
  for (std::size_t t = 0; t + 2 < triangles_.size(); t += 3) {
    const dvec3 a = corner(triangles_[t]) - p, b = corner(triangles_[t + 1]) - p,
                c = corner(triangles_[t + 2]) - p;
    // Van Oosterom and Strackee 1983.
    const double la = glm::length(a), lb = glm::length(b), lc = glm::length(c);
    solid_angle +=
        2 * std::atan2(glm::dot(a, glm::cross(b, c)),
                       la * lb * lc + glm::dot(a, b) * lc + glm::dot(b, c) * la + glm::dot(c, a) * lb);
    // Distance to the plane if p projects into the triangle, else to its sides.
    const dvec3 normal = glm::cross(b - a, c - a);
    const double size = glm::dot(normal, normal);
    const auto is_inside_side = [&](const dvec3& u, const dvec3& v) {
      return glm::dot(glm::cross(v - u, -u), normal) >= 0;
    };
    if (size > 0 && is_inside_side(a, b) && is_inside_side(b, c) && is_inside_side(c, a)) {
      nearest = std::min(nearest, std::abs(glm::dot(a, normal)) / std::sqrt(size));
      continue;
    }
    const auto to_side = [](const dvec3& u, const dvec3& v) {
      const dvec3 side = v - u;
      const double square = glm::dot(side, side);
      const double at = square > 0 ? std::clamp(-glm::dot(u, side) / square, 0.0, 1.0) : 0;
      return glm::length(u + at * side);
    };
    nearest = std::min({nearest, to_side(a, b), to_side(b, c), to_side(c, a)});
  }
  return std::abs(solid_angle) > 6.283185307179586 ? nearest : -nearest;
}

double behind_pixels(const double (&depths)[4], double z) {
  const auto [nearest, farthest] = std::minmax_element(std::begin(depths), std::end(depths));
  constexpr double k_outline = 5;  // mm, depth step at which pixels are on an outline
  if (*nearest <= 0 || *farthest - *nearest > k_outline) return std::nan("");
  return z - *farthest;
}

}  // namespace trephine::verify
