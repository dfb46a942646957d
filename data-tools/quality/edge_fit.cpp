#include "data-tools/quality/edge_fit.h"

#include <algorithm>
#include <cmath>

namespace trephine::data_tools {

using glm::dvec3;
using volume::Volume;

namespace {
constexpr double k_root_2 = 1.4142135623730951, k_root_2_pi = 2.5066282746310002;
}

dvec3 gradient_at(const Volume& v, const glm::ivec3& at) {
  dvec3 slope;
  for (int a = 0; a < 3; ++a) {
    glm::ivec3 step(0);
    step[a] = 1;
    slope[a] = 0.5 * (v.voxels[v.index(at.x + step.x, at.y + step.y, at.z + step.z)] -
                      v.voxels[v.index(at.x - step.x, at.y - step.y, at.z - step.z)]);
  }
  return v.frame.gradient_world_from_volume(slope);
}

double quantile(std::vector<double> values, double share) {
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

EdgeFit::EdgeFit(const Volume& v, const glm::ivec3& at, double in_plane, const dvec3& slice_normal,
                 double slice_step) {
  const dvec3 gradient = gradient_at(v, at);
  if (!(glm::length(gradient) > 0)) return;
  initial_.normal = glm::normalize(gradient);
  double voxel = 0;  // along the normal
  for (int a = 0; a < 3; ++a) voxel += std::abs(glm::dot(initial_.normal, v.frame.axes()[a]));
  const double longest = 4.0 * voxel, wide = 2.5 * in_plane, tall = std::max(wide, 1.2 * slice_step);
  // Change of each voxel index per mm of the world.
  glm::dmat3 index_of_mm;
  for (int a = 0; a < 3; ++a) {
    dvec3 unit(0);
    unit[a] = 1;
    index_of_mm[a] = v.frame.vector_volume_from_world(unit);
  }
  glm::ivec3 reach;
  for (int a = 0; a < 3; ++a) {
    const dvec3 row(index_of_mm[0][a], index_of_mm[1][a], index_of_mm[2][a]);
    const double along = glm::dot(row, initial_.normal);
    reach[a] =
        static_cast<int>(longest * std::abs(along) + tall * glm::length(row - along * initial_.normal));
  }
  for (int z = -reach.z; z <= reach.z; ++z)
    for (int y = -reach.y; y <= reach.y; ++y)
      for (int x = -reach.x; x <= reach.x; ++x) {
        const dvec3 offset = v.frame.vector_world_from_volume(dvec3(x, y, z));
        const double along = glm::dot(offset, initial_.normal);
        const dvec3 tangential = offset - along * initial_.normal;
        const double up = glm::dot(tangential, slice_normal),
                     flat2 = glm::dot(tangential, tangential) - up * up;
        if (std::abs(along) > longest || flat2 / (wide * wide) + up * up / (tall * tall) > 1) continue;
        const glm::ivec3 p = at + glm::ivec3(x, y, z);
        if (!v.contains(p)) continue;
        offsets_.push_back(offset);
        values_.push_back(v.voxels[v.index(p.x, p.y, p.z)]);
      }
  if (offsets_.size() < k_min_voxels) return;
  initial_.outside = quantile(values_, 0.05);
  initial_.step = quantile(values_, 0.95) - initial_.outside;
  initial_.sigma = 0.8 * voxel;
}

EdgeFit::Fit EdgeFit::run(double noise, double min_step, Edge& edge) const {
  if (offsets_.size() < k_min_voxels || !(initial_.step > min_step)) return Fit::none;
  edge = initial_;
  // Levenberg-Marquardt iteration.
  double damping = 1e-3, error = squares(edge);
  for (int round = 0; round < 25; ++round) {
    const dvec3 u = glm::normalize(std::abs(edge.normal.x) < 0.8 ? glm::cross(edge.normal, dvec3(1, 0, 0))
                                                                 : glm::cross(edge.normal, dvec3(0, 1, 0)));
    const dvec3 w = glm::cross(edge.normal, u);
    const auto change = step_from(edge, u, w, damping);
    if (!change) return Fit::none;
    const auto& c = *change;
    Edge next = edge;
    next.outside += c[0];
    next.step += c[1];
    next.at += c[2];
    next.sigma *= std::exp(std::clamp(c[3], -1.0, 1.0));
    next.normal = glm::normalize(edge.normal + c[4] * u + c[5] * w);
    next.bend += c[6];
    const double next_error = squares(next);
    if (next_error < error) {
      const bool is_done = error - next_error < 1e-4 * error;
      edge = next;
      error = next_error;
      damping *= 0.3;
      if (is_done) break;
    } else if ((damping *= 8) > 1e4) {
      break;
    }
  }
  const double residual = std::sqrt(error / static_cast<double>(offsets_.size()));
  if (!(edge.step > min_step) || residual > 2 * noise + 0.06 * edge.step) return Fit::none;
  const bool is_clean =
      residual < 1.25 * noise + 0.012 * edge.step && is_level(edge, -1, noise) && is_level(edge, 1, noise);
  return is_clean ? Fit::clean : Fit::rough;
}

std::optional<EdgeFit::Unknowns> EdgeFit::step_from(const Edge& edge, const dvec3& u, const dvec3& w,
                                                    double damping) const {
  System system{};
  for (std::size_t k = 0; k < offsets_.size(); ++k) {
    const double z = edge.signed_distance(offsets_[k]) / edge.sigma, rise = 0.5 * std::erfc(-z / k_root_2),
                 slope = edge.step * std::exp(-0.5 * z * z) / (k_root_2_pi * edge.sigma);
    const double residual = values_[k] - edge.outside - edge.step * rise;
    const double along = glm::dot(offsets_[k], edge.normal);
    const std::array<double, k_unknowns> row{
        1,
        rise,
        -slope,
        -slope * z * edge.sigma,
        slope * glm::dot(offsets_[k], u),
        slope * glm::dot(offsets_[k], w),
        0.5 * slope * (glm::dot(offsets_[k], offsets_[k]) - along * along)};
    for (std::size_t i = 0; i < k_unknowns; ++i) {
      for (std::size_t j = 0; j < k_unknowns; ++j) system[i][j] += row[i] * row[j];
      system[i][k_unknowns] += row[i] * residual;
    }
  }
  for (std::size_t i = 0; i < k_unknowns; ++i) system[i][i] *= 1 + damping;
  return solve(system);
}

std::vector<ScanQuality::EdgePoint> EdgeFit::superimposed_points(const Edge& edge) const {
  std::vector<ScanQuality::EdgePoint> points;
  for (std::size_t k = 0; k < offsets_.size(); k += 7)
    points.push_back({edge.signed_distance(offsets_[k]), (values_[k] - edge.outside) / edge.step});
  return points;
}

bool EdgeFit::is_level(const Edge& e, int side, double noise) const {
  // Only voxels at least this far from the edge are tested, in sigma. The fit accounts for the remaining part
  // of the step there.
  constexpr double k_beyond = 1.3;
  double n = 0, x = 0, xx = 0, y = 0, xy = 0, farthest = 0;
  for (std::size_t k = 0; k < offsets_.size(); ++k) {
    const double z = side * e.signed_distance(offsets_[k]) / e.sigma;
    farthest = std::max(farthest, z);
    if (z < k_beyond) continue;
    const double residual = values_[k] - e.outside - e.step * 0.5 * std::erfc(-side * z / k_root_2);
    ++n, x += z, xx += z * z, y += residual, xy += z * residual;
  }
  const double spread = xx - x * x / n;
  if (n < 8 || farthest < 1.8 || !(spread > 0)) return false;
  const double slope = (xy - x * y / n) / spread, error = noise / std::sqrt(spread);
  return std::abs(slope) < 0.008 * e.step + 2 * error;
}

double EdgeFit::squares(const Edge& e) const {
  double sum = 0;
  for (std::size_t k = 0; k < offsets_.size(); ++k) {
    const double residual = values_[k] - e.outside -
                            e.step * 0.5 * std::erfc(-e.signed_distance(offsets_[k]) / (k_root_2 * e.sigma));
    sum += residual * residual;
  }
  return sum;
}

std::optional<EdgeFit::Unknowns> EdgeFit::solve(System m) {
  for (std::size_t i = 0; i < k_unknowns; ++i) {
    std::size_t pivot = i;
    for (std::size_t r = i + 1; r < k_unknowns; ++r)
      if (std::abs(m[r][i]) > std::abs(m[pivot][i])) pivot = r;
    if (!(std::abs(m[pivot][i]) > 1e-12)) return std::nullopt;
    std::swap(m[i], m[pivot]);
    for (std::size_t r = 0; r < k_unknowns; ++r) {
      if (r == i) continue;
      const double f = m[r][i] / m[i][i];
      for (std::size_t c = i; c <= k_unknowns; ++c) m[r][c] -= f * m[i][c];
    }
  }
  Unknowns x;
  for (std::size_t i = 0; i < k_unknowns; ++i) x[i] = m[i][k_unknowns] / m[i][i];
  return x;
}

}  // namespace trephine::data_tools
