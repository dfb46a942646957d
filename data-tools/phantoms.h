// Phantoms: volumes whose exact shape is known, and an anatomical head and spine. Deterministic: same
// options, same bits.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <map>
#include <optional>
#include <span>
#include <string>

#include "volume/volume.h"

namespace trephine::data_tools {

/// Sampling of a phantom. Shapes lie in a box of 120 mm about the world origin (head and spine in
/// their own extent), whatever the grid; a grid size without a spacing fills the box, and a spacing without a
/// size too.
struct PhantomOptions {
  std::optional<glm::ivec3> size;  ///< voxels
  std::optional<glm::dvec3> spacing_mm;
  double psf_sigma_voxels = 0;  ///< scanner blur, 0 to 2 (head and spine: 1 unless given)
  bool is_psf_given = false;
  double shear_degrees = 0;  ///< slices shifted along y by tan(shear) per mm of z, as by a gantry tilt
  std::uint64_t seed = 1;    ///< of the noise, and of the anatomy: 1 is the plain one
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
/// All phantoms, for help and for errors.
std::span<const PhantomInfo> phantom_catalogue();

/// Makes `name`. HU: air -1000, solid 1600, so that iso 300 is the middle of every blurred edge. Error on
/// unknown names, parameters or impossible values.
volume::Result<volume::Volume> make_phantom(const std::string& name, const PhantomOptions& options = {});

/// Signed distance (mm, negative inside) of an analytic phantom at a world point, near its surface to first
/// order (exact for sphere, plane, plate and torus, and away from the edges of groove, corner, slot, cone and
/// steps). The judge of every accuracy test.
double phantom_distance(const std::string& name, const std::map<std::string, double>& parameters,
                        const glm::dvec3& p_world);

}  // namespace trephine::data_tools
