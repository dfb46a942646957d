// Distance field for the middle of a round tool: the distance to a solid, less the tool's radius, near that
// offset surface.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "volume/field.h"
#include "volume/occupancy.h"
#include "volume/sample_brick.h"
#include "volume/soft_field.h"
#include "volume/traversal.h"
#include "volume/version.h"

namespace trephine::volume {

/// u = radius - distance to the smooth solid of a shape and its cuts (mm): positive where the tool's middle
/// must not be. Sampled on a lattice of its own (step_for), in bricks that exist only near u = 0; elsewhere
/// +-far_mm(). Distances are exact to about a thousandth of a step where the nearest point is unique.
/// Immutable; updates share the bricks that they do not change.
class OffsetField {
 public:
  /// Cost of a build.
  struct Work {
    std::size_t samples = 0;  ///< points of the surface
    std::size_t cells = 0;    ///< reached by their distance
    double seconds = 0;
  };

  /// The lattice's step (mm) for a ball in a volume: a twelfth of its radius where the voxels are as fine;
  /// where they are not, as fine as they are; where they are coarse, so fine that around a sharp tip of the
  /// solid, where the offset surface bends most, splines of its samples are off by less than 0.1 mm and 2 %:
  /// in volumes to 270 mm along each side for a ball of 0.5 mm, 400 for one of 1 mm. Larger ones get coarser
  /// steps.
  static double step_for(double radius_mm, const Volume& volume) noexcept;
  /// Builds for the whole volume. `version` null: untouched; `soft`: the shape's smooth field. Error when the
  /// radius is not above 0 and at most 20 mm, or larger than the volume. threads 0 = all.
  static Result<std::shared_ptr<const OffsetField>> build(const Field& field, const Occupancy& bits,
                                                          const Version* version, double radius_mm,
                                                          int threads = 0, Work* work = nullptr,
                                                          const SoftField* soft = nullptr);
  /// Updates after voxels low .. high were cut, and none put back: nowhere larger than before, so that a
  /// tool that was free stays free. Any thread but the servo's.
  std::shared_ptr<const OffsetField> updated(const Field& field, const Occupancy& bits,
                                             const Version& version, const VoxelBox& changed, int threads = 1,
                                             Work* work = nullptr, const SoftField* soft = nullptr) const;

  const Frame& frame() const noexcept { return frame_; }  ///< of the lattice
  const glm::ivec3& size() const noexcept { return size_; }
  double radius_mm() const noexcept { return radius_; }
  double step_mm() const noexcept { return step_; }
  double far_mm() const noexcept { return far_; }
  std::size_t bytes() const noexcept;

  bool contains(const glm::ivec3& v) const noexcept {
    return v.x >= 0 && v.y >= 0 && v.z >= 0 && v.x < size_.x && v.y < size_.y && v.z < size_.z;
  }
  /// u at a lattice point; beyond the lattice nothing is solid.
  double at(int x, int y, int z) const noexcept;
  /// Samples around lattice point v.
  void load(const glm::ivec3& v, QuadraticPatch& patch) const noexcept;
  /// Is every sample that the cube of v reads far from the solid?
  bool is_free_around(const glm::ivec3& v) const noexcept;
  /// Lattice points low .. high around v that are all free; v alone, or nothing (low > high), where that is
  /// near.
  VoxelBox free_box(const glm::ivec3& v) const noexcept;

 private:
  class Builder;
  friend class OffsetChanges;

  OffsetField() = default;
  glm::ivec3 steps_within(double mm) const noexcept;
  /// 4 x 4 x 4 bricks, shared by the fields that an operation leaves behind.
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
  /// While it is made: every page that holds bricks low .. high is this field's own.
  void own_pages(const glm::ivec3& low, const glm::ivec3& high);
  SampleSlot& own_slot(const glm::ivec3& b) noexcept {
    return pages_[page_index(b)]->entries[slot_in_page(b)];
  }

  Frame frame_;
  glm::ivec3 size_{0}, slots_size_{0}, pages_size_{0};
  double radius_ = 0, step_ = 0, far_ = 0;
  std::vector<std::shared_ptr<Page>> pages_;  ///< not written once the field is handed out
};

}  // namespace trephine::volume
