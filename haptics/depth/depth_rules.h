// Size, resolution and rate of depth images for a hand of a given speed: the design rules of
// touching by depth images (Kim et al., Presence 18:340, 2009), each by its name. mm, mm/s, Hz.
#pragma once

#include <cmath>

namespace trephine::haptics::depth {

/// Inputs of the rules. As published: 1 m/s, images 100 times a second, forces 1000 times.
struct Rates {
  double fastest = 1000;    ///< of the hand; no real one may be faster
  double image_rate = 100;  ///< of the depth images, in addition to those for the eye
  double haptic_rate = 1000;
};

/// Edge of the clip volume around the proxy: wherever the proxy goes before the next images,
/// it stays within. Twice: there are two ways along each axis.
constexpr double clip_volume(const Rates& r) noexcept { return 2 * r.fastest / r.image_rate; }

/// Room between what is touched and a camera: at its face there is no depth to see.
constexpr double margin(const Rates& r) noexcept { return clip_volume(r); }

/// The cube on whose faces the six cameras are.
constexpr double workspace_cube(double largest_dimension, const Rates& r) noexcept {
  return largest_dimension + margin(r);
}

/// Pixels along an edge of each image.
inline int viewport(double clip_volume_mm, double desired_resolution) noexcept {
  return static_cast<int>(std::ceil(clip_volume_mm / desired_resolution * (1 - 1e-12)));
}

/// The local occupancy map (LOMI): as far as a hand comes in one haptic step, either way.
constexpr double lomi_size(const Rates& r) noexcept { return 2 * r.fastest / r.haptic_rate; }

/// Voxels along its edge: odd, as there is one in its middle.
inline int lomi_voxels(double lomi_mm, double desired_resolution) noexcept {
  const int whole = viewport(lomi_mm, desired_resolution);
  return whole + (whole % 2 == 0);
}

/// Step of a depth buffer of so many bits, between two cameras that face each other.
inline double depth_resolution(double distance, int bits) noexcept { return std::ldexp(distance, -bits); }

/// Position of a depth of 0 to 1, orthographic camera.
constexpr double linear_position(double near, double far, double depth) noexcept {
  return near + (far - near) * depth;
}

/// Distance before a perspective camera of a depth of 0 to 1.
constexpr double perspective_distance(double near, double far, double depth) noexcept {
  return far * near / (far - depth * (far - near));
}

}  // namespace trephine::haptics::depth
