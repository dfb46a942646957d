// Quality of a scan for touch: blur, noise, slices, and what that leaves of thin walls and narrow gaps.
#pragma once

#include <optional>
#include <vector>

#include "volume/shape.h"

namespace trephine::data_tools {

struct ScanQuality {
  /// Sigma of the blur of edges, mm, a voxel's own size included: within slices, and from slice to slice.
  /// Nothing: too few clean edges lie that way.
  std::optional<double> blur_in_plane, blur_across;
  int edges = 0;          ///< places where it was measured
  bool is_rough = false;  ///< too few of them were clean: the blur is about as large

  std::optional<double> noise;     ///< sigma, in the scan's units, where the scan is even
  double slice_step = 0;           ///< mm from slice to slice, along their normal
  double inside = 0, outside = 0;  ///< what the shape and what is about it are like, in the scan's units
  std::optional<double> thinnest;  ///< mm; a fiftieth of the shape's surface has a thinner wall below it
  /// The thinnest wall that would still be touched as whole, and the narrowest gap that would still be open
  /// (mm, within slices): what is finer is lost in blur and noise.
  std::optional<double> least_wall, least_gap;
  /// Edges laid over each other: place (mm from the edge), share of the step from outside to inside.
  struct EdgePoint {
    double place, share;
  };
  std::vector<EdgePoint> edge;
};

/// `shape`: a window, the touched shape. Half a second for a head.
ScanQuality scan_quality(const volume::Volume& volume, const volume::Shape& shape);

}  // namespace trephine::data_tools
