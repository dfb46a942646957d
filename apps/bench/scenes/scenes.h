// Scenes shared by tests and benchmarks: a phantom with one touchable shape, and motions over it.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "data-tools/phantoms/phantoms.h"
#include "haptics/device/pose_path.h"
#include "haptics/scene/touch_scene.h"

namespace trephine::scenes {

/// A phantom touched at iso 300. Aborts the program if the options are invalid.
haptics::TouchScene phantom_scene(const std::string& name, const data_tools::PhantomOptions& options);

/// A volume with one shape, at iso 300 by default.
haptics::TouchScene scene_of(volume::Volume&& volume, const haptics::Material& material = {},
                             const volume::Shape& shape = {});

/// Returns a volume of voxels of `spacing` (mm) in the box low .. high of the world. `hounsfield`: returns
/// the intensity at a world position.
volume::Volume sampled(const glm::dvec3& low, const glm::dvec3& high, const glm::dvec3& spacing,
                       const std::function<double(const glm::dvec3&)>& hounsfield);

/// Properties of a scan as scanners and other programs write it: thick slices, shear, metres or micrometres
/// instead of mm, or a mask of 0 and 1.
struct Scan {
  double slice, shear;  ///< voxels are 1.5 x 1.5 x (1.5 slice) units; shear in degrees
  double unit;          ///< unit of length, mm
  bool is_mask;
  std::string name() const;
};
inline constexpr Scan k_scans[] = {{1, 0, 1, false},  {2.5, 0, 1, false},   {5, 25, 1, false},
                                   {12, 0, 1, false}, {2, 30, 1, true},     {4, 0, 1, true},
                                   {1, 0, 1, true},   {3, 10, 1e-3, false}, {3, 10, 1e3, true}};
/// A scan of a sphere with a radius of 45 units, or of a block that fills its grid to the border. Masks have
/// soft fields.
haptics::TouchScene scan_scene(const Scan& scan, bool is_block);

/// A path back and forth over the phantom "sphere" (`radius` in mm), `depth` mm inside it, at `speed` mm/s
/// for `seconds`. It is an arc of a great circle that is tilted so that it follows no lattice plane. The
/// first sample is 1 mm outside the sphere. Sampled at 1 kHz.
haptics::PosePath sphere_slide(double radius, double depth, double speed, double seconds);

/// A random walk of the HIP in a box, with steps of at most `step` mm along each axis, sampled at 1 kHz. It
/// enters and leaves the matter in the box.
haptics::PosePath rough_walk(const glm::dvec3& low, const glm::dvec3& high, double step, int samples,
                             std::uint64_t seed);

}  // namespace trephine::scenes
