// The base: a scan as it was loaded, never written again once it is shared.
#pragma once

#include <cstdint>
#include <glm/ext/vector_uint3_sized.hpp>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "volume/buffer.h"
#include "volume/frame.h"

namespace trephine::volume {

/// A dense scan, x fastest. Fill it, then share it as std::shared_ptr<const Volume>: every thread borrows it.
struct Volume {
  glm::ivec3 size{0};
  Frame frame;
  Buffer<std::int16_t> voxels;  ///< size.x * size.y * size.z intensities, as scanned
  /// Empty, or the intensities that shapes by window read in place of `voxels`: small parts removed, thin
  /// walls closed. Slices, X-rays and measurements read `voxels`.
  Buffer<std::int16_t> shape_voxels;
  bool is_hounsfield = false;              ///< intensities are Hounsfield units (CT)
  Buffer<std::uint8_t> labels;             ///< empty, or one label per voxel
  std::vector<std::string> label_names;    ///< name of each label value; 0 is the background
  std::vector<glm::u8vec3> label_colours;  ///< of each label value, where chosen; else empty

  std::size_t index(int x, int y, int z) const noexcept {
    return static_cast<std::size_t>(x) +
           static_cast<std::size_t>(size.x) *
               (static_cast<std::size_t>(y) + static_cast<std::size_t>(size.y) * static_cast<std::size_t>(z));
  }
  /// Returns the intensities that shapes by window read.
  const Buffer<std::int16_t>& window_voxels() const noexcept {
    return shape_voxels.is_empty() ? voxels : shape_voxels;
  }
  bool contains(const glm::ivec3& v) const noexcept {
    return v.x >= 0 && v.y >= 0 && v.z >= 0 && v.x < size.x && v.y < size.y && v.z < size.z;
  }
  /// The label value named `name`, or -1.
  int label_value(const std::string& name) const noexcept;
  std::size_t bytes() const noexcept { return voxels.bytes() + shape_voxels.bytes() + labels.bytes(); }
  /// Its numbers mean what they mean in another volume: the unit, and what labels are called.
  void take_meaning(const Volume& of);
};

/// A volume with room for its voxels, contents undefined. Error (before anything is allocated) when a size is
/// not positive, overflows, or does not fit in this machine's free memory.
Result<Volume> make_volume(const glm::ivec3& size, const Frame& frame, bool with_labels = false);

Result<Volume> copy_of(const Volume& volume);

/// Hash of a scan: its grid, its voxels and its labels. Equal scans, equal hash; some GB/s.
std::uint64_t content_hash(const Volume& volume) noexcept;

/// Memory that could still be used, bytes, as the kernel estimates it.
std::size_t available_memory_bytes();

}  // namespace trephine::volume
