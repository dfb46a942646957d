// Pictures of one camera in sequence: a recorded depth video, or a live one.
#pragma once

#include <cstdint>
#include <mutex>
#include <vector>

#include "haptics/depth/depth_camera.h"
#include "haptics/depth/depth_source.h"

namespace trephine::haptics::depth {

struct DepthPictures {
  DepthCamera camera;
  double mm_a_step = 0.1;                            ///< of a value
  std::vector<std::vector<std::uint16_t>> pictures;  ///< depths along z, row by row; 0: nothing was seen
  std::vector<double> times;                         ///< s, rising, the first 0
  bool is_repeating = false;
  double repeats_after = 0;  ///< s, where it is
};

/// Its surface is that of the pixels, joined to their neighbours; what lies behind it is taken for matter, so
/// that outlines are walls. Where nothing was seen there is nothing near. Between two pictures a pixel's
/// depth goes straight, where it is the same thing's.
class DepthStream final : public DepthSource {
 public:
  static constexpr double k_same = 40;  ///< mm from picture to picture: more is another thing
  /// Error: no camera, no pictures, or one of another size; times that do not rise.
  static volume::Result<std::shared_ptr<const DepthStream>> of(DepthPictures pictures);

  volume::Result<DepthSet> draw(const DepthView& view, int threads = 0) const override;
  bool is_moving(double time) const noexcept override;
  double turns_at(double time) const noexcept override;
  void bounds(glm::dvec3& low, glm::dvec3& high) const noexcept override { low = low_, high = high_; }
  std::uint64_t hash() const noexcept override { return hash_; }
  /// The nearest picture's surface as it was seen, without what lies behind outlines, and in no more pixels
  /// than a person sees; null where nothing was seen.
  std::shared_ptr<const MeshTree> look(double time) const override;
  const DepthPictures& pictures() const noexcept { return pictures_; }
  /// mm; 0: nothing is seen there then.
  double depth_at(int column, int row, double time) const noexcept;

 private:
  explicit DepthStream(DepthPictures pictures);
  struct Between {
    std::size_t before, after;
    double share;
  };
  Between between(double time) const noexcept;
  std::size_t number_of(int column, int row) const noexcept {
    return static_cast<std::size_t>(column) +
           static_cast<std::size_t>(pictures_.camera.width) * static_cast<std::size_t>(row);
  }
  double depth_of(std::size_t pixel, const Between& at) const noexcept;

  DepthPictures pictures_;
  glm::dvec3 low_{1}, high_{-1};
  std::uint64_t hash_ = 0;
  /// The newest look, and of which picture.
  struct Looked {
    std::mutex lock;
    std::size_t picture = static_cast<std::size_t>(-1);
    std::shared_ptr<const MeshTree> tree;
  };
  mutable Looked looked_;
};

}  // namespace trephine::haptics::depth
