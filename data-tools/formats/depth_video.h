// DepthVideo: a recording of a depth camera, one 16-bit picture per time step. Reads our own folders and
// those of the TUM RGB-D benchmark.
#pragma once

#include <array>
#include <cstdint>
#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <vector>

#include "data-tools/files/progress.h"
#include "volume/base/error.h"

namespace trephine::data_tools {

struct DepthVideo {
  int width = 0, height = 0;
  double fx = 0, fy = 0, cx = 0, cy = 0;  ///< pixels; (0, 0) is the centre of the first pixel
  double mm_per_step = 0.1;               ///< mm per value
  /// Depths along the camera's z, row by row, in units of mm_per_step; 0: no measurement.
  std::vector<std::vector<std::uint16_t>> pictures;
  std::vector<double> times;            ///< s, increasing, normally from 0
  std::optional<double> repeats_after;  ///< period, s; empty: not repeated
  glm::dvec3 position{0.0};             ///< position of the camera, mm (LPS)
  /// World from camera. The axes of the camera are x to the right, y down and z forward.
  glm::dquat rotation{1, 0, 0, 0};
  std::vector<std::string> notices;  ///< about assumptions and ignored data
};

/// Properties of a folder that the caller states.
struct DepthVideoOptions {
  std::optional<std::array<double, 4>> intrinsics;  ///< fx, fy, cx, cy, pixels; replace those of the folder
  std::optional<double> mm_per_value;               ///< for a folder with depth.txt, which does not state it
};

/// Returns true for a folder with depth.json (written by trephine) or depth.txt (TUM: a time and a picture
/// per line; by default 5000 values per metre).
bool is_depth_video(const std::string& path);

/// Reads a folder. Error if intrinsics or pictures are missing, times do not increase, or pictures differ in
/// size or are not grey with 16 bits.
Result<DepthVideo> read_depth_video(const std::string& path, const DepthVideoOptions& options = {});

/// Writes depth-0001.png, ... and depth.json into a new folder.
Status write_depth_video(const std::string& path, const DepthVideo& video, const Progress& progress = {});

}  // namespace trephine::data_tools
