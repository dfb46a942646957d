// Picture of one camera at one moment: the depth buffer of a window, or a depth camera.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "haptics/depth/depth_camera.h"
#include "haptics/depth/depth_source.h"

namespace trephine::haptics::depth {

/// The part of a camera's picture that shows a clip volume, as a surface: pixels joined to their neighbours.
struct PixelSurface {
  glm::ivec2 first{0}, last{-1};  ///< pixels
  std::vector<glm::dvec3> vertices;
  std::vector<std::uint32_t> triangles;  ///< seen from the camera counter-clockwise
  std::size_t seen = 0;                  ///< pixels with a depth
};
/// `low`, `high`: the clip volume, mm, of the camera's frame. `depth` of a pixel, mm; 0: nothing was seen,
/// and it is taken for lying `unseen` mm beyond the clip volume.
PixelSurface pixel_surface(const DepthCamera& camera, const glm::dvec3& low, const glm::dvec3& high,
                           double unseen, const std::function<double(int column, int row)>& depth);

/// Depths in 16 bits, as they are kept.
struct DepthPicture {
  DepthCamera camera;      ///< of these pixels alone
  Placement place;         ///< of the camera in the thing's frame
  double nearest = 0;      ///< mm along z, of a value of 1
  double mm_a_step = 0.1;  ///< of a value
  std::string values;      ///< two bytes a pixel, the lower one first, row by row; 0: nothing was seen

  /// mm; 0: nothing was seen.
  double depth(int column, int row) const noexcept;
  /// Keeps depths of such pixels, 0 or less where nothing was seen.
  void keep(const std::vector<double>& depths);
  /// Distance of p (mm, frame of the object) behind the surface in the picture; negative: before it. Empty:
  /// it is not in the picture, or nothing was seen there.
  std::optional<double> behind(const glm::dvec3& p) const noexcept;
  /// mm, of the thing's frame: a cube about p of which the picture shows all that is before the surface.
  double known_around(const glm::dvec3& p) const noexcept;
};
/// Error: another number of pixels, or an invalid camera.
volume::Status check(const DepthPicture& picture);

/// The surface within the clip volume: what lies behind it is taken for matter. At rest: what moves is seen
/// to have moved by the next one.
DepthSet set_of(const DepthView& view, const DepthPicture& picture);

/// An object whose pictures are submitted from outside: the background on a window's screen, a camera.
/// Between them it stays as it was seen last.
class IncomingDepths final : public DepthSource {
 public:
  /// Error: it cannot be drawn.
  volume::Result<DepthSet> draw(const DepthView& view, int threads = 0) const override;
  bool is_moving(double) const noexcept override { return false; }
  bool comes_in() const noexcept override { return true; }
  void bounds(glm::dvec3& low, glm::dvec3& high) const noexcept override {
    low = glm::dvec3(-1e6), high = glm::dvec3(1e6);
  }
  std::uint64_t hash() const noexcept override { return 1; }
};

}  // namespace trephine::haptics::depth
