// ScanQuality: blur, noise and slice distance of a scan, and the thinnest wall and narrowest gap it resolves.
#pragma once

#include <optional>
#include <vector>

#include "volume/scan/shape.h"

namespace trephine::data_tools {

struct ScanQuality {
  /// Sigma of the blur of edges, mm, including the voxel's own size: within slices, and from slice to slice.
  /// Empty if too few edges have that direction.
  std::optional<double> blur_in_plane, blur_across;
  int edge_count = 0;     ///< number of edges that were fitted for the blur
  bool is_rough = false;  ///< true if too few edges were clean: the blur is approximate

  std::optional<double> noise;     ///< sigma in uniform regions, in the scan's units
  double slice_step = 0;           ///< mm between slices, along their normal
  double inside = 0, outside = 0;  ///< typical intensity of the shape and around it, in the scan's units
  std::optional<double> thinnest;  ///< mm; 2 % of the measured walls of the shape are thinner
  /// Thinnest wall that is still touched without holes, and narrowest gap that is still open, mm, within
  /// slices; finer ones are lost in blur and noise.
  std::optional<double> min_wall, min_gap;
  /// Sample of the superimposed edges: distance from the edge (mm), share of the step from outside to inside.
  struct EdgePoint {
    double distance, share;
  };
  std::vector<EdgePoint> edge_points;
};

/// Measures the quality of a scan at the surface of `shape`, a window. Takes half a second for a head.
ScanQuality scan_quality(const volume::Volume& volume, const volume::Shape& shape);

}  // namespace trephine::data_tools
