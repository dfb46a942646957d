#include "haptics/mesh/god_object.h"

#include <glm/common.hpp>

namespace trephine::haptics {

using glm::dvec3;

dvec3 nearest_allowed(const dvec3& target, const std::array<HoldingPlane, 3>& planes, int count) noexcept {
  const auto plane = [&](int i) -> const HoldingPlane& { return planes[static_cast<std::size_t>(i)]; };
  constexpr double k_slack = 1e-9;  // mm
  const auto is_allowed = [&](const dvec3& p) {
    for (int i = 0; i < count; ++i)
      if (glm::dot(plane(i).normal, p) < plane(i).offset - k_slack) return false;
    return true;
  };
  if (is_allowed(target)) return target;
  const auto deficit = [&](int i) { return plane(i).offset - glm::dot(plane(i).normal, target); };
  for (int i = count - 1; i >= 0; --i)
    if (const double m = deficit(i); m > 0)
      if (const dvec3 p = target + m * plane(i).normal; is_allowed(p)) return p;
  for (int i = count - 1; i >= 0; --i)
    for (int j = i - 1; j >= 0; --j) {
      const double c = glm::dot(plane(i).normal, plane(j).normal), s = 1 - c * c;
      if (s < 1e-12) continue;
      const double a = (deficit(i) - c * deficit(j)) / s, b = (deficit(j) - c * deficit(i)) / s;
      if (a < 0 || b < 0) continue;
      if (const dvec3 p = target + a * plane(i).normal + b * plane(j).normal; is_allowed(p)) return p;
    }
  if (count == 3) {
    const dvec3 jk = glm::cross(plane(1).normal, plane(2).normal),
                ki = glm::cross(plane(2).normal, plane(0).normal),
                ij = glm::cross(plane(0).normal, plane(1).normal);
    const double volume = glm::dot(plane(0).normal, jk);
    if (std::abs(volume) > 1e-9)
      return (plane(0).offset * jk + plane(1).offset * ki + plane(2).offset * ij) / volume;
  }
  return target + std::max(0.0, deficit(count - 1)) * plane(count - 1).normal;
}

namespace {

/// Sets `high` to the rounded product a b, and `low` to its rounding error (Dekker 1971). Coordinates of
/// points are too small for an overflow.
void exact_product(double a, double b, double& high, double& low) noexcept {
  constexpr double k_split = 134217729;  // 2^27 + 1
  high = a * b;
  const double ta = k_split * a, tb = k_split * b;
  const double ah = ta - (ta - a), al = a - ah, bh = tb - (tb - b), bl = b - bh;
  low = ((ah * bh - high) + ah * bl + al * bh) + al * bl;
}

}  // namespace

double exact_determinant(double a, double b, double c, double d) noexcept {
  double p, pe, q, qe;
  exact_product(a, b, p, pe);
  exact_product(c, d, q, qe);
  return (p - q) + (pe - qe);
}

}  // namespace trephine::haptics
