// How large, how fine and how often depth images must be for a hand of a given speed: the design rules of
// touching by depth images (Kim et al., Presence 18:340, 2009), each by its name. mm, mm/s, Hz.
#pragma once

#include <cmath>

namespace trephine::haptics::depth {

/// What the rules start from. As published: 1 m/s, images 100 times a second, forces 1000 times.
struct Rates {
  double fastest = 1000;    ///< of the hand; no real one may be faster
  double image_rate = 100;  ///< of the depth images, beside what is drawn for the eye
  double haptic_rate = 1000;
};

/// How far the clip volume around the proxy reaches, edge to edge: wherever it goes before the next images,
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

/// What a step of a depth buffer of so many bits is, between two cameras that face each other.
inline double depth_resolution(double distance, int bits) noexcept { return std::ldexp(distance, -bits); }

/// Where a depth of 0 to 1 lies, of an orthographic camera.
constexpr double linear_position(double near, double far, double depth) noexcept {
  return near + (far - near) * depth;
}

/// How far before a perspective camera a depth of 0 to 1 lies.
constexpr double perspective_distance(double near, double far, double depth) noexcept {
  return far * near / (far - depth * (far - near));
}

}  // namespace trephine::haptics::depth
