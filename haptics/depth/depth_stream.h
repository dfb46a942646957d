// DepthStream: recorded pictures of one depth camera, in sequence.
#pragma once

#include <cstdint>
#include <mutex>
#include <vector>

#include "haptics/depth/depth_camera.h"
#include "haptics/depth/depth_source.h"

namespace trephine::haptics::depth {

struct DepthPictures {
  DepthCamera camera;
  double mm_per_step = 0.1;                          ///< mm per value
  std::vector<std::vector<std::uint16_t>> pictures;  ///< depths along z, row by row; 0: no measurement
  std::vector<double> times;                         ///< s, increasing from 0
  bool is_repeating = false;
  double repeats_after = 0;  ///< s, length of one repetition
};

/// Surface of the pixels, joined to their neighbours. Matter is assumed behind each pixel, so the surface has
/// walls at the silhouettes of objects. Pixels without a measurement count as far away. Between two pictures
/// a pixel's depth is interpolated linearly if both show the same object.
class DepthStream final : public DepthSource {
 public:
  /// Largest change of depth (mm) within one object: of a pixel between two pictures, or between neighbours.
  static constexpr double k_same = 40;
  /// Error: an invalid camera or step of depths, no pictures, pictures of another size than the camera's,
  /// times that do not increase, or a repetition that does not start after the last picture.
  static Result<std::shared_ptr<const DepthStream>> of(DepthPictures pictures);

  Result<DepthSet> draw(const DepthView& view, int threads = 0) const override;
  bool is_moving(double time) const noexcept override;
  double next_motion_change(double time) const noexcept override;
  void bounds(glm::dvec3& low, glm::dvec3& high) const noexcept override { low = low_, high = high_; }
  std::uint64_t hash() const noexcept override { return hash_; }
  /// Returns the nearest picture's surface for display: without walls at silhouettes, in at most 160 pixels
  /// along each axis; null without measurements.
  std::shared_ptr<const MeshTree> surface_at(double time) const override;
  const DepthPictures& pictures() const noexcept { return pictures_; }
  /// Returns the depth, mm; 0: no measurement there at that time.
  double depth_at(int column, int row, double time) const noexcept;

 private:
  explicit DepthStream(DepthPictures pictures);
  struct PicturePair {
    std::size_t before, after;
    double share;
  };
  PicturePair pictures_at(double time) const noexcept;
  std::size_t pixel_index(int column, int row) const noexcept {
    return static_cast<std::size_t>(column) +
           static_cast<std::size_t>(pictures_.camera.width) * static_cast<std::size_t>(row);
  }
  double depth_of(std::size_t pixel, const PicturePair& at) const noexcept;

  DepthPictures pictures_;
  glm::dvec3 low_{1}, high_{-1};
  std::uint64_t hash_ = 0;
  /// The newest result of surface_at(), and its picture.
  struct SurfaceCache {
    std::mutex lock;
    std::size_t picture = static_cast<std::size_t>(-1);
    std::shared_ptr<const MeshTree> tree;
  };
  mutable SurfaceCache surface_cache_;
};

}  // namespace trephine::haptics::depth
