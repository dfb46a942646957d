// Automatic choice of a shape in a scan: threshold from the histogram, choice of connected parts, closing of
// thin walls.
#pragma once

#include <memory>

#include "volume/scan/shape.h"

namespace trephine::volume {

/// Returns Otsu's threshold, which divides the intensities into two classes with the largest variance between
/// the classes: the lowest value of the upper class. For scans without a calibrated intensity (MR).
int otsu_threshold(const Volume& volume);

/// Summary of the connected parts of a shape (26-connected voxels).
struct ShapeParts {
  std::int64_t largest = 0, second = 0, others = 0;  ///< voxels; others: all parts except the largest
  int count = 0;                                     ///< number of parts
  /// True if the second largest part, for example a table or a head holder, is large enough to hide the
  /// largest part: at least 0.5 % of its voxels.
  bool is_other_large() const noexcept {
    return static_cast<double>(second) >= 0.005 * static_cast<double>(largest) && second > 0;
  }
};
ShapeParts parts_of(const std::shared_ptr<const Volume>& volume, const Shape& shape);

/// Returns a copy without the parts of the shape other than the largest. The scan's voxels do not change. If
/// the shape is a window, removed parts become air in Volume::shape_voxels; if it is a label, they become
/// background. `summary`: all parts before the removal. Error if the shape has no voxel.
Result<Volume> keep_largest_part(const std::shared_ptr<const Volume>& volume, const Shape& shape,
                                 ShapeParts& summary);

enum class PartSize { large, any };

/// Returns a copy without the parts of a CT's shape outside the patient's body, such as a table or a head
/// holder. No tissue (-300 HU and above) connects these parts to the largest part. If there are such parts,
/// those are omitted as well that are at least 20 mm long, lie in air next to the body and touch it only in a
/// small area. Returns `volume` itself in these cases: the volume has no HU; the shape is a label or begins
/// below -300 HU; no part outside the body is large (0.5 % of the largest part, or 50 mm long); there is no
/// tissue around the largest part, as in a specimen. PartSize::any requires neither a large part nor tissue
/// around the largest part. Changes voxels as keep_largest_part(). `removed`: the removed parts; its
/// `largest` is the size of the largest kept part, or all members are 0 if nothing was removed.
Result<std::shared_ptr<const Volume>> omit_parts_outside_body(const std::shared_ptr<const Volume>& volume,
                                                              const Shape& shape, ShapeParts& removed,
                                                              PartSize size = PartSize::large);

/// Hysteresis threshold for windows: returns a copy with only those parts that contain an intensity of at
/// least `seed` and have at least `min_share` of the voxels of the largest part with such an intensity.
/// `removed`: the removed parts; its `largest` is the size of the largest kept part.
Result<Volume> keep_seeded_parts(const std::shared_ptr<const Volume>& volume, const Shape& shape, double seed,
                                 double min_share, ShapeParts& removed);

/// Closes walls that are thinner than the scan resolves and therefore below the threshold. Returns a copy in
/// which a shape voxel of at least `low` is raised to `high` if all these conditions hold:
/// - It is in a gap of the shape that a ball of `reach_mm` cannot enter. The test is a morphological closing
/// in
///   which the outside is dilated by half a voxel less than the solid: a hole in a sheet of one voxel has no
///   depth, and an exact closing could leave it open.
/// - There is solid on two opposite sides within `reach_mm`, so that outer surfaces do not move.
/// - Along at least 3 of 13 lines it is brighter than both sides by half the difference between the shape's
///   threshold and `low`, as in a wall but not in the gap of a joint.
///
/// `filled`: number of raised voxels.
Result<Volume> fill_thin_walls(const Volume& volume, const Shape& shape, double low, double high,
                               double reach_mm, std::int64_t& filled);

}  // namespace trephine::volume
