// One edge of a scan, fitted to the voxels about it: where it is, how high and how blurred.
#pragma once

#include <array>
#include <glm/geometric.hpp>
#include <optional>
#include <vector>

#include "data-tools/scan_quality.h"

namespace trephine::data_tools {

/// Gradient per mm of the world, by the neighbouring voxels.
glm::dvec3 gradient_at(const volume::Volume& v, const glm::ivec3& at);
/// The value that so large a share of them is below.
double share_of(std::vector<double> values, double share);

/// An edge through a patch of voxels: outside + step * normal integral of (place - at) / sigma, where places
/// count along the normal, and the edge may be bent like a ball.
struct Edge {
  double outside = 0, step = 0, at = 0, sigma = 0, bend = 0;
  glm::dvec3 normal{0.0};  ///< toward the inside

  double place(const glm::dvec3& p) const {
    const double along = glm::dot(p, normal);
    return along + 0.5 * bend * (glm::dot(p, p) - along * along) - at;
  }
};

class EdgeFit {
 public:
  /// Voxels about `at`, farther along the edge's normal than across it, of more than one slice.
  EdgeFit(const volume::Volume& v, const glm::ivec3& at, double in_plane, const glm::dvec3& slice_normal,
          double slice_step);
  /// Fits one edge, and says how well it describes these voxels.
  enum class Fit { none, rough, clean };
  Fit run(double noise, double least_step, Edge& edge) const;
  /// Some of the voxels, as shares of the edge's step.
  std::vector<ScanQuality::EdgePoint> laid_over(const Edge& edge) const;

 private:
  static constexpr std::size_t k_unknowns = 7, k_least_places = 30;
  using System = std::array<std::array<double, k_unknowns + 1>, k_unknowns>;
  using Unknowns = std::array<double, k_unknowns>;
  /// Is one side of the edge seen, and as even as noise lets it be? Layers below the skin, or diploe below a
  /// table, would make an edge look sharper than it is.
  bool is_level(const Edge& edge, int side, double noise) const;
  double squares(const Edge& edge) const;
  /// Change to the least squares, nearly: Gauss and Newton's step, damped. Its normal turns
  /// along u and w.
  std::optional<Unknowns> step_from(const Edge& edge, const glm::dvec3& u, const glm::dvec3& w,
                                    double damping) const;
  static std::optional<Unknowns> solve(System system);

  Edge first_;
  std::vector<glm::dvec3> places_;
  std::vector<double> values_;
};

}  // namespace trephine::data_tools
