#include "apps/verify/ideal_proxy.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <vector>

namespace trephine::verify {

using glm::dvec3;

namespace {

/// Tangent plane of the wall near the proxy: free where normal . p >= offset.
struct TangentPlane {
  dvec3 normal;
  double offset;
};

/// Sets `nearest` to the point nearest to `target` among the points on all given planes. Returns false if the
/// directions of the planes hardly differ.
bool nearest_on(const std::vector<TangentPlane>& planes, const dvec3& target, dvec3& nearest) {
  const auto gap = [&](const TangentPlane& s) { return s.offset - glm::dot(s.normal, target); };
  if (planes.size() == 1) {
    nearest = target + gap(planes[0]) * planes[0].normal;
    return true;
  }
  const double c = glm::dot(planes[0].normal, planes[1].normal), determinant = 1 - c * c;
  if (determinant < 1e-6) return false;
  if (planes.size() == 2) {
    const double a = (gap(planes[0]) - c * gap(planes[1])) / determinant,
                 b = (gap(planes[1]) - c * gap(planes[0])) / determinant;
    nearest = target + a * planes[0].normal + b * planes[1].normal;
    return true;
  }
  const glm::dmat3 rows = glm::transpose(glm::dmat3(planes[0].normal, planes[1].normal, planes[2].normal));
  if (std::abs(glm::determinant(rows)) < 1e-4) return false;
  nearest = glm::inverse(rows) * dvec3(planes[0].offset, planes[1].offset, planes[2].offset);
  return true;
}

class Wall {
 public:
  Wall(const Clearance& clearance, double step) : clearance_(clearance), step_(step) {}
  /// Returns the resting point downhill from a free position.
  dvec3 settle(dvec3 at, const dvec3& hip) const;
  /// Returns p, moved out of the wall.
  dvec3 move_out(dvec3 p) const;

 private:
  /// Returns the last point from a to b up to which the segment is free.
  dvec3 advance(const dvec3& a, const dvec3& b) const;
  bool is_free(const dvec3& a, const dvec3& b) const;
  dvec3 gradient(const dvec3& p, double h) const;

  const Clearance& clearance_;
  double step_;
};

dvec3 Wall::gradient(const dvec3& p, double h) const {
  const auto along = [&](const dvec3& e) {
    return (clearance_(p + h * e) - clearance_(p - h * e)) / (2 * h);
  };
  return {along({1, 0, 0}), along({0, 1, 0}), along({0, 0, 1})};
}

bool Wall::is_free(const dvec3& a, const dvec3& b) const {
  const int parts = std::max(1, static_cast<int>(std::ceil(4 * glm::length(b - a) / step_)));
  for (int i = 1; i <= parts; ++i)
    if (clearance_(a + (static_cast<double>(i) / parts) * (b - a)) < 0) return false;
  return true;
}

dvec3 Wall::advance(const dvec3& a, const dvec3& b) const {
  const int parts = std::max(1, static_cast<int>(std::ceil(4 * glm::length(b - a) / step_)));
  dvec3 last = a;
  for (int i = 1; i <= parts; ++i) {
    const dvec3 next = a + (static_cast<double>(i) / parts) * (b - a);
    if (clearance_(next) >= 0) {
      last = next;
      continue;
    }
    double free = 0, blocked = 1;
    for (int k = 0; k < 24; ++k) {
      const double middle = 0.5 * (free + blocked);
      (clearance_(last + middle * (next - last)) >= 0 ? free : blocked) = middle;
    }
    return last + free * (next - last);
  }
  return b;
}

dvec3 Wall::settle(dvec3 at, const dvec3& hip) const {
  at = advance(at, hip);
  double reach = 0.5 * step_;
  for (int round = 0; round < 400 && reach > 2e-5 * step_; ++round) {
    const dvec3 rest = hip - at;
    if (glm::dot(rest, rest) < 1e-20) break;
    // Sides of the wall within reach, from its slopes at seven points.
    std::array<TangentPlane, 7> planes;
    std::size_t count = 0;
    const double h = 0.05 * reach;
    for (int i = 0; i < 7; ++i) {
      dvec3 point = at;
      if (i > 0) point[(i - 1) / 2] += (i % 2 ? 1 : -1) * 0.5 * reach;
      const dvec3 g = gradient(point, h);
      const double steepness = glm::length(g);
      if (!(steepness > 1e-9)) continue;
      const dvec3 n = g / steepness;
      if (std::any_of(planes.begin(), planes.begin() + static_cast<std::ptrdiff_t>(count),
                      [&](const TangentPlane& s) { return glm::dot(s.normal, n) > 0.9999995; }))
        continue;
      planes[count++] = {n, glm::dot(n, point) - clearance_(point) / steepness};
    }
    dvec3 best = at;
    const auto energy = [&](const dvec3& p) { return glm::dot(hip - p, hip - p); };
    const auto consider = [&](dvec3 to) {
      const double length = glm::length(to - at);
      if (!(length > 0)) return;
      if (length > reach) to = at + (reach / length) * (to - at);
      // Move out of the wall again, where it bends toward the proxy.
      for (int i = 0; i < 4 && clearance_(to) < 0; ++i) {
        const dvec3 g = gradient(to, h);
        const double square = glm::dot(g, g);
        if (!(square > 1e-18)) return;
        to += (1e-7 * step_ / std::sqrt(square) - clearance_(to) / square) * g;
      }
      if (energy(to) < energy(best) && is_free(at, to)) best = to;
    };
    consider(hip);
    for (std::size_t i = 0; i < count; ++i) {
      dvec3 to;
      if (nearest_on({planes[i]}, hip, to)) consider(to);
      for (std::size_t j = i + 1; j < count; ++j) {
        if (nearest_on({planes[i], planes[j]}, hip, to)) consider(to);
        for (std::size_t k = j + 1; k < count; ++k)
          if (nearest_on({planes[i], planes[j], planes[k]}, hip, to)) consider(to);
      }
    }
    const double gained = glm::length(best - at);
    at = best;
    if (gained < 0.25 * reach) reach *= 0.5;
  }
  return at;
}

dvec3 Wall::move_out(dvec3 p) const {
  // Move at most one step at a time, because deep in uniform matter the slopes are rounding errors.
  for (int i = 0; i < 60 && clearance_(p) < 0; ++i) {
    const dvec3 g = gradient(p, 1e-4 * step_);
    const dvec3 out = (1e-7 * step_ - clearance_(p) / std::max(1e-18, glm::dot(g, g))) * g;
    const double length = glm::length(out);
    p += length > step_ ? (step_ / length) * out : out;
  }
  return p;
}

}  // namespace

dvec3 follow_exactly(const Clearance& clearance, double step, dvec3 proxy, const dvec3& hip_from,
                     const dvec3& hip_to) {
  const Wall wall(clearance, step);
  proxy = wall.move_out(proxy);
  const int parts = std::max(1, static_cast<int>(std::ceil(glm::length(hip_to - hip_from) / step)));
  for (int i = 1; i <= parts; ++i)
    proxy = wall.settle(
        proxy, i == parts ? hip_to : hip_from + (static_cast<double>(i) / parts) * (hip_to - hip_from));
  return proxy;
}

}  // namespace trephine::verify
