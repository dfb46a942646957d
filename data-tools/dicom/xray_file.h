// XrayPose: the C-arm's pose in DICOM X-ray files; writes X-ray images (XA) with their pose.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <string>

#include "volume/base/error.h"

namespace trephine::data_tools {

/// Pose of a C-arm in the header of XA and RF images (PS3.3 C.8.7.5); absent attributes are empty.
struct XrayPose {
  std::optional<double> primary, secondary;       ///< angles, degrees (0018,1510), (0018,1511)
  std::optional<double> to_detector, to_patient;  ///< source distances, mm (0018,1110), (0018,1111)
  std::optional<double> pixel;                    ///< spacing of square pixels, mm (0018,1164)
  std::optional<glm::dvec3> isocentre;            ///< mm, LPS (300A,012C)
  int columns = 0, rows = 0;
};

/// Reads the pose of an X-ray image. Error if the file is not DICOM, its modality is not XA, RF, DX or CR, or
/// its pixels are not square.
Result<XrayPose> read_xray_pose(const std::string& path);

/// X-ray image to be written.
struct XrayToWrite {
  XrayPose pose;                               ///< to_detector and to_patient are required
  std::span<const std::uint16_t> pixels;       ///< row by row, logarithmic; 65535 is the unattenuated beam
  static constexpr double k_log_steps = 4096;  ///< decrease of a pixel per attenuation by a factor e
  int column_low = 0, row_low = 0, column_high = 0, row_high = 0;  ///< open field of the collimators, pixels
  std::uint16_t darkest = 0, brightest = 65535;                    ///< display window, pixel values
  double voltage_kv = 0, exposure_ms = 0, current_ma = 0;
  double area_product = 0;      ///< mGy cm2
  std::uint64_t scan_hash = 0;  ///< hash of the scan: images of one scan share study and frame of reference
};
/// Writes an X-ray image as DICOM (XA), atomically. Images of one scan with equal pixels get equal unique
/// identifiers.
Status write_xray_file(const std::string& path, const XrayToWrite& xray);

}  // namespace trephine::data_tools
