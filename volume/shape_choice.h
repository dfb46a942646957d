// What a person would call the shape in a scan: where its histogram parts, and the largest thing in it.
#pragma once

#include <memory>

#include "volume/shape.h"

namespace trephine::volume {

/// Otsu's threshold: the lowest value of the upper of two classes that differ most. Of scans whose values say
/// nothing by themselves (MR).
int otsu_threshold(const Volume& volume);

/// How a shape falls into parts (voxels that touch, corners included).
struct ShapeParts {
  std::int64_t largest = 0, second = 0, others = 0;  ///< voxels; others: of all but the largest
  int count = 0;                                     ///< of parts
};
ShapeParts parts_of(const std::shared_ptr<const Volume>& volume, const Shape& shape);

/// A copy in which the other parts are gone: air in a window's shape, background in a label's.
Result<Volume> with_largest_part(const std::shared_ptr<const Volume>& volume, const Shape& shape,
                                 ShapeParts& parts);

}  // namespace trephine::volume
