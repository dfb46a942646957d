// Depth videos: what a depth camera saw, a 16-bit picture a moment. Our own folders, and the public ones of
// TUM's RGB-D benchmark.
#pragma once

#include <array>
#include <cstdint>
#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <vector>

#include "data-tools/progress.h"
#include "volume/error.h"

namespace trephine::data_tools {

struct DepthVideo {
  int width = 0, height = 0;
  double fx = 0, fy = 0, cx = 0, cy = 0;             ///< pixels; (0, 0) is the middle of the first
  double mm_a_step = 0.1;                            ///< of a value
  std::vector<std::vector<std::uint16_t>> pictures;  ///< depths along the camera's z, row by row; 0: none
  std::vector<double> times;                         ///< s, rising, the first 0
  std::optional<double> repeats_after;               ///< s
  glm::dvec3 position{0.0};                          ///< of the camera, mm (LPS); it looks along z, y down
  glm::dquat rotation{1, 0, 0, 0};
  std::vector<std::string> notices;  ///< what was assumed or ignored
};

/// Facts about a folder that the caller states.
struct DepthVideoOptions {
  std::optional<std::array<double, 4>> intrinsics;  ///< fx, fy, cx, cy, pixels; replaces the folder's
  std::optional<double> mm_per_value;               ///< of folders with depth.txt, which do not state it
};

/// A folder with depth.json (ours), or depth.txt (TUM's: a time and a picture a line, 5000 a metre)?
bool is_depth_video(const std::string& path);

/// Reads a folder. Error when the intrinsics are missing, and for a picture that is missing, of another size,
/// or not of 16 bits.
volume::Result<DepthVideo> read_depth_video(const std::string& path, const DepthVideoOptions& options = {});

/// Writes depth-0001.png, ... and depth.json into a new folder.
volume::Status write_depth_video(const std::string& path, const DepthVideo& video,
                                 const Progress& progress = {});

}  // namespace trephine::data_tools
