// DepthCamera: pinhole depth camera, with the intrinsic parameters that public depth formats use.
#pragma once

#include <glm/vec3.hpp>

namespace trephine::haptics::depth {

/// Pinhole camera that looks along z of its own frame, x to the right, y down.
struct DepthCamera {
  int width = 0, height = 0;
  double fx = 0, fy = 0, cx = 0, cy = 0;  ///< pixels; (0, 0) is the centre of the first pixel

  /// Returns the point (mm, frame of the camera) that a pixel shows at a depth (mm along z).
  glm::dvec3 unproject(double column, double row, double depth) const noexcept {
    return {(column - cx) / fx * depth, (row - cy) / fy * depth, depth};
  }
};

}  // namespace trephine::haptics::depth
