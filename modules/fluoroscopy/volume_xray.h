// X-ray images by line integrals: through a scan as it was operated on, and things in it.
#pragma once

#include "haptics/mesh/mesh_tree.h"
#include "haptics/scene/touch_scene.h"
#include "modules/fluoroscopy/attenuation.h"
#include "modules/fluoroscopy/c_arm.h"
#include "modules/fluoroscopy/removed_matter.h"

namespace trephine::fluoroscopy {

/// A closed object in addition to the scan. It replaces the matter where it is.
struct Thing {
  std::shared_ptr<const haptics::MeshTree> tree;
  haptics::Placement place;
  double attenuation = 0;   ///< 1/mm
  bool is_of_scan = false;  ///< it came off: it attenuates as the untouched scan does where it was
};

/// Places where a ray passes the scan's border within the body: nowhere; at a side, where pictures let soft
/// tissue go on (beyond()); at the first or last slice, where they show nothing.
enum class Border : std::uint8_t { none, side, end };
inline constexpr int k_tissue_from = -300;  ///< HU, at the border

class VolumeXray {
 public:
  /// Prepares a scan in Hounsfield units; one pass over it. threads 0 = all cores.
  VolumeXray(std::shared_ptr<const volume::Volume> scan, double energy_kev, int threads = 0);

  /// Makes sums() those of this view and state: `version` of this scan, frozen or not: any thread. What is
  /// the same as the last time is kept: of an unchanged view only rays through changed blocks and through
  /// things are traced again, with the bits of a whole image. Error when a thing reaches the source, the
  /// image then as it was.
  volume::Status project(const View& view, std::shared_ptr<const volume::Version> version,
                         std::span<const Thing> things, volume::RaySum how, int threads = 0);

  /// The integral of attenuation along each pixel's ray, row by row of the whole view: exp(-sum) of the
  /// radiation passes. 0 where collimators are closed.
  const std::vector<double>& sums() const noexcept { return sums_; }
  /// Attenuation of the body outside the scan, where its sides cut through it, so that no walls are
  /// seen there: as thick as the scan along the beam, what is nearest at the border goes on, bone as soft
  /// tissue. Beyond the first and last slice nothing does. For pictures; no part of sums().
  std::vector<double> beyond(const View& view, int threads = 0) const;
  /// By pixels, in the same order.
  std::vector<Border> borders(const View& view) const;

  struct Counters {
    std::int64_t full_rays = 0;     ///< traced through the whole scan
    std::int64_t renewed_rays = 0;  ///< of which the removed part was traced
    std::int64_t thing_rays = 0;    ///< that pass things
  };
  const Counters& counters() const noexcept { return counters_; }

 private:
  int beam_axis(const View& view) const;
  int body_axis() const;
  bool is_cut_at(int axis, int index) const;
  using BlockList = std::vector<const RemovedMatter::Blocks::value_type*>;
  static constexpr int k_tile = 16;  // pixels along the edge of what is renewed together

  volume::PixelBox shadow(const View& view, const std::array<int, 3>& block) const;
  void renew_removed(const View& view, const std::vector<glm::ivec3>* changed, int threads);
  /// Blocks that rays of a tile may meet.
  std::size_t tile_of(int column, int row) const noexcept {
    return static_cast<std::size_t>(column / k_tile) +
           static_cast<std::size_t>(tiles_across_) * static_cast<std::size_t>(row / k_tile);
  }
  double anatomy(const volume::Ray& ray, double from, double to, std::size_t tile) const;
  volume::Status add_things(const View& view, std::span<const Thing> things, int threads,
                            std::vector<double>& sums);

  std::shared_ptr<const volume::Volume> scan_;
  volume::LineIntegrals lines_;
  RemovedMatter removed_;
  std::optional<View> view_;
  volume::RaySum how_ = volume::RaySum::exact;
  int tiles_across_ = 0;
  std::vector<BlockList> tiles_;
  std::vector<double> whole_, taken_, sums_;  ///< of the untouched scan; of what was removed; all together
  Counters counters_;
};

}  // namespace trephine::fluoroscopy
