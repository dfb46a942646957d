// X-ray images as files: DICOM (XA) with the C-arm's pose, and the pose of any such file.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <string>

#include "volume/error.h"

namespace trephine::data_tools {

/// A C-arm's pose as headers of XA and RF images have it (PS3.3 C.8.7.5), where they do.
struct XrayPose {
  std::optional<double> primary, secondary;       ///< degrees (0018,1510), (0018,1511)
  std::optional<double> to_detector, to_patient;  ///< mm (0018,1110), (0018,1111)
  std::optional<double> pixel;                    ///< mm (0018,1164), of square pixels
  std::optional<glm::dvec3> isocentre;            ///< mm, LPS (300A,012C)
  int columns = 0, rows = 0;
};

/// Error when there is no DICOM image, its modality is neither XA, RF, DX nor CR, or its pixels are not
/// square.
volume::Result<XrayPose> read_xray_pose(const std::string& path);

struct XrayToWrite {
  XrayPose pose;                               ///< all of it
  std::span<const std::uint16_t> pixels;       ///< row by row; 65535 is all that was sent, LOG by k_log_steps
  static constexpr double k_log_steps = 4096;  ///< a factor e less
  int column_low = 0, row_low = 0, column_high = 0, row_high = 0;  ///< what collimators leave open
  std::uint16_t darkest = 0, brightest = 65535;                    ///< the window to show it with
  double voltage_kv = 0, exposure_ms = 0, current_ma = 0;
  double area_product = 0;      ///< mGy cm2
  std::uint64_t scan_hash = 0;  ///< of what was seen: images of one scan share a frame of reference
};
/// Equal images get the same unique identifiers.
volume::Status write_xray_file(const std::string& path, const XrayToWrite& xray);

}  // namespace trephine::data_tools
