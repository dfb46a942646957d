// Rim: smooths the edges of sawn bone by a Gaussian, as a surgeon does with a rasp.
#pragma once

#include "modules/bone_flap/kerf.h"

namespace trephine::bone_flap {

/// Removes bone near a kerf where the bone, blurred by a Gaussian, is well below one half. This is the case
/// at sharp edges, but not at flat walls or at the skull's own surface. The removal ends two sigmas from the
/// walls and 1.5 samples outside the bone, so that soft tissue along the rim stays.
class Rim final : public volume::RemovalField {
 public:
  /// `rest`: the version without the flap. `sigma`: mm. Borrows the other arguments.
  Rim(const CutSurface& surface, const volume::Field& bone, const volume::Version& rest, double sigma);
  Reach find(const glm::ivec3& low, double band, Distances& mm) override;
  const volume::VoxelBox& samples() const noexcept { return kerf_.samples(); }

  /// Returns the distance outside the blurred surface, mm, up to which samples are kept, so that no sample of
  /// a flat surface is removed.
  static double spared(double sigma, const volume::CutLattice& lattice) noexcept;

 private:
  static constexpr double k_outside = 1.5;  ///< samples outside the bone
  /// Returns the distance of p (volume frame) from the scan's bone, mm, to first order; -1e300 inside.
  double off_bone_mm(const glm::dvec3& p) const;

  Kerf kerf_;
  const volume::Field& bone_;
  const volume::Version& rest_;
  double sigma_;
  glm::ivec3 halo_;
  std::vector<double> weights_[3];  ///< per axis, from -halo to halo; sum 1
  std::vector<double> share_, scratch_;
};

}  // namespace trephine::bone_flap
