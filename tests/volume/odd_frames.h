// odd_frames(): frames of the lattices on which tests count parts.
#pragma once

#include <glm/mat3x3.hpp>
#include <vector>

#include "volume/scan/frame.h"

namespace trephine::volume {

/// Returns frames of cubic, thick, and sheared voxels.
inline std::vector<Frame> odd_frames() {
  glm::dmat3 sheared(0.0);
  sheared[0][0] = 0.5, sheared[1][1] = 0.6, sheared[2][2] = 1.9, sheared[2][1] = 0.3;
  return {Frame(), Frame::from_spacing({5, -3, 2}, {0.5, 0.5, 2.5}).value(),
          Frame::from_axes({1, 2, 3}, sheared).value()};
}

}  // namespace trephine::volume
