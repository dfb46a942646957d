// DepthPicture: depth buffer of a window, or picture of a depth camera, at one moment.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "haptics/depth/depth_camera.h"
#include "haptics/depth/depth_source.h"

namespace trephine::haptics::depth {

/// Part of a camera's picture that shows a clip volume, as a surface: pixels joined to their neighbours.
struct PixelSurface {
  glm::ivec2 first{0}, last{-1};  ///< pixels, both included
  std::vector<glm::dvec3> vertices;
  std::vector<std::uint32_t> triangles;  ///< counter-clockwise as viewed from the camera
  std::size_t pixels_with_depth = 0;     ///< pixels with a measurement
};
/// Returns the part that shows the clip volume from `low` to `high` (mm, camera's frame). `depth` of a pixel:
/// mm; 0: no measurement, which counts as `beyond` mm beyond the clip volume.
PixelSurface pixel_surface(const DepthCamera& camera, const glm::dvec3& low, const glm::dvec3& high,
                           double beyond, const std::function<double(int column, int row)>& depth);

/// A picture with depths of 16 bits.
struct DepthPicture {
  DepthCamera camera;        ///< intrinsics for these pixels
  Placement placement;       ///< of the camera in the object's frame
  double nearest = 0;        ///< mm along z, of a value of 1
  double mm_per_step = 0.1;  ///< mm per value
  std::string values;        ///< two bytes per pixel, low byte first, row by row; 0: no measurement

  /// Returns the depth, mm; 0: no measurement.
  double depth(int column, int row) const noexcept;
  /// Stores the depths (mm) of the pixels; 0 or less: no measurement.
  void set_depths(const std::vector<double>& depths);
  /// Returns the distance (mm, along the camera's z) of p (frame of the object) behind the surface in the
  /// picture; negative: p is in front of it. The farthest of the four pixels around p counts. Empty: p is
  /// outside the picture, or these pixels have no measurement.
  std::optional<double> behind(const glm::dvec3& p) const noexcept;
  /// Returns the edge (mm) of a cube about p (object's frame) in which the picture shows all space in front
  /// of the surface.
  double known_cube_edge(const glm::dvec3& p) const noexcept;
};
/// Returns an error if the camera is invalid, or `values` does not have one value per pixel of the camera.
Status check(const DepthPicture& picture);

/// Returns the surface within the clip volume; anything behind it counts as matter. The set is at rest:
/// motion shows in the next picture.
DepthSet set_of(const DepthView& view, const DepthPicture& picture);

/// Object whose pictures are submitted from outside: the background of a window, or a camera. The last
/// picture is valid until the next one.
class IncomingDepths final : public DepthSource {
 public:
  /// Returns an error: the object cannot be drawn.
  Result<DepthSet> draw(const DepthView& view, int threads = 0) const override;
  bool is_moving(double) const noexcept override { return false; }
  bool is_streamed() const noexcept override { return true; }
  void bounds(glm::dvec3& low, glm::dvec3& high) const noexcept override {
    low = glm::dvec3(-1e6), high = glm::dvec3(1e6);
  }
  std::uint64_t hash() const noexcept override { return 1; }
};

}  // namespace trephine::haptics::depth
