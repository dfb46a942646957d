// Rates: size, resolution and rate of depth images for a hand of a given speed, by the design rules of
// touching by depth images (Kim et al., Presence 18:340, 2009), with the published names. mm, mm/s, Hz.
#pragma once

#include <cmath>

namespace trephine::haptics::depth {

/// Inputs of the rules. As published: 1 m/s, 100 images and 1000 forces per second.
struct Rates {
  double fastest = 1000;      ///< mm/s, the largest speed of the hand
  double image_rate = 100;    ///< Hz, of the depth images, which are drawn in addition to the display
  double haptic_rate = 1000;  ///< Hz
};

/// Returns the edge of the clip volume around the proxy, in which the proxy stays until the next images. The
/// factor 2 covers both directions of an axis.
constexpr double clip_volume(const Rates& r) noexcept { return 2 * r.fastest / r.image_rate; }

/// Returns the length that workspace_cube() adds to the object: a camera at the surface sees no depth.
constexpr double margin(const Rates& r) noexcept { return clip_volume(r); }

/// Returns the edge of the cube with the six cameras on its faces.
constexpr double workspace_cube(double largest_dimension, const Rates& r) noexcept {
  return largest_dimension + margin(r);
}

/// Returns the number of pixels along an edge of each image.
inline int viewport(double clip_volume_mm, double desired_resolution) noexcept {
  return static_cast<int>(std::ceil(clip_volume_mm / desired_resolution * (1 - 1e-12)));
}

/// Returns the edge of the local occupancy map (LOMI): the distance that the fastest hand moves in one haptic
/// step, in both directions.
constexpr double lomi_size(const Rates& r) noexcept { return 2 * r.fastest / r.haptic_rate; }

/// Returns the number of voxels along the edge of the local occupancy map: odd, so that one voxel is central.
inline int lomi_voxels(double lomi_mm, double desired_resolution) noexcept {
  const int whole = viewport(lomi_mm, desired_resolution);
  return whole + (whole % 2 == 0);
}

/// Returns the step of a depth buffer of `bits` bits between two cameras that face each other.
inline double depth_resolution(double distance, int bits) noexcept { return std::ldexp(distance, -bits); }

/// Returns the position of a value of the depth buffer, 0 to 1, for an orthographic camera.
constexpr double linear_position(double near, double far, double depth) noexcept {
  return near + (far - near) * depth;
}

/// Returns the distance from a perspective camera of a value of the depth buffer, 0 to 1.
constexpr double perspective_distance(double near, double far, double depth) noexcept {
  return far * near / (far - depth * (far - near));
}

}  // namespace trephine::haptics::depth
