// Encoding of volumes, with labels and cleaned shapes, for sessions that contain their volumes.
#include <cstring>

#include "sim/session/session_format.h"
#include "volume/base/bytes.h"

namespace trephine::sim {

using glm::dvec3;
using trephine::get;
using trephine::put;

namespace {

Error invalid_scan(const char* what) {
  return Error{.what = "the session's record is damaged",
               .found = what,
               .expected = "unchanged data written by trephine",
               .remedy = "use the part before the damage"};
}

/// Flags for the parts of a scan in a session, in addition to its voxels.
constexpr std::uint8_t k_has_labels = 1, k_has_shape = 2;

}  // namespace

std::string encode_scan(const volume::Volume& scan) {
  std::string out;
  put(out, scan.size);
  put(out, scan.frame.origin());
  put(out, scan.frame.axes());
  put(out, static_cast<std::uint8_t>(scan.is_hounsfield));
  put(out, static_cast<std::uint8_t>((scan.labels.is_empty() ? 0 : k_has_labels) |
                                     (scan.shape_voxels.is_empty() ? 0 : k_has_shape)));
  put(out, static_cast<std::uint16_t>(scan.label_names.size()));
  for (const std::string& name : scan.label_names) {
    put(out, static_cast<std::uint16_t>(std::min<std::size_t>(name.size(), 256)));
    out.append(name, 0, 256);
  }
  const auto append = [&out](const auto& buffer) {
    if (!buffer.is_empty()) out.append(reinterpret_cast<const char*>(buffer.span().data()), buffer.bytes());
  };
  append(scan.voxels);
  append(scan.labels);
  append(scan.shape_voxels);
  return out;
}

Result<volume::Volume> decode_scan(std::string_view in) {
  glm::ivec3 size;
  dvec3 origin;
  glm::dmat3 axes;
  std::uint8_t is_hounsfield = 0, parts = 0;
  std::uint16_t names = 0;
  if (!(get(in, size) && get(in, origin) && get(in, axes) && get(in, is_hounsfield) && get(in, parts) &&
        get(in, names)))
    return invalid_scan("a scan that ends early");
  if (parts > (k_has_labels | k_has_shape)) return invalid_scan("a scan with unknown parts");
  const bool has_labels = (parts & k_has_labels) != 0, has_shape = (parts & k_has_shape) != 0;
  std::vector<std::string> label_names;
  for (int i = 0; i < names; ++i) {
    std::uint16_t length = 0;
    if (!get(in, length) || length > 256 || in.size() < length) return invalid_scan("a scan that ends early");
    label_names.emplace_back(in.substr(0, length));
    in.remove_prefix(length);
  }
  // The number of bytes is checked before anything is allocated.
  std::uint64_t count = 1;
  for (int a = 0; a < 3; ++a) {
    if (size[a] < 1 || size[a] > 1 << 20) return invalid_scan("a scan of an invalid size");
    count *= static_cast<std::uint64_t>(size[a]);
  }
  if (in.size() != count * (2u + (has_labels ? 1u : 0u) + (has_shape ? 2u : 0u)))
    return invalid_scan("a scan whose size differs from its header");
  const Result<volume::Frame> frame = volume::Frame::from_axes(origin, axes);
  if (!frame) return frame.error();
  Result<volume::Volume> result = volume::make_volume(size, frame.value(), has_labels);
  if (!result) return result.error();
  volume::Volume& scan = result.value();
  scan.is_hounsfield = is_hounsfield != 0;
  scan.label_names = std::move(label_names);
  std::memcpy(scan.voxels.data(), in.data(), scan.voxels.bytes());
  in.remove_prefix(scan.voxels.bytes());
  if (has_labels) std::memcpy(scan.labels.data(), in.data(), scan.labels.bytes());
  in.remove_prefix(scan.labels.bytes());
  if (has_shape) {
    scan.shape_voxels = Buffer<std::int16_t>(scan.voxels.size());
    std::memcpy(scan.shape_voxels.data(), in.data(), scan.shape_voxels.bytes());
  }
  return result;
}

}  // namespace trephine::sim
