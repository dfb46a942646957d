// Common parts of writers of all volume formats.
#pragma once

#include "volume/volume.h"

namespace trephine::data_tools {

/// Voxels on their way into a file, borrowed: of a scan (int16), or of labels (uint8) with their names.
struct VoxelsToWrite {
  glm::ivec3 size{0};
  volume::Frame frame;
  const std::int16_t* scan = nullptr;
  const std::uint8_t* labels = nullptr;  ///< when scan is null
  bool is_hounsfield = false;
  std::vector<std::string> label_names;
  std::vector<glm::u8vec3> label_colours;

  static VoxelsToWrite scan_of(const volume::Volume& v) {
    return {v.size, v.frame, v.voxels.data(), nullptr, v.is_hounsfield, {}, {}};
  }
  static VoxelsToWrite labels_of(const volume::Volume& v) {
    return {v.size, v.frame, nullptr, v.labels.data(), false, v.label_names, v.label_colours};
  }
  bool is_short() const { return scan != nullptr; }
  const void* data() const { return scan ? static_cast<const void*>(scan) : labels; }
  std::size_t count() const {
    return static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y) *
           static_cast<std::size_t>(size.z);
  }
  std::size_t bytes() const { return count() * (is_short() ? 2 : 1); }
};

/// "slice-0007.png"; of no more than 9999, which check_slices() says.
std::string slice_name(int z, const char* extension);
volume::Status check_slices(int slices, const std::string& path);

/// The colours of labels, shares of 1: as chosen, else one of its own for each.
glm::dvec3 label_colour(int label, const std::vector<glm::u8vec3>& chosen) noexcept;

/// Some writers say nothing of a full disk: is there room in the file for what was written?
volume::Status check_written(const std::string& temporary, const std::string& path, std::size_t bytes);

}  // namespace trephine::data_tools
