// The rim of what was sawn, made smooth: as a rasp would, by a Gaussian.
#pragma once

#include "modules/bone_flap/kerf.h"

namespace trephine::bone_flap {

/// Bone to remove near a kerf, where a Gaussian of all bone is well below one half: sharp edges, not
/// walls, nor the skull's own surface. It ends two sigmas from the walls, and 1.5 samples outside the bone:
/// soft tissue along the rim stays.
class Rim final : public volume::RemovalField {
 public:
  /// `left`: after the flap is gone. `sigma`: mm. Borrows.
  Rim(const Sheet& sheet, const volume::Field& bone, const volume::Version& left, double sigma);
  Reach find(const glm::ivec3& low, double band, Distances& mm) override;
  const volume::VoxelBox& samples() const noexcept { return kerf_.samples(); }

  /// mm that an edge is spared, so that what is flat stays as it is, by its samples.
  static double spared(double sigma, const volume::CutLattice& lattice) noexcept;

 private:
  static constexpr double k_beside = 1.5;  ///< samples
  /// mm from a place (volume frame) to the surface of the scan's bone, to first order; below 0 within it.
  double off_bone_mm(const glm::dvec3& p) const;

  Kerf kerf_;
  const volume::Field& bone_;
  const volume::Version& left_;
  double sigma_;
  glm::ivec3 halo_;
  std::vector<double> weights_[3];  ///< along an axis, from -halo to halo; their sum is 1
  std::vector<double> share_, half_made_;
};

}  // namespace trephine::bone_flap
