#include "haptics/proxy/wall_steps.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <utility>

namespace trephine::haptics {

using glm::dvec3;

namespace {

constexpr double k_min_hessian =
    0.25;  // least eigenvalue of the reduced Hessian; below it a step would diverge

}  // namespace

/// Uses the formula of Duff et al. 2017.
void tangents(const dvec3& n, dvec3& u, dvec3& w) noexcept {
  const double sign = n.z >= 0 ? 1.0 : -1.0;
  const double a = -1 / (sign + n.z), b = n.x * n.y * a;
  u = {1 + sign * n.x * n.x * a, sign * b, -sign * n.x};
  w = {b, sign + n.y * n.y * a, -n.y};
}

dvec3 single_step(const volume::Frame& frame, double voxel_mm, const Plane& plane,
                  const dvec3& to_hip) noexcept {
  const dvec3& n = plane.normal;
  dvec3 u, w;
  tangents(n, u, w);
  const double hip_u = glm::dot(to_hip, u), hip_w = glm::dot(to_hip, w);
  if (plane.is_frozen) return plane.distance * n + hip_u * u + hip_w * w;
  const double inverse = 1 / plane.steepness;
  const double lambda = inverse * std::max(0.0, glm::dot(to_hip, n) - plane.distance);
  const dvec3 u_voxel = frame.vector_volume_from_world(u), w_voxel = frame.vector_volume_from_world(w);
  const dvec3 n_voxel = frame.vector_volume_from_world(n);
  const dvec3 hessian_u = plane.jet.hessian_times(u_voxel), hessian_w = plane.jet.hessian_times(w_voxel);
  const double uu = glm::dot(hessian_u, u_voxel), uw = glm::dot(hessian_u, w_voxel),
               ww = glm::dot(hessian_w, w_voxel);
  const double un = glm::dot(hessian_u, n_voxel), wn = glm::dot(hessian_w, n_voxel);
  double a = 1 + lambda * uu, c = 1 + lambda * ww;
  const double b = lambda * uw;
  if (a < k_min_hessian || c < k_min_hessian || (a - k_min_hessian) * (c - k_min_hessian) < b * b) {
    const double half = 0.5 * (a - c), least = 0.5 * (a + c) - std::sqrt(half * half + b * b);
    a += k_min_hessian - least;
    c += k_min_hessian - least;
  }
  const double ru = hip_u - lambda * plane.distance * un, rw = hip_w - lambda * plane.distance * wn;
  const double inverse_determinant = 1 / (a * c - b * b);
  const double pu = inverse_determinant * (c * ru - b * rw), pw = inverse_determinant * (a * rw - b * ru);
  const dvec3 p = plane.distance * n + pu * u + pw * w;
  // A long step ends on the tangent plane; a short one follows the wall to second order.
  if (const double max_step = k_short_step * voxel_mm; pu * pu + pw * pw > max_step * max_step) return p;
  return p - inverse *
                 (0.5 * (pu * pu * uu + pw * pw * ww) + pu * pw * uw + plane.distance * (pu * un + pw * wn)) *
                 n;
}

dvec3 joint_step(const volume::Frame& frame, double voxel_mm, const Planes& planes,
                 const dvec3& to_hip) noexcept {
  const int count = planes.count;
  const auto at = [&](int i) -> const Plane& { return planes[i]; };
  const double tolerance = 1e-9 * voxel_mm;
  const auto is_kept = [&](const dvec3& p) {
    for (int k = 0; k < count; ++k)
      if (glm::dot(at(k).normal, p) > at(k).distance + tolerance) return false;
    return true;
  };
  for (int i = 0; i < count; ++i) {
    if (glm::dot(to_hip, at(i).normal) <= at(i).distance) continue;
    const dvec3 p = single_step(frame, voxel_mm, at(i), to_hip);
    if (is_kept(p)) return p;
  }
  dvec3 spare = at(0).distance * at(0).normal;
  for (int i = 0; i < count; ++i)
    for (int j = i + 1; j < count; ++j) {
      const dvec3 &m = at(i).normal, &n = at(j).normal;
      const double c = glm::dot(m, n), s = 1 - c * c;
      if (s < 1e-8) continue;
      const auto coefficients = [&](double a, double b) { return (a - c * b) / s * m + (b - c * a) / s * n; };
      const double ri = glm::dot(to_hip, m) - at(i).distance, rj = glm::dot(to_hip, n) - at(j).distance;
      const double pull_i = (ri - c * rj) / s, pull_j = (rj - c * ri) / s;
      if (pull_i < 0 || pull_j < 0) continue;
      const dvec3 e = glm::cross(m, n) / std::sqrt(s), e_voxel = frame.vector_volume_from_world(e);
      double curvature = 1;
      for (const auto& [pull, k] : {std::pair(pull_i, i), std::pair(pull_j, j)})
        if (!at(k).is_frozen)
          curvature += pull / at(k).steepness * glm::dot(at(k).jet.hessian_times(e_voxel), e_voxel);
      const dvec3 base = coefficients(at(i).distance, at(j).distance);
      const dvec3 p = base + glm::dot(to_hip, e) / std::max(k_min_hessian, curvature) * e;
      if (is_kept(p)) return p;
      spare = base;
    }
  // A step that follows the curvature of one wall may lead into another wall. A straight step may avoid that
  // wall.
  for (int i = 0; i < count; ++i) {
    const dvec3& n = at(i).normal;
    const double into = glm::dot(to_hip, n);
    if (into <= at(i).distance) continue;
    const dvec3 p = to_hip + (at(i).distance - into) * n;
    if (is_kept(p)) return p;
  }
  for (int i = 0; i < count; ++i)
    for (int j = i + 1; j < count; ++j)
      for (int k = j + 1; k < count; ++k) {
        const dvec3 ij = glm::cross(at(i).normal, at(j).normal), jk = glm::cross(at(j).normal, at(k).normal),
                    ki = glm::cross(at(k).normal, at(i).normal);
        const double volume = glm::dot(at(i).normal, jk);
        if (std::abs(volume) < 1e-8) continue;
        const dvec3 p = (at(i).distance * jk + at(j).distance * ki + at(k).distance * ij) / volume;
        if (is_kept(p)) return p;
      }
  return spare;
}

dvec3 step_to_walls(const Planes& planes) noexcept {
  dvec3 p = planes[0].distance * planes[0].normal;
  for (int k = 1; k < planes.count; ++k)
    p += std::min(0.0, planes[k].distance - glm::dot(planes[k].normal, p)) * planes[k].normal;
  return p;
}

}  // namespace trephine::haptics
