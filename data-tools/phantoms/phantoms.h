// Phantoms: volumes with exactly known shapes, and an anatomical head and spine. Deterministic: equal options
// give equal bits.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <map>
#include <optional>
#include <span>
#include <string>

#include "volume/scan/volume.h"

namespace trephine::data_tools {

/// Sampling of a phantom. Shapes are defined in a box of 120 mm around the world origin, independent of the
/// grid (head and spine: their own extent). If only size or only spacing is set, the grid fills the box. If
/// neither is set, the box has 128 voxels per edge, the head voxels of 0.8 mm, and the spine voxels of 0.7
/// mm.
struct PhantomOptions {
  std::optional<glm::ivec3> size;  ///< voxels
  std::optional<glm::dvec3> spacing_mm;
  double psf_sigma_voxels = 0;  ///< sigma of the scanner blur, voxels, 0 to 2; see is_psf_given
  bool is_psf_given = false;    ///< false: a psf_sigma_voxels of 0 means 1 for head and spine
  double shear_degrees = 0;     ///< slices are shifted along y by tan(shear) per mm of z, like a gantry tilt
  std::uint64_t seed = 1;       ///< of noise and anatomy; 1 is the reference anatomy
  /// Surgical approach to a head, which determines the position of its tumour: "vault", "frontotemporal",
  /// "suboccipital" or "keyhole". Empty: vault.
  std::string approach;
  std::map<std::string, double> parameters;  ///< e.g. radius, angle, thickness, period, noise
  int threads = 0;
};

/// One parameter of a phantom.
struct PhantomParameter {
  std::string name, meaning;
  double value;  ///< default
};
struct PhantomInfo {
  std::string name, meaning;
  std::vector<PhantomParameter> parameters;
};
/// Returns all phantoms, for help and errors.
std::span<const PhantomInfo> phantom_catalogue();

/// Makes the phantom `name`. In analytic phantoms air is -1000 HU and solid 1600 HU, so the iso value 300 is
/// the middle of each blurred edge. Error on unknown names, unknown parameters and values out of range.
Result<volume::Volume> make_phantom(const std::string& name, const PhantomOptions& options = {});

/// Returns the signed distance (mm, negative inside) of an analytic phantom at a world point, to first order
/// near its surface. It is exact for sphere, plane, plate, torus and wedge. For the other shapes except
/// gyroid it is exact near the surface, away from edges and tips. Accuracy tests use it as their reference.
double phantom_distance(const std::string& name, const std::map<std::string, double>& parameters,
                        const glm::dvec3& p_world);

}  // namespace trephine::data_tools
