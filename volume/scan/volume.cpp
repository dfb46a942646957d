#include "volume/scan/volume.h"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <limits>

#include "volume/base/mix_hash.h"

namespace trephine::volume {

int Volume::label_value(const std::string& name) const noexcept {
  for (std::size_t i = 0; i < label_names.size(); ++i)
    if (label_names[i] == name) return static_cast<int>(i);
  return -1;
}

void Volume::copy_interpretation(const Volume& other) {
  is_hounsfield = other.is_hounsfield;
  label_names = other.label_names;
  label_colours = other.label_colours;
}

std::uint64_t content_hash(const Volume& volume) noexcept {
  MixHash hash;
  for (int a = 0; a < 3; ++a) hash.add(static_cast<std::uint64_t>(volume.size[a]));
  hash.add(static_cast<std::uint64_t>(volume.is_hounsfield));
  for (int a = 0; a < 3; ++a) {
    hash.add(volume.frame.origin()[a]);
    for (int b = 0; b < 3; ++b) hash.add(volume.frame.axes()[a][b]);
  }
  // Four independent lanes hide the latency of the multiplications.
  const auto add_bytes = [&hash](const void* data, std::size_t bytes) {
    MixHash lanes[4];
    std::uint64_t words[4];
    const char* at = static_cast<const char*>(data);
    for (; bytes >= sizeof words; bytes -= sizeof words, at += sizeof words) {
      std::memcpy(words, at, sizeof words);
      for (int i = 0; i < 4; ++i) lanes[i].add(words[i]);
    }
    std::memset(words, 0, sizeof words);
    if (bytes > 0) std::memcpy(words, at, bytes);
    for (int i = 0; i < 4; ++i) {
      lanes[i].add(words[i]);
      hash.add(lanes[i].value());
    }
  };
  add_bytes(volume.voxels.data(), volume.voxels.bytes());
  add_bytes(volume.labels.data(), volume.labels.bytes());
  if (!volume.shape_voxels.is_empty()) add_bytes(volume.shape_voxels.data(), volume.shape_voxels.bytes());
  return hash.value();
}

std::size_t available_memory_bytes() {
  std::ifstream file("/proc/meminfo");
  std::string key, unit;
  std::size_t kib = 0;
  while (file >> key >> kib) {
    std::getline(file, unit);
    if (key == "MemAvailable:") return kib * 1024;
  }
  return std::numeric_limits<std::size_t>::max();
}

Result<Volume> make_volume(const glm::ivec3& size, const Frame& frame, bool has_labels) {
  const std::string size_text =
      std::to_string(size.x) + " x " + std::to_string(size.y) + " x " + std::to_string(size.z) + " voxels";
  constexpr int k_longest = 1 << 15;  // keeps voxel coordinates exact in doubles and ints
  for (int i = 0; i < 3; ++i)
    if (size[i] < 1 || size[i] > k_longest)
      return Error{.what = "unsupported volume size",
                   .found = size_text,
                   .expected = "1 to 32768 voxels along each axis",
                   .remedy = "crop or resample the volume"};
  const std::size_t count =
      static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y) * static_cast<std::size_t>(size.z);
  const std::size_t bytes = count * (sizeof(std::int16_t) + (has_labels ? 1 : 0));
  const std::size_t free = available_memory_bytes();
  if (bytes > free - free / 8) {
    constexpr std::size_t k_mib = 1024 * 1024;
    return Error{.what = "the volume does not fit in the free memory of this machine",
                 .found = size_text + ", " + std::to_string(bytes / k_mib) + " MiB",
                 .expected = "at most " + std::to_string((free - free / 8) / k_mib) + " MiB",
                 .remedy = "close other programs, or crop or resample the volume",
                 .kind = ErrorKind::missing_here};
  }
  Volume volume;
  volume.size = size;
  volume.frame = frame;
  volume.voxels = Buffer<std::int16_t>(count);
  if (has_labels) volume.labels = Buffer<std::uint8_t>(count);
  return volume;
}

Result<Volume> copy_of(const Volume& volume) {
  Result<Volume> result = make_volume(volume.size, volume.frame, !volume.labels.is_empty());
  if (!result) return result;
  Volume& copy = result.value();
  copy.copy_interpretation(volume);
  std::copy_n(volume.voxels.data(), volume.voxels.size(), copy.voxels.data());
  std::copy_n(volume.labels.data(), volume.labels.size(), copy.labels.data());
  if (!volume.shape_voxels.is_empty()) {
    copy.shape_voxels = Buffer<std::int16_t>(volume.shape_voxels.size());
    std::copy_n(volume.shape_voxels.data(), volume.shape_voxels.size(), copy.shape_voxels.data());
  }
  return result;
}

}  // namespace trephine::volume
