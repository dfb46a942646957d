// OffsetField: signed distance of the centre of a round tool to the offset surface, which lies at the tool's
// radius from a solid.
#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <vector>

#include "volume/cuts/version.h"
#include "volume/fields/crease_sheets.h"
#include "volume/fields/sample_brick.h"
#include "volume/fields/soft_field.h"
#include "volume/scan/field.h"
#include "volume/scan/occupancy.h"
#include "volume/scan/traversal.h"

namespace trephine::volume {

/// u = radius - distance to the smooth solid of a shape, less its cuts (mm): positive where the tool's centre
/// must not be. Sampled on its own lattice (step_for()), in bricks near u = 0; elsewhere u is +-far_mm(). If
/// the nearest point is unique, the distance is exact to about a thousandth of a step. At concave creases the
/// nearest point is not unique; there, sheets (CreaseSheets) have the distances to each flank. Immutable;
/// updates share unchanged bricks.
class OffsetField {
 public:
  /// Cost of a build.
  struct Work {
    std::size_t samples = 0;  ///< sampled surface points
    std::size_t cells = 0;    ///< lattice points with a computed distance
    std::size_t creased = 0;  ///< creased cubes
    double seconds = 0;
  };

  /// Returns the step of the lattice (mm) for a ball in a volume: the smallest spacing of the voxels, or less
  /// if the error of splines would exceed 0.1 mm plus 2 % of the radius around a sharp tip of the solid,
  /// where the offset surface has its largest curvature. The step is up to 32 % smaller if a small tool then
  /// has sheets. It is at least a twelfth of the radius. It is also limited in volumes above 270 mm along
  /// each side (radius 0.5 mm) or 400 mm (radius 1 mm); there, errors are larger if the voxels are coarse.
  static double step_for(double radius_mm, const Volume& volume) noexcept;
  /// Builds the field of the whole volume. `version` null: no cuts; `soft`: the shape's smooth field or null.
  /// Error unless the radius is above 0, at most 20 mm, and no larger than the volume, and if `is_cancelled`
  /// becomes true during the build. threads 0 = all cores.
  static Result<std::shared_ptr<const OffsetField>> build(const Field& field, const Occupancy& bits,
                                                          const Version* version, double radius_mm,
                                                          int threads = 0, Work* work = nullptr,
                                                          const SoftField* soft = nullptr,
                                                          const std::atomic<bool>* is_cancelled = nullptr);
  /// Returns the field after cuts in the voxels of `changed`; nothing may have been restored. u never
  /// increases, so that a free tool stays free. Any thread except the servo thread.
  std::shared_ptr<const OffsetField> updated(const Field& field, const Occupancy& bits,
                                             const Version& version, const VoxelBox& changed, int threads = 1,
                                             Work* work = nullptr, const SoftField* soft = nullptr) const;

  const Frame& frame() const noexcept { return frame_; }  ///< world frame of the lattice
  const glm::ivec3& size() const noexcept { return size_; }
  double radius_mm() const noexcept { return radius_; }
  double step_mm() const noexcept { return step_; }
  double far_mm() const noexcept { return far_; }
  std::size_t bytes() const noexcept;

  bool contains(const glm::ivec3& v) const noexcept {
    return v.x >= 0 && v.y >= 0 && v.z >= 0 && v.x < size_.x && v.y < size_.y && v.z < size_.z;
  }
  /// u (mm) at a lattice point; -far_mm() (free) beyond the lattice.
  double at(int x, int y, int z) const noexcept;
  /// Returns the sheets (one bit each) of a creased cube; 0 for other cubes, in which the field alone
  /// determines the solid.
  CreaseSheets::Mask sheets_at(const glm::ivec3& v) const noexcept {
    return sheets_ ? sheets_->sheets_at(v) : 0;
  }
  /// Returns true if the field may have creased cubes.
  bool has_sheets() const noexcept { return sheets_ != nullptr; }
  /// u (mm) of a sheet of a creased cube at one of the cube's lattice points. Limited to u of the field:
  /// updates after a removal reduce only the field, and the limit applies the removal to every sheet.
  double sheet_at(int sheet, const glm::ivec3& cube, const glm::ivec3& v) const noexcept;
  /// Loads the 27 samples of a sheet of the creased cube around lattice point v.
  void load_sheet(int sheet, const glm::ivec3& v, QuadraticPatch& patch) const noexcept;
  /// Loads the 27 samples around lattice point v.
  void load(const glm::ivec3& v, QuadraticPatch& patch) const noexcept;
  /// Returns true if all 27 samples around v are in bricks without data, far from the solid.
  bool is_free_around(const glm::ivec3& v) const noexcept;
  /// Returns a box of lattice points around v in which is_free_around() is true for every point: most of v's
  /// brick, or only v. Empty (low > high) if is_free_around() is false for v.
  VoxelBox free_box(const glm::ivec3& v) const noexcept;

 private:
  class Builder;
  friend class OffsetChanges;

  OffsetField() = default;
  glm::ivec3 steps_within(double mm) const noexcept;
  /// 4 x 4 x 4 bricks, shared by successive fields.
  struct Page {
    std::array<SampleSlot, 64> entries;
  };
  std::size_t page_index(const glm::ivec3& b) const noexcept {
    return static_cast<std::size_t>((b.x >> 2) + pages_size_.x * ((b.y >> 2) + pages_size_.y * (b.z >> 2)));
  }
  static std::size_t slot_in_page(const glm::ivec3& b) noexcept {
    return static_cast<std::size_t>((b.x & 3) | (b.y & 3) << 2 | (b.z & 3) << 4);
  }
  const SampleSlot& slot(const glm::ivec3& b) const noexcept {
    return pages_[page_index(b)]->entries[slot_in_page(b)];
  }
  /// Copies the pages of bricks low .. high, for writing during a build.
  void copy_pages(const glm::ivec3& low, const glm::ivec3& high);
  SampleSlot& writable_slot(const glm::ivec3& b) noexcept {
    return pages_[page_index(b)]->entries[slot_in_page(b)];
  }

  Frame frame_;
  glm::ivec3 size_{0}, slots_size_{0}, pages_size_{0};
  double radius_ = 0, step_ = 0, far_ = 0;
  std::vector<std::shared_ptr<Page>> pages_;  ///< never written after the build
  std::shared_ptr<CreaseSheets> sheets_;      ///< of the complete build; null: no creased cubes
};

}  // namespace trephine::volume
