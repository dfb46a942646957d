// Automatic choice of the shape in a scan: where its histogram parts, and its largest part.
#pragma once

#include <memory>

#include "volume/shape.h"

namespace trephine::volume {

/// Otsu's threshold: the lowest value of the upper of two classes that differ most. Of scans whose values say
/// nothing by themselves (MR).
int otsu_threshold(const Volume& volume);

/// Parts of a shape (voxels that touch, corners included).
struct ShapeParts {
  std::int64_t largest = 0, second = 0, others = 0;  ///< voxels; others: of all but the largest
  int count = 0;                                     ///< of parts
  /// Is another part so large that it may hide the largest: a table, a head holder?
  bool is_other_large() const noexcept {
    return count >= 2 && static_cast<double>(second) >= 0.005 * static_cast<double>(largest);
  }
};
ShapeParts parts_of(const std::shared_ptr<const Volume>& volume, const Shape& shape);

/// A copy without the shape's other parts. The scan's voxels stay as they are: a part of a window becomes air
/// in Volume::shape_voxels, a part of a label becomes background in the labels.
Result<Volume> with_largest_part(const std::shared_ptr<const Volume>& volume, const Shape& shape,
                                 ShapeParts& parts);

/// Variant in which only parts stay that hold a value of `seed` and more (hysteresis: from the shape's
/// lower end on, what hangs together with something certain) and are at least this share of the largest of
/// those. Of windows.
Result<Volume> with_seeded_parts(const std::shared_ptr<const Volume>& volume, const Shape& shape, double seed,
                                 double least_share, ShapeParts& gone);

/// Walls thinner than a scan can show fall below the threshold. A copy whose shape voxels of `from` and
/// above, in gaps of the shape that a ball of `reach_mm` cannot enter, are lifted to `to`; counts them. (The
/// shape's closing, half a voxel more generous: a hole in a sheet of one voxel has no depth to be kept out
/// of; and only with solid on two opposite sides, so that outer sides stay where they are; and only what
/// stands out by half of what `from` lies below the shape, on two other sides: a wall, not the gap of a
/// joint.)
Result<Volume> with_thin_filled(const Volume& volume, const Shape& shape, double from, double to,
                                double reach_mm, std::int64_t& filled);

}  // namespace trephine::volume
