// A plane of pixels in the world: what slices and sections are made in.
#pragma once

#include <array>
#include <glm/vec2.hpp>
#include <optional>
#include <string_view>

#include "volume/frame.h"

namespace trephine::volume {

/// Pixel (i, j), from the upper left on, has its middle at world(i, j). Seen from where right x up points to.
struct ImagePlane {
  glm::dvec3 middle_world{0.0};
  glm::dvec3 right{1, 0, 0}, up{0, 0, 1};  ///< unit, at right angles
  double pixel = 0.5;                      ///< mm
  int columns = 512, rows = 512;

  glm::dvec3 normal() const noexcept {
    return {right.y * up.z - right.z * up.y, right.z * up.x - right.x * up.z,
            right.x * up.y - right.y * up.x};
  }
  /// mm from the middle, to the right and up.
  glm::dvec2 of_pixel(double i, double j) const noexcept {
    return {pixel * (i - 0.5 * (columns - 1)), pixel * (0.5 * (rows - 1) - j)};
  }
  glm::dvec3 world(const glm::dvec2& mm) const noexcept { return middle_world + mm.x * right + mm.y * up; }
  glm::dvec3 world(double i, double j) const noexcept { return world(of_pixel(i, j)); }
  glm::dvec2 from_world(const glm::dvec3& p) const noexcept {
    const glm::dvec3 off = p - middle_world;
    return {off.x * right.x + off.y * right.y + off.z * right.z, off.x * up.x + off.y * up.y + off.z * up.z};
  }
  /// mm before the plane, toward who looks at it.
  double height(const glm::dvec3& p) const noexcept {
    const glm::dvec3 off = p - middle_world, n = normal();
    return off.x * n.x + off.y * n.y + off.z * n.z;
  }
};

/// The outer corners of the voxels low .. high.
std::array<glm::dvec3, 8> corners_world(const Frame& frame, const glm::ivec3& low,
                                        const glm::ivec3& high) noexcept;

/// As radiologists look at them: axial from the feet, coronal from the front, sagittal from the patient's
/// left with the face to the left.
inline constexpr std::string_view k_planes[] = {"axial", "coronal", "sagittal"};
/// Turns a plane that way; false: unknown name.
bool turn_plane(ImagePlane& plane, std::string_view name) noexcept;
/// Square to a direction, the head (or, of a direction toward it, the front) as far up as can be. False: the
/// direction is invalid.
bool turn_plane(ImagePlane& plane, const glm::dvec3& normal) noexcept;
/// Error when it is not finite, not at right angles, empty, or of more than 64 million pixels.
Status check(const ImagePlane& plane);

}  // namespace trephine::volume
