// Automatic choice of a shape in a scan: threshold from the histogram, choice of connected parts, closing of
// thin walls.
#pragma once

#include <memory>

#include "volume/scan/shape.h"

namespace trephine::volume {

/// Returns Otsu's threshold: the lowest value of the upper class, for the largest variance between two
/// classes. For scans without a calibrated intensity (MR).
int otsu_threshold(const Volume& volume);

/// Summary of the connected parts of a shape (26-connected voxels).
struct ShapeParts {
  std::int64_t largest = 0, second = 0, others = 0;  ///< voxels; others: all parts except the largest
  int count = 0;                                     ///< number of parts
  /// True if the second largest part is large enough to hide the largest, such as a table or a head holder.
  bool is_other_large() const noexcept {
    return static_cast<double>(second) >= 0.005 * static_cast<double>(largest) && second > 0;
  }
};
ShapeParts parts_of(const std::shared_ptr<const Volume>& volume, const Shape& shape);

/// Returns a copy without the parts of the shape other than the largest. The scan's voxels do not change: a
/// removed part of a window becomes air in Volume::shape_voxels; one of a label becomes background.
Result<Volume> keep_largest_part(const std::shared_ptr<const Volume>& volume, const Shape& shape,
                                 ShapeParts& parts);

enum class PartSize { large, any };

/// Returns a copy without the parts of a CT's shape outside the patient's body, such as a table or a head
/// holder: no tissue (-300 HU and above) connects them to the largest part. Returns `volume` itself for other
/// volumes and shapes, if no such part is large (0.5 % of the largest part, or 50 mm long), or if there is no
/// tissue around the largest part, as in a specimen. PartSize::any requires neither a large part nor tissue
/// around the largest part. Changes voxels as keep_largest_part().
Result<std::shared_ptr<const Volume>> omit_parts_outside_body(const std::shared_ptr<const Volume>& volume,
                                                              const Shape& shape, ShapeParts& removed,
                                                              PartSize size = PartSize::large);

/// Hysteresis threshold for windows: returns a copy with only those parts that contain an intensity of at
/// least `seed` and have at least `min_share` of the largest such part's voxels. `removed`: the removed
/// parts, and in `largest` the largest kept one.
Result<Volume> keep_seeded_parts(const std::shared_ptr<const Volume>& volume, const Shape& shape, double seed,
                                 double min_share, ShapeParts& removed);

/// Closes walls that are thinner than the scan resolves and therefore below the threshold. Returns a copy in
/// which shape voxels of at least `low` are raised to `high` if all of these hold: they are in gaps of the
/// shape that a ball of `reach_mm` cannot enter (a closing, half a voxel more generous, since a hole in a
/// sheet of one voxel has no depth); there is solid on two opposite sides, so that outer surfaces do not
/// move; and they are brighter than both sides along other lines by half the difference between the shape's
/// threshold and `low`, as in a wall but not in the gap of a joint. `filled`: number of raised voxels.
Result<Volume> fill_thin_walls(const Volume& volume, const Shape& shape, double low, double high,
                               double reach_mm, std::int64_t& filled);

}  // namespace trephine::volume
