// Removal of what a moving ball, or another body of revolution, sweeps: the edit under every burr and saw.
#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <span>
#include <vector>

#include "volume/field.h"
#include "volume/removal_kernels.h"
#include "volume/solid_parts.h"
#include "volume/tool_body.h"
#include "volume/traversal.h"
#include "volume/version.h"

namespace trephine::volume {

/// A ball of `radius_mm` moved along a straight line, world frame. It leaves its own hole, to be touched and
/// seen, where the version's lattice was made for such a radius; a smaller one is cut as far as the lattice
/// shows it.
struct Sweep {
  glm::dvec3 start_world{0.0};
  glm::dvec3 end_world{0.0};
  double radius_mm = 1;
  /// The ball was swept to `start_world` before, in this editor's state: what lies behind is done.
  bool continues = false;
};

/// Changes of one sweep.
struct RemovalReport {
  std::int64_t removed_units = 0;  ///< newly removed solid points, RemovalLedger units
  int bricks_changed = 0;
  VoxelBox box{glm::ivec3(0), glm::ivec3(-1)};  ///< voxels that may have changed; empty when low > high
  /// Sums over those points of what the voxels around them hold (as it is stored; below 0 counts as 0), and
  /// of its square: how dense it was.
  double intensity_sum = 0, intensity_square_sum = 0;
};

/// Adds one report to another.
void add(RemovalReport& sum, const RemovalReport& one) noexcept;
/// The smallest box that holds both; empty boxes (low > high) add nothing.
VoxelBox united(const VoxelBox& a, const VoxelBox& b) noexcept;

/// Shape to remove without a closed form for the kernels: given by the distances of samples, brick by
/// brick.
class RemovalField {
 public:
  static constexpr int k_edge = k_brick + 2;  ///< of a brick and the samples around it
  /// mm within the band, below 0 where a sample goes; x fastest.
  using Distances = std::array<float, k_edge * k_edge * k_edge>;
  enum class Reach : std::uint8_t {
    none,  ///< no sample of the brick is within the band of it
    some,
    all  ///< it and all around it goes, whole
  };
  virtual ~RemovalField() = default;
  /// Distances in the brick that begins at sample `low`.
  virtual Reach find(const glm::ivec3& low, double band, Distances& mm) = 0;
};

struct SweptShape;

/// Makes new versions from old ones. One thread (the edit thread). Removal is a union: applying sweeps again
/// or in another order gives the same masks, ledger and kept bits.
class RemovalEditor {
 public:
  /// `solids`: a point counts as removed matter when any of these fields is >= 0 there. Borrows their
  /// volume.
  /// `kernels`: which variant of the inner loops; all give the same bits.
  RemovalEditor(std::shared_ptr<const Version> start, std::vector<Field> solids,
                const RemovalKernels& kernels = best_removal_kernels());
  /// A second editor that goes on from here on its own. Between strokes, with everything published.
  RemovalEditor(const RemovalEditor& other);
  RemovalEditor& operator=(const RemovalEditor& other);
  RemovalEditor(RemovalEditor&&) = default;
  RemovalEditor& operator=(RemovalEditor&&) = default;

  /// Edits the working state; readers see nothing until publish().
  RemovalReport remove(const Sweep& sweep);
  /// Sweeps any body of revolution, which turns on the way: the union of places so near to each other (a
  /// quarter of the lattice's finest step) that what stands between them is under a micrometre on a burr of
  /// that lattice. A ball goes the way above.
  RemovalReport remove(const ToolSweep& sweep);

  /// As what matter is counted that goes.
  enum class Ledger : std::uint8_t { removed, freed };
  /// Removes what a field gives, linear between samples, in the bricks of these samples.
  RemovalReport remove(RemovalField& field, const VoxelBox& samples, Ledger ledger = Ledger::removed);

  /// Takes whole parts away: what lies nearer to samples of parts that go (`goes`, a byte a part) than to
  /// those of others, and within the band of them, near these voxels. The surface of what stays does not
  /// change where a sample of air is between them, and nothing that stays is within a step of what goes. Its
  /// matter counts as freed, not as removed. `parts` are those of the working state.
  RemovalReport take_out(const SolidParts& parts, const std::vector<std::uint8_t>& goes,
                         const VoxelBox& voxels);
  /// The working state as an immutable version. Masks keep changing in place until end_stroke().
  std::shared_ptr<const Version> publish();
  /// From here on masks of published versions are never written again.
  void end_stroke() noexcept;
  /// The working state as a version that readers on any thread may keep and read whole, in the middle of a
  /// stroke too. Changes no bits: the stroke goes on unaffected, on copies of the masks that it
  /// touches.
  std::shared_ptr<const Version> freeze() {
    end_stroke();
    return publish();
  }
  /// Goes on from another version (undo, redo).
  void reset(std::shared_ptr<const Version> start);

  const Version& working() const noexcept { return *next_; }
  /// Tests for matter at a point (world frame), as it is touched: of the scan, and not removed.
  bool is_matter(const glm::dvec3& p_world) const noexcept;

 private:
  /// The brick at sample `s`, to be written; whole regions, pages and bricks of older versions are copied.
  Ref<Brick>& editable_slot(const glm::ivec3& s);
  /// The brick of sample s, its own, after the sweep.
  Brick& swept_brick(const glm::ivec3& s, const BrickSweep& sweep);
  RemovalMask& editable_mask(Brick& brick, int n);
  void classify(RemovalMask& mask, const glm::ivec3& low) const;
  /// Possible changes lie within `reach` (mm) of the box of these ends.
  RemovalReport remove(const SweptShape& shape, std::span<const glm::dvec3> ends_world, double reach);
  void remove_in_brick(const SweptShape& shape, const glm::ivec3& low, RemovalReport& report);

  void mark_cells(const SweptShape& shape, const BrickSweep& sweep, const glm::vec3& corner,
                  const glm::ivec3& low, const Brick* old, Brick*& brick, RemovalReport& report);
  /// Updates the cells of a brick that `cells` names, with masks of so many words a cell.
  template <std::size_t Words>
  void mark_cells_of(const SweptShape& shape, const BrickSweep& sweep, const glm::vec3& corner,
                     const glm::ivec3& low, const std::array<std::uint64_t, k_brick>& cells,
                     RemovalMask& mask, RemovalReport& report);

  void remove_in_brick(RemovalField& field, const glm::ivec3& low, Ledger ledger, RemovalReport& report);
  template <std::size_t Words>
  void take_points(const RemovalField::Distances& mm, const glm::ivec3& low, RemovalMask& mask, Ledger ledger,
                   RemovalReport& report);
  /// Marks `points` (n^3 bits, left as those that are new) of the cell as removed; false when none was new.
  template <std::size_t Words>
  static bool mark(RemovalMask& mask, std::size_t in_brick, std::array<std::uint64_t, Words>& points);

  std::int64_t count_solid(const RemovalMask& mask, const glm::ivec3& sample, std::size_t in_brick,
                           const std::uint64_t* fresh) const;
  /// Adds those of a cell that were solid to the report, and to the ledger.
  void count(const RemovalMask& mask, const glm::ivec3& sample, std::size_t in_brick,
             const std::uint64_t* fresh, Ledger ledger, RemovalReport& report);

  /// Number over all editors, so that masks that they share are never written by two.
  static std::uint64_t next_stroke() noexcept;

  std::shared_ptr<Version> next_;
  std::vector<Field> solids_;
  const RemovalKernels* kernels_;
  std::shared_ptr<const std::array<CellPoints, 2>> points_;  ///< 4^3 and 8^3 a cell
  std::uint64_t stroke_ = next_stroke();                     ///< whose masks may be written in place
  std::shared_ptr<std::atomic<std::uint64_t>> frozen_strokes_ =
      std::make_shared<std::atomic<std::uint64_t>>(0);
};

}  // namespace trephine::volume
