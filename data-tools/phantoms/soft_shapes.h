// Signed distances (mm, negative inside) for anatomical phantoms, their blends, and Brush, which paints
// intensities. Points are in the frame of the phantom's reference anatomy, mm. The distances are first-order
// estimates, whose zero surface is exact.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "volume/base/deterministic_math.h"

namespace trephine::data_tools {

inline double ellipsoid(const glm::dvec3& p, const glm::dvec3& radii) {
  const double k = glm::length(p / radii), slope = glm::length(p / (radii * radii));
  return slope > 1e-12 ? k * (k - 1) / slope : -std::min({radii.x, radii.y, radii.z});
}
/// Elliptic cylinder along z.
inline double elliptic_cylinder(double x, double y, double rx, double ry) {
  const double kx = x / rx, ky = y / ry, k = std::sqrt(kx * kx + ky * ky);
  const double slope = std::sqrt(kx * kx / (rx * rx) + ky * ky / (ry * ry));
  return slope > 1e-12 ? k * (k - 1) / slope : -std::min(rx, ry);
}
inline double capsule(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& b, double ra, double rb) {
  const glm::dvec3 ab = b - a;
  const double t = std::clamp(glm::dot(p - a, ab) / glm::dot(ab, ab), 0.0, 1.0);
  return glm::length(p - a - t * ab) - (ra + t * (rb - ra));
}
/// Union with a fillet of radius k.
inline double blend(double a, double b, double k) {
  const double h = std::max(k - std::abs(a - b), 0.0) / k;
  return std::min(a, b) - h * h * k * 0.25;
}
inline double carve(double solid, double hole, double k) { return -blend(-solid, hole, k); }

/// A smooth wave of amplitude 1, different along each axis.
inline double wave(const glm::dvec3& p, double period) {
  const double s = 6.283185307179586 / period;
  return deterministic_sin(s * p.x + 1.3) * deterministic_sin(s * p.y * 0.87 + 0.4) *
         deterministic_sin(s * p.z * 1.13 + 2.1);
}

/// Intensity of a point, painted layer over layer. A layer's share of a voxel changes smoothly over about two
/// voxels.
class Brush {
 public:
  Brush(double hounsfield, double voxel_mm) : hounsfield_(hounsfield), edge_(1.7 * std::max(voxel_mm, 0.2)) {}
  /// Paints a layer; `s`: signed distance to it, mm. Returns true if the layer has the larger share.
  bool paint(double s, double hounsfield) {
    const double x = std::clamp(0.5 - s / edge_, 0.0, 1.0), share = x * x * (3 - 2 * x);
    hounsfield_ += share * (hounsfield - hounsfield_);
    return share >= 0.5;
  }
  double hounsfield() const { return hounsfield_; }
  double edge() const { return edge_; }  ///< width of the soft border, mm

 private:
  double hounsfield_, edge_;
};

}  // namespace trephine::data_tools
