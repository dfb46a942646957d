#include "haptics/god_object.h"

namespace trephine::haptics {

using glm::dvec3;

dvec3 nearest_allowed(const dvec3& wish, const std::array<HoldingPlane, 3>& planes, int count) noexcept {
  const auto plane = [&](int i) -> const HoldingPlane& { return planes[static_cast<std::size_t>(i)]; };
  constexpr double k_slack = 1e-9;  // mm
  const auto is_allowed = [&](const dvec3& p) {
    for (int i = 0; i < count; ++i)
      if (glm::dot(plane(i).normal, p) < plane(i).offset - k_slack) return false;
    return true;
  };
  if (is_allowed(wish)) return wish;
  const auto missing = [&](int i) { return plane(i).offset - glm::dot(plane(i).normal, wish); };
  for (int i = count - 1; i >= 0; --i)
    if (const double m = missing(i); m > 0)
      if (const dvec3 p = wish + m * plane(i).normal; is_allowed(p)) return p;
  for (int i = count - 1; i >= 0; --i)
    for (int j = i - 1; j >= 0; --j) {
      const double c = glm::dot(plane(i).normal, plane(j).normal), s = 1 - c * c;
      if (s < 1e-12) continue;
      const double a = (missing(i) - c * missing(j)) / s, b = (missing(j) - c * missing(i)) / s;
      if (a < 0 || b < 0) continue;
      if (const dvec3 p = wish + a * plane(i).normal + b * plane(j).normal; is_allowed(p)) return p;
    }
  if (count == 3) {
    const dvec3 jk = glm::cross(plane(1).normal, plane(2).normal),
                ki = glm::cross(plane(2).normal, plane(0).normal),
                ij = glm::cross(plane(0).normal, plane(1).normal);
    const double volume = glm::dot(plane(0).normal, jk);
    if (std::abs(volume) > 1e-9)
      return (plane(0).offset * jk + plane(1).offset * ki + plane(2).offset * ij) / volume;
  }
  return wish + std::max(0.0, missing(count - 1)) * plane(count - 1).normal;
}

namespace {

bool is_before(const dvec3& a, const dvec3& b) noexcept {
  if (a.x != b.x) return a.x < b.x;
  if (a.y != b.y) return a.y < b.y;
  return a.z < b.z;
}

/// d . (p x q), rounded the same way whichever end of the edge is named first.
double edge_function(const dvec3& d, const dvec3& p, const dvec3& q) noexcept {
  return is_before(p, q) ? glm::dot(d, glm::cross(p, q)) : -glm::dot(d, glm::cross(q, p));
}

}  // namespace

bool crosses_triangle(const dvec3& a, const dvec3& d, const dvec3& v0, const dvec3& v1, const dvec3& v2,
                      double& t, double& facing) noexcept {
  const dvec3 p = v0 - a, q = v1 - a, r = v2 - a;
  const double u = edge_function(d, q, r), v = edge_function(d, r, p), w = edge_function(d, p, q);
  if ((u < 0 || v < 0 || w < 0) && (u > 0 || v > 0 || w > 0)) return false;
  const dvec3 normal = glm::cross(v1 - v0, v2 - v0);
  facing = glm::dot(d, normal);
  if (facing == 0) return false;
  t = glm::dot(p, normal) / facing;
  return t >= 0 && t <= 1;
}

}  // namespace trephine::haptics
