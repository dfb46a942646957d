// EdgeFit: fits position, height and blur of one edge of a scan to the surrounding voxels.
#pragma once

#include <array>
#include <glm/geometric.hpp>
#include <optional>
#include <vector>

#include "data-tools/quality/scan_quality.h"

namespace trephine::data_tools {

/// Returns the gradient in the world frame, per mm: central differences of the neighbouring voxels.
glm::dvec3 gradient_at(const volume::Volume& v, const glm::ivec3& at);
/// Returns the quantile: the value below which `share` (0 to 1) of the values are.
double quantile(std::vector<double> values, double share);

/// A blurred edge through a patch of voxels: outside + step * Phi(distance / sigma), where Phi is the normal
/// integral and distance is measured from the edge along its normal. The edge may be curved like a sphere.
struct Edge {
  /// Intensities `outside` and `step`, position `at` (mm along the normal), `sigma` (mm), curvature `bend`
  /// (1/mm).
  double outside = 0, step = 0, at = 0, sigma = 0, bend = 0;
  glm::dvec3 normal{0.0};  ///< unit vector toward the inside, world frame

  /// Signed distance from the edge, mm, positive inside; `p` relative to the patch's centre, mm.
  double signed_distance(const glm::dvec3& p) const {
    const double along = glm::dot(p, normal);
    return along + 0.5 * bend * (glm::dot(p, p) - along * along) - at;
  }
};

/// Fits an edge to the voxels around one voxel.
class EdgeFit {
 public:
  /// Collects the voxels around `at`, from more than one slice: up to 4 voxels away along the edge's normal,
  /// and at most 2.5 voxels, or as far as the next slice, across the normal. `in_plane`: voxel spacing within
  /// a slice, mm; `slice_step`: mm between slices.
  EdgeFit(const volume::Volume& v, const glm::ivec3& at, double in_plane, const glm::dvec3& slice_normal,
          double slice_step);
  /// Quality of a fit: rough if residuals or uneven sides exceed what noise explains.
  enum class Fit { none, rough, clean };
  /// Fits one edge and rates the fit. `noise` (a sigma) and `min_step` (least step of the edge) are
  /// intensities.
  Fit run(double noise, double min_step, Edge& edge) const;
  /// Returns every seventh voxel as distance from the edge (mm) and share of its step.
  std::vector<ScanQuality::EdgePoint> superimposed_points(const Edge& edge) const;

 private:
  static constexpr std::size_t k_unknowns = 7, k_min_voxels = 30;
  using System = std::array<std::array<double, k_unknowns + 1>, k_unknowns>;
  using Unknowns = std::array<double, k_unknowns>;
  /// Returns true if one side of the edge (-1 or 1) is sampled and as even as noise permits. Layers below the
  /// skin, or diploe below a table, would make an edge appear sharper than it is.
  bool is_level(const Edge& edge, int side, double noise) const;
  /// Returns the sum of squared residuals.
  double squares(const Edge& edge) const;
  /// Returns the damped Gauss-Newton step toward the least sum of squares; the normal turns along u and w.
  /// Empty if the equations are singular.
  std::optional<Unknowns> step_from(const Edge& edge, const glm::dvec3& u, const glm::dvec3& w,
                                    double damping) const;
  static std::optional<Unknowns> solve(System system);

  Edge initial_;
  std::vector<glm::dvec3> offsets_;  ///< from the central voxel, mm, world axes
  std::vector<double> values_;
};

}  // namespace trephine::data_tools
