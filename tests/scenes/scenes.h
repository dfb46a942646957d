// Scenes shared by tests and benchmarks: a phantom with one touchable shape, and motions over it.
#pragma once

#include <memory>
#include <string>

#include "data-tools/phantoms.h"
#include "haptics/pose_path.h"
#include "haptics/touch_scene.h"

namespace trephine::scenes {

/// A phantom touched at iso 300. Aborts the test on bad options (they are ours).
haptics::TouchScene phantom_scene(const std::string& name, const data_tools::PhantomOptions& options);

/// A volume touched at iso 300.
haptics::TouchScene scene_of(volume::Volume&& volume, const haptics::Material& material = {});

/// Back and forth over the sphere of phantom "sphere" (radius mm), `depth` mm inside it, at `speed` mm/s for
/// `seconds`: a great circle tilted so that it follows no lattice plane. Sampled at 1 kHz.
haptics::PosePath sphere_slide(double radius, double depth, double speed, double seconds);

/// A random walk of the HIP in a box, pushed about with steps up to `step` mm, so that it enters and leaves
/// matter.
haptics::PosePath rough_walk(const glm::dvec3& low, const glm::dvec3& high, double step, int samples,
                             std::uint64_t seed);

}  // namespace trephine::scenes
