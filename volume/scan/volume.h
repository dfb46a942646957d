// Volume: a scan as loaded, immutable once it is shared.
#pragma once

#include <cstdint>
#include <glm/ext/vector_uint3_sized.hpp>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "volume/base/buffer.h"
#include "volume/scan/frame.h"

namespace trephine::volume {

/// Dense scan, x fastest. Fill it, then share it as std::shared_ptr<const Volume>; any thread may read it.
struct Volume {
  glm::ivec3 size{0};
  Frame frame;
  Buffer<std::int16_t> voxels;  ///< size.x * size.y * size.z intensities, as scanned
  /// Empty, or intensities that window shapes read instead of `voxels`: with unwanted parts removed and gaps
  /// in thin walls filled. Slices, X-rays and measurements read `voxels`.
  Buffer<std::int16_t> shape_voxels;
  bool is_hounsfield = false;              ///< intensities are Hounsfield units (CT)
  Buffer<std::uint8_t> labels;             ///< empty, or one label per voxel
  std::vector<std::string> label_names;    ///< name of each label value; 0 is the background
  std::vector<glm::u8vec3> label_colours;  ///< RGB of each label value; empty if not chosen

  std::size_t index(int x, int y, int z) const noexcept {
    return static_cast<std::size_t>(x) +
           static_cast<std::size_t>(size.x) *
               (static_cast<std::size_t>(y) + static_cast<std::size_t>(size.y) * static_cast<std::size_t>(z));
  }
  /// Returns the intensities that window shapes read.
  const Buffer<std::int16_t>& window_voxels() const noexcept {
    return shape_voxels.is_empty() ? voxels : shape_voxels;
  }
  bool contains(const glm::ivec3& v) const noexcept {
    return v.x >= 0 && v.y >= 0 && v.z >= 0 && v.x < size.x && v.y < size.y && v.z < size.z;
  }
  /// Returns the value of the label named `name`, or -1.
  int label_value(const std::string& name) const noexcept;
  std::size_t bytes() const noexcept { return voxels.bytes() + shape_voxels.bytes() + labels.bytes(); }
  /// Copies from `other` the interpretation of the values: intensity unit, label names and label colours.
  void copy_interpretation(const Volume& other);
};

/// Allocates a volume with undefined contents. Error (before any allocation) if a size is not within 1 to
/// 32768 or the volume does not fit in this machine's free memory.
Result<Volume> make_volume(const glm::ivec3& size, const Frame& frame, bool has_labels = false);

Result<Volume> copy_of(const Volume& volume);

/// Hash of the grid, `voxels`, `shape_voxels`, their unit and the labels, without the names and colours of
/// labels. Equal scans have equal hashes. Speed: several GB/s.
std::uint64_t content_hash(const Volume& volume) noexcept;

/// Available memory in bytes, as the kernel estimates it; the largest size_t if unknown.
std::size_t available_memory_bytes();

}  // namespace trephine::volume
