// RemovalEditor: removes the sweep of a ball or another body of revolution, for burrs, drills and saws.
#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <span>
#include <vector>

#include "volume/cuts/tool_body.h"
#include "volume/cuts/version.h"
#include "volume/scan/field.h"
#include "volume/scan/traversal.h"

namespace trephine::volume {

class SolidParts;
struct BrickSweep;
struct CellPoints;
struct RemovalKernels;
/// Returns the widest variant of the inner loops that this CPU supports.
const RemovalKernels& best_removal_kernels() noexcept;

/// Sweep of a ball of `radius_mm` along a straight line, world frame. The hole is resolved if the version's
/// lattice was made for balls of this radius or smaller; otherwise it is as coarse as the lattice.
struct Sweep {
  glm::dvec3 start_world{0.0};
  glm::dvec3 end_world{0.0};
  double radius_mm = 1;
  /// True if the editor already swept this ball up to `start_world`; cells behind that point are not
  /// processed again.
  bool continues = false;
};

/// Changes of one sweep.
struct RemovalReport {
  std::int64_t removed_units = 0;  ///< newly removed solid points, in units of RemovalLedger
  int bricks_changed = 0;
  VoxelBox box{glm::ivec3(0),
               glm::ivec3(-1)};  ///< voxels of the scan that may have changed; empty when low > high
  /// Sums over `removed_units` of the intensity of each unit's voxel (as stored; below 0 counts as 0) and of
  /// its square, for mean and variance of the density of the removed matter; 0 for Ledger::freed.
  double intensity_sum = 0, intensity_square_sum = 0;
};

/// Adds `report` to `sum`.
void add(RemovalReport& sum, const RemovalReport& report) noexcept;
/// Returns the smallest box that contains both; empty boxes (low > high) are ignored.
VoxelBox union_of(const VoxelBox& a, const VoxelBox& b) noexcept;

/// Shape to remove other than a swept body: computes the distances of samples brick by brick.
class RemovalField {
 public:
  static constexpr int k_edge = k_brick + 2;  ///< samples along a brick's edge, and one more at each end
  /// Signed distances in mm, clamped to the band; negative where a sample is to be removed. x fastest.
  using Distances = std::array<float, k_edge * k_edge * k_edge>;
  enum class Reach : std::uint8_t {
    none,  ///< no sample of the brick is within the band of the shape
    some,  ///< `mm` has the distances
    all    ///< `mm` has the distances; the whole brick and everything near it is removed
  };
  virtual ~RemovalField() = default;
  /// Computes the distances for the brick whose first sample is `low`. `band`: mm.
  virtual Reach find(const glm::ivec3& low, double band, Distances& mm) = 0;
};

struct SweptShape;

/// Makes new versions from old ones. For one thread (the edit thread). Removal is a union: repeating sweeps
/// or applying them in another order gives the same masks, ledger and kept bits.
class RemovalEditor {
 public:
  /// `solids`: a removed point counts as matter if any of these fields is >= 0 there. The editor borrows the
  /// volume of the fields. `kernels`: variant of the inner loops; all variants give the same bits.
  RemovalEditor(std::shared_ptr<const Version> start, std::vector<Field> solids,
                const RemovalKernels& kernels = best_removal_kernels());
  /// Makes an independent editor of the same state. Requires that `other` ended its
  /// stroke and published all edits.
  RemovalEditor(const RemovalEditor& other);
  RemovalEditor& operator=(const RemovalEditor& other);
  RemovalEditor(RemovalEditor&&) = default;
  RemovalEditor& operator=(RemovalEditor&&) = default;

  /// Edits the working state; readers do not see it before publish().
  RemovalReport remove(const Sweep& sweep);
  /// Sweeps a body of revolution that may turn: removes the union of poses between which no point
  /// of the body moves more than a quarter of the lattice's finest step. The ridges between poses are lower
  /// than 1/500 of that step where the surface is not more curved than the burr for which the lattice was
  /// made. A ball is passed to remove(const Sweep&).
  RemovalReport remove(const ToolSweep& sweep);

  /// Account of the removed matter: removed by a tool, or freed as part of a detached body.
  enum class Ledger : std::uint8_t { removed, freed };
  /// Removes the matter in which `field` is at most 0 (trilinear between samples), in the bricks that contain
  /// any of `samples`.
  RemovalReport remove(RemovalField& field, const VoxelBox& samples, Ledger ledger = Ledger::removed);

  /// Removes whole parts of the working state. `parts`: all parts of that state; `is_removed`: one byte per
  /// part; `voxels`: box around the removed parts. Removes each point that is nearer to a sample of a removed
  /// part than to any sample of a kept part, and at most a band away from the former. The surface of kept
  /// parts does not change if a sample of air separates them from removed parts and no kept matter is within
  /// a step of the removed parts. The matter counts as freed, not as removed.
  RemovalReport remove_parts(const SolidParts& parts, const std::vector<std::uint8_t>& is_removed,
                             const VoxelBox& voxels);
  /// Returns the working state as a version. The masks of that version may change until end_stroke();
  /// freeze() returns a version that never changes.
  std::shared_ptr<const Version> publish();
  /// Ends the stroke: masks of published versions are never written again.
  void end_stroke() noexcept;
  /// Returns the working state as a version that any thread may keep and read completely, also during a
  /// stroke. Later sweeps of the stroke change copies of the masks, and their results are as without
  /// freeze().
  std::shared_ptr<const Version> freeze() {
    end_stroke();
    return publish();
  }
  /// Continues from another version (undo, redo).
  void reset(std::shared_ptr<const Version> start);

  const Version& working() const noexcept { return *next_; }
  /// Returns true if a point (world frame) is solid in the scan and not removed.
  bool is_matter(const glm::dvec3& p_world) const noexcept {
    return !is_removed(p_world) && is_solid_in_scan(p_world);
  }
  /// Returns true if a point (world frame) is solid in the scan, and was removed.
  bool is_removed_matter(const glm::dvec3& p_world) const noexcept {
    return is_removed(p_world) && is_solid_in_scan(p_world);
  }

 private:
  bool is_solid_in_scan(const glm::dvec3& p_world) const noexcept;
  bool is_removed(const glm::dvec3& p_world) const noexcept {
    return !(next_->distance(next_->base().frame.volume_from_world(p_world)) > 0);
  }
  /// Returns the writable slot of the brick at sample `s`; copies regions and pages of older versions.
  Ref<Brick>& editable_slot(const glm::ivec3& s);
  /// Returns the writable brick of sample `s` with the distances of the sweep.
  Brick& swept_brick(const glm::ivec3& s, const BrickSweep& sweep);
  RemovalMask& editable_mask(Brick& brick, int n);
  void classify(RemovalMask& mask, const glm::ivec3& low) const;
  /// `reach`: largest distance (mm) of a change from the bounding box of `ends_world`.
  RemovalReport remove(const SweptShape& shape, std::span<const glm::dvec3> ends_world, double reach);
  void remove_in_brick(const SweptShape& shape, const glm::ivec3& low, RemovalReport& report);

  void mark_cells(const SweptShape& shape, const BrickSweep& sweep, const glm::vec3& corner,
                  const glm::ivec3& low, const Brick* old, Brick*& brick, RemovalReport& report);
  /// Updates the cells of a brick that are set in `cells`, with masks of `Words` words per cell.
  template <std::size_t Words>
  void mark_cells_of(const SweptShape& shape, const BrickSweep& sweep, const glm::vec3& corner,
                     const glm::ivec3& low, const std::array<std::uint64_t, k_brick>& cells,
                     RemovalMask& mask, RemovalReport& report);

  void remove_in_brick(RemovalField& field, const glm::ivec3& low, Ledger ledger, RemovalReport& report);
  template <std::size_t Words>
  void mark_points(const RemovalField::Distances& mm, const glm::ivec3& low, RemovalMask& mask, Ledger ledger,
                   RemovalReport& report);
  /// Marks `points` (n^3 bits) of the cell as removed and reduces them to the new ones; false if no point is
  /// new.
  template <std::size_t Words>
  static bool mark(RemovalMask& mask, std::size_t in_brick, std::array<std::uint64_t, Words>& points);

  std::int64_t count_solid(const RemovalMask& mask, const glm::ivec3& sample, std::size_t in_brick,
                           const std::uint64_t* fresh) const;
  /// Adds the solid ones among the newly removed points of a cell to the report and, if a tool removed them,
  /// to the ledger.
  void count(const RemovalMask& mask, const glm::ivec3& sample, std::size_t in_brick,
             const std::uint64_t* fresh, Ledger ledger, RemovalReport& report);

  /// Returns a number unique over all editors, so that no two editors write a shared mask.
  static std::uint64_t next_stroke() noexcept;

  std::shared_ptr<Version> next_;
  std::vector<Field> solids_;
  const RemovalKernels* kernels_;
  std::shared_ptr<const std::array<CellPoints, 2>> points_;  ///< 4^3 and 8^3 per cell
  std::uint64_t stroke_ = next_stroke();                     ///< masks of this stroke are written in place
  /// Last stroke that this editor ended; shared with its versions (Version::is_frozen()).
  std::shared_ptr<std::atomic<std::uint64_t>> frozen_strokes_ =
      std::make_shared<std::atomic<std::uint64_t>>(0);
};

}  // namespace trephine::volume
