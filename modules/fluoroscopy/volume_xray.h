// VolumeXray: X-ray images by line integrals through an operated scan and objects in it.
#pragma once

#include "haptics/mesh/mesh_tree.h"
#include "haptics/scene/touch_scene.h"
#include "modules/fluoroscopy/attenuation.h"
#include "modules/fluoroscopy/c_arm.h"
#include "modules/fluoroscopy/removed_matter.h"

namespace trephine::fluoroscopy {

/// Closed object in addition to the scan. It replaces the matter inside it.
struct XrayObject {
  std::shared_ptr<const haptics::MeshTree> tree;
  haptics::Placement placement;  ///< pose in the world
  double attenuation = 0;        ///< 1/mm
  bool is_of_scan = false;       ///< detached bone: attenuates like the scan where it was detached
};

/// Border of the scan through which a pixel's ray leaves the body, where the patient continues outside the
/// scan.
enum class Border : std::uint8_t {
  none,  ///< no border
  side,  ///< the ray leaves the scan within the body: pictures continue the soft tissue (sums_outside())
  end    ///< the ray passes beyond the first or last slice, which cuts the body: pictures show nothing
};
inline constexpr int k_tissue_from = -300;  ///< HU; voxels of at least this value are tissue

class VolumeXray {
 public:
  /// Prepares a scan in Hounsfield units; one pass over it. threads 0 = all cores.
  VolumeXray(std::shared_ptr<const volume::Volume> scan, double energy_kev, int threads = 0);

  /// Computes sums() for a view and a state. `version`: version of this scan, frozen or not. Any thread, but
  /// one at a time. For an unchanged view and method, only rays near changed blocks and rays through objects
  /// are traced again; the result has the same bits as that of a complete pass. Returns an error if an object
  /// reaches the plane through the source that is parallel to the detector; sums() is then unchanged.
  Status project(const View& view, std::shared_ptr<const volume::Version> version,
                 std::span<const XrayObject> objects, volume::RaySum method, int threads = 0);

  /// Returns the integral of attenuation along each pixel's ray, row by row of the whole view: the
  /// transmission is exp(-sum). 0 where collimators are closed.
  const std::vector<double>& sums() const noexcept { return sums_; }
  /// Returns an estimate of the attenuation along each pixel's ray outside the scan, so that pictures have no
  /// edges at the sides at which the scan cuts through the body. Continues the nearest border voxels (bone as
  /// soft tissue) over the scan's thickness along the beam, but not beyond the first and last slice. For
  /// pictures; not part of sums().
  std::vector<double> sums_outside(const View& view, int threads = 0) const;
  /// Returns for each pixel the border that its ray crosses, in the order of sums().
  std::vector<Border> borders(const View& view) const;

  struct Counters {
    std::int64_t full_rays = 0;     ///< traced through the whole scan
    std::int64_t renewed_rays = 0;  ///< traced again through removed matter
    std::int64_t object_rays = 0;   ///< rays that pass through objects
  };
  const Counters& counters() const noexcept { return counters_; }

 private:
  int beam_axis(const View& view) const;
  int body_axis() const;
  bool has_tissue_in_slice(int axis, int index) const;
  using BlockList = std::vector<const RemovedMatter::Blocks::value_type*>;
  static constexpr int k_tile = 16;  // pixels along the edge of a tile, which is updated as a whole

  volume::PixelBox pixels_of_block(const View& view, const std::array<int, 3>& block) const;
  void update_removed(const View& view, const std::vector<glm::ivec3>* changed, int threads);
  /// Returns the index of a pixel's tile.
  std::size_t tile_of(int column, int row) const noexcept {
    return static_cast<std::size_t>(column / k_tile) +
           static_cast<std::size_t>(tiles_across_) * static_cast<std::size_t>(row / k_tile);
  }
  /// Returns the integral of the operated scan's attenuation between two parameters of a ray.
  double operated_integral(const volume::Ray& ray, double from, double to, std::size_t tile) const;
  Status add_objects(const View& view, std::span<const XrayObject> objects, int threads,
                     std::vector<double>& sums);

  std::shared_ptr<const volume::Volume> scan_;
  volume::LineIntegrals lines_;
  RemovedMatter removed_;
  std::optional<View> view_;
  volume::RaySum method_ = volume::RaySum::exact;
  int tiles_across_ = 0;
  std::vector<BlockList> tiles_;                         ///< blocks that rays of each tile may meet
  std::vector<double> full_sums_, removed_sums_, sums_;  ///< uncut scan; removed matter; with objects
  Counters counters_;
};

}  // namespace trephine::fluoroscopy
