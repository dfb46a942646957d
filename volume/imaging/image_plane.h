// ImagePlane: plane of pixels in world coordinates, for slices and cross-sections.
#pragma once

#include <array>
#include <glm/vec2.hpp>
#include <optional>
#include <string_view>

#include "volume/scan/frame.h"

namespace trephine::volume {

/// Pixel (i, j) is counted from the upper left and has its centre at world(i, j). The viewer is on the side
/// to which normal() points.
struct ImagePlane {
  glm::dvec3 middle_world{0.0};            ///< centre of the image, mm
  glm::dvec3 right{1, 0, 0}, up{0, 0, 1};  ///< orthogonal unit vectors, world
  double pixel = 0.5;                      ///< pixel spacing, mm
  int columns = 512, rows = 512;

  /// right x up, a unit vector.
  glm::dvec3 normal() const noexcept {
    return {right.y * up.z - right.z * up.y, right.z * up.x - right.x * up.z,
            right.x * up.y - right.y * up.x};
  }
  /// Position of a pixel's centre relative to the image centre, to the right and up, mm.
  glm::dvec2 of_pixel(double i, double j) const noexcept {
    return {pixel * (i - 0.5 * (columns - 1)), pixel * (0.5 * (rows - 1) - j)};
  }
  glm::dvec3 world(const glm::dvec2& mm) const noexcept { return middle_world + mm.x * right + mm.y * up; }
  glm::dvec3 world(double i, double j) const noexcept { return world(of_pixel(i, j)); }
  glm::dvec2 from_world(const glm::dvec3& p) const noexcept {
    const glm::dvec3 d = p - middle_world;
    return {d.x * right.x + d.y * right.y + d.z * right.z, d.x * up.x + d.y * up.y + d.z * up.z};
  }
  /// Signed distance (mm) of a world point from the plane, positive toward the viewer.
  double height(const glm::dvec3& p) const noexcept {
    const glm::dvec3 d = p - middle_world, n = normal();
    return d.x * n.x + d.y * n.y + d.z * n.z;
  }
};

/// Outer corners of the box of voxels low .. high, world.
std::array<glm::dvec3, 8> corners_world(const Frame& frame, const glm::ivec3& low,
                                        const glm::ivec3& high) noexcept;

/// Names of the radiological planes: axial viewed from the feet, coronal from the front, sagittal from the
/// patient's left with the face to the left.
inline constexpr std::string_view k_planes[] = {"axial", "coronal", "sagittal"};
/// Orients a plane as the radiological plane `name`, one of k_planes. Returns false for an unknown name.
bool orient_plane(ImagePlane& plane, std::string_view name) noexcept;
/// Orients a plane perpendicular to `normal`, with the head (for a normal near the body axis: the front) as
/// far up as possible. Returns false if the normal is zero or not finite.
bool orient_plane(ImagePlane& plane, const glm::dvec3& normal) noexcept;
/// Returns an error if the plane is not finite, if its axes are not orthogonal unit vectors, or if its pixel
/// spacing, columns or rows are out of range. The limit is 2^15 columns, 2^15 rows and 2^26 pixels.
Status check(const ImagePlane& plane);

}  // namespace trephine::volume
