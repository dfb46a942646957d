// Common parts of the writers of all volume formats.
#pragma once

#include "volume/scan/volume.h"

namespace trephine::data_tools {

/// Voxels to be written, borrowed: a scan (int16), or labels (uint8) with their names.
struct VoxelsToWrite {
  glm::ivec3 size{0};
  volume::Frame frame;
  const std::int16_t* scan = nullptr;
  const std::uint8_t* labels = nullptr;  ///< used if scan is null
  bool is_hounsfield = false;
  std::vector<std::string> label_names;
  std::vector<glm::u8vec3> label_colours;

  static VoxelsToWrite scan_of(const volume::Volume& v) {
    return {v.size, v.frame, v.voxels.data(), nullptr, v.is_hounsfield, {}, {}};
  }
  static VoxelsToWrite labels_of(const volume::Volume& v) {
    return {v.size, v.frame, nullptr, v.labels.data(), false, v.label_names, v.label_colours};
  }
  bool is_int16() const { return scan != nullptr; }
  const void* data() const { return scan ? static_cast<const void*>(scan) : labels; }
  std::size_t count() const {
    return static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y) *
           static_cast<std::size_t>(size.z);
  }
  std::size_t bytes() const { return count() * (is_int16() ? 2 : 1); }
};

/// Returns the file name of slice `z` (from 0): "slice-0007.png" for 6.
std::string slice_name(int z, const char* extension);
/// Error for more than 9999 slices.
Status check_slices(int slices, const std::string& path);

/// Returns the colour of a label, 0 to 1: the chosen one, or else a default that differs between labels.
glm::dvec3 label_colour(int label, const std::vector<glm::u8vec3>& chosen) noexcept;

/// Error if the file `temporary` is smaller than `bytes`: some writers do not report a full disk. `path`: the
/// name of the file in the error.
Status check_written(const std::string& temporary, const std::string& path, std::size_t bytes);

}  // namespace trephine::data_tools
