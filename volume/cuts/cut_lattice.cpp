#include "volume/cuts/cut_lattice.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <sstream>

namespace trephine::volume {

namespace {

constexpr int k_longest_axis = 1 << 22;  // samples
constexpr std::int64_t k_max_regions = std::int64_t{1}
                                       << 16;  // regions of 512^3 samples in a version's table

/// Returns the smallest odd numbers of samples per voxel along each axis with steps of at most `step` mm; if
/// one of these numbers is above 1, all are at least 3.
glm::ivec3 division(const glm::dvec3& spacing, double step) {
  glm::ivec3 per_voxel;
  for (int a = 0; a < 3; ++a) {
    const double least = std::ceil(spacing[a] / step * (1 - 1e-12));
    const int k = static_cast<int>(std::clamp(least, 1.0, 1e6));
    per_voxel[a] = k | 1;
  }
  // The numbers are either 1 along every axis or at least 3 along every axis, because surface nets need a
  // sample inside each face where cells of two sizes meet.
  if (per_voxel != glm::ivec3(1)) per_voxel = glm::max(per_voxel, glm::ivec3(3));
  return per_voxel;
}

/// Returns true if a lattice with these numbers of samples per voxel is within the limits of size.
bool is_possible(const Volume& volume, const glm::ivec3& per_voxel) {
  std::int64_t regions = 1;
  for (int a = 0; a < 3; ++a) {
    const std::int64_t samples = std::int64_t{volume.size[a]} * per_voxel[a] + 2 * CutLattice::k_margin;
    if (per_voxel[a] > CutLattice::k_max_per_voxel || samples > k_longest_axis) return false;
    regions *= (samples + 511) / 512;
  }
  return regions <= k_max_regions;
}

}  // namespace

CutLattice::CutLattice(const Volume& volume, const glm::ivec3& per_voxel)
    : per_voxel_(per_voxel),
      size_(volume.size * per_voxel + 2 * k_margin),
      first_centre_((per_voxel - 1) / 2 + k_margin),
      scale_(per_voxel) {
  glm::dmat3 axes = volume.frame.axes();
  for (int a = 0; a < 3; ++a) axes[a] /= scale_[a];
  const Result<Frame> result =
      Frame::from_axes(volume.frame.world_from_volume(volume_from_lattice(glm::dvec3(0))), axes);
  TREPHINE_ASSERT(result);  // a subdivision of a valid frame is valid
  frame_ = result.value();
}

double CutLattice::smallest_burr_mm(const Volume& volume) noexcept {
  // Finds the finest possible step by bisection: the numbers of samples per voxel are integers, so that no
  // formula gives this step.
  const glm::dvec3& spacing = volume.frame.spacing();
  double possible = std::max({spacing.x, spacing.y, spacing.z}), impossible = possible / 1e4;
  for (int i = 0; i < 60; ++i) {
    const double middle = std::sqrt(possible * impossible);
    (is_possible(volume, division(spacing, middle)) ? possible : impossible) = middle;
  }
  return 2 * k_samples_per_radius * possible;
}

Result<CutLattice> CutLattice::for_burr(const Volume& volume, double diameter_mm) {
  const double step = 0.5 * diameter_mm / k_samples_per_radius;
  const glm::ivec3 per_voxel = step > 0 ? division(volume.frame.spacing(), step) : glm::ivec3(0);
  if (!(step > 0) || !is_possible(volume, per_voxel)) {
    std::ostringstream found, expected;
    found << diameter_mm << " mm";
    // Rounded up to three digits, so that the reported diameter is valid.
    const double least = smallest_burr_mm(volume), digit = std::pow(10, std::floor(std::log10(least)) - 2);
    expected << "a diameter of at least " << std::ceil(least / digit) * digit << " mm";
    return Error{.what = "the burr is too small for this scan's voxels",
                 .where = "smallest burr",
                 .found = found.str(),
                 .expected = expected.str(),
                 .remedy = "use a larger burr, crop the scan, or resample it to thinner slices"};
  }
  return CutLattice(volume, per_voxel);
}

}  // namespace trephine::volume
