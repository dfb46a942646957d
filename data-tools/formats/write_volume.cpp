#include "data-tools/formats/write_volume.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <glm/geometric.hpp>

#include "data-tools/dicom/dicom_out.h"
#include "data-tools/files/atomic_file.h"
#include "data-tools/files/output_set.h"
#include "data-tools/formats/image_files.h"
#include "data-tools/formats/nifti.h"
#include "data-tools/formats/open_volume.h"
#include "data-tools/formats/picture_stack.h"
#include "data-tools/formats/vdb.h"
#include "data-tools/formats/vti.h"
#include "volume/base/parallel.h"
#include "volume/cuts/operated_volume.h"

namespace trephine::data_tools {

namespace fs = std::filesystem;
using volume::Volume;

glm::dvec3 label_colour(int label, const std::vector<glm::u8vec3>& chosen) noexcept {
  if (static_cast<std::size_t>(label) < chosen.size())
    return glm::dvec3(chosen[static_cast<std::size_t>(label)]) / 255.0;
  // Hues at multiples of the golden angle: successive labels differ strongly. Labels whose numbers differ by
  // 5 have similar hues, so each group of five labels has another brightness than the next.
  constexpr double k_brightness[][2] = {{0.35, 0.54}, {0.68, 0.32}, {0.2, 0.42}};  // least, range
  const double(&brightness)[2] = k_brightness[label > 0 ? (label - 1) / 5 % 3 : 0];
  const double least = brightness[0], range = brightness[1];
  const double hue = std::fmod(0.08 + 0.618033988749895 * label, 1.0) * 6;
  const auto share = [&](double peak) {
    const double distance = std::min(std::abs(hue - peak), 6 - std::abs(hue - peak));
    return std::floor(1000 * (least + range * std::clamp(2 - distance, 0.0, 1.0)) + 0.5) / 1000;
  };
  return {share(0), share(2), share(4)};
}

std::string slice_name(int z, const char* extension) {
  char name[40];
  std::snprintf(name, sizeof name, "slice-%04d%s", z + 1, extension);
  return name;
}

Status check_slices(int slices, const std::string& path) {
  if (slices <= 9999) return std::nullopt;
  return Error{.what = "too many slices for a folder",
               .where = file_name(path),
               .found = std::to_string(slices),
               .expected = "at most 9999",
               .remedy = "write one file: .nrrd"};
}

Status check_written(const std::string& temporary, const std::string& path, std::size_t bytes) {
  std::error_code failure;
  const auto size = fs::file_size(temporary, failure);
  if (!failure && size >= bytes) return std::nullopt;
  Error error = cannot_write(path, 0);
  error.found = "a disk that stored less than the whole file";
  error.expected = std::to_string(bytes) + " bytes of free space";
  return error;
}

namespace {

/// Returns Catmull-Rom weights of four samples at `t` between the middle two; at a sample its weight is 1.
std::array<double, 4> cubic_weights(double t) {
  constexpr double k_tolerance = 1e-9;
  if (t < k_tolerance) return {0, 1, 0, 0};
  if (t > 1 - k_tolerance) return {0, 0, 1, 0};
  const double t2 = t * t, t3 = t2 * t;
  return {0.5 * (-t3 + 2 * t2 - t), 0.5 * (3 * t3 - 5 * t2 + 2), 0.5 * (-3 * t3 + 4 * t2 + t),
          0.5 * (t3 - t2)};
}

Status write_voxels(const std::string& path, const VoxelsToWrite& voxels) {
  return write_atomically(path, [&](const std::string& temporary) -> Status {
    for (const char* extension : {".nii", ".nii.gz"})
      if (has_extension(path, extension)) return write_nifti(temporary, path, voxels);
    if (has_extension(path, ".vti")) return write_vti(temporary, path, voxels);
    if (has_extension(path, ".vdb")) return write_vdb(temporary, path, voxels);
    return write_image_file(temporary, path, voxels);
  });
}

Status check_name(const std::string& path, OutputKind kind) {
  if (Status error = check_extension(kind, path)) return error;
  for (const char* extension : {".mha", ".nrrd", ".nii", ".nii.gz", ".vti", ".vdb"})
    if (has_extension(path, extension) && !path.ends_with(extension))
      return Error{.what = "the extension must be in lower case",
                   .where = file_name(path),
                   .expected = extension,
                   .remedy = "rename the output"};
  return std::nullopt;
}

}  // namespace

Result<Volume> orthogonalized(const Volume& volume) {
  if (volume.frame.is_orthogonal()) return volume::copy_of(volume);
  // Gram-Schmidt orthogonalization, x first; the grid contains all corners.
  const glm::dmat3& axes = volume.frame.axes();
  const glm::dvec3 x = glm::normalize(axes[0]);
  const glm::dvec3 y = glm::normalize(axes[1] - glm::dot(axes[1], x) * x);
  glm::dvec3 z = glm::cross(x, y);
  if (glm::dot(z, axes[2]) < 0) z = -z;
  const glm::dmat3 unit(x, y, z);
  const glm::dvec3 spacing(glm::dot(axes[0], x), glm::dot(axes[1], y), glm::dot(axes[2], z));
  glm::dvec3 low(1e300), high(-1e300);
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec3 p =
        glm::dvec3(corner & 1, corner >> 1 & 1, corner >> 2 & 1) * glm::dvec3(volume.size - 1);
    const glm::dvec3 q = glm::transpose(unit) * volume.frame.world_from_volume(p);
    low = glm::min(low, q);
    high = glm::max(high, q);
  }
  const glm::ivec3 size = glm::ivec3(glm::ceil((high - low) / spacing - 1e-6)) + 1;
  Result<volume::Frame> frame =
      volume::Frame::from_axes(unit * low, glm::dmat3(spacing.x * x, spacing.y * y, spacing.z * z));
  if (!frame) return frame.error();
  Result<Volume> output = volume::make_volume(size, frame.value(), !volume.labels.is_empty());
  if (!output) return output;
  Volume& result = output.value();
  result.copy_interpretation(volume);
  const double air = volume.is_hounsfield
                         ? -1000
                         : *std::min_element(volume.voxels.span().begin(), volume.voxels.span().end());
  parallel_for(size.z, 0, [&](int k) {
    for (int j = 0; j < size.y; ++j)
      for (int i = 0; i < size.x; ++i) {
        const glm::dvec3 p = volume.frame.volume_from_world(result.frame.world_from_volume({i, j, k}));
        const glm::ivec3 base(glm::floor(p));
        // Most sheared volumes are sheared along one axis; along the other axes only one weight is not zero.
        std::array<std::array<double, 4>, 3> weights{};
        for (int a = 0; a < 3; ++a) weights[static_cast<std::size_t>(a)] = cubic_weights(p[a] - base[a]);
        double sum = 0, low = 1e9, high = -1e9;
        for (int c = 0; c < 64; ++c) {
          const glm::ivec3 step(c & 3, c >> 2 & 3, c >> 4);
          const double w = weights[0][static_cast<std::size_t>(step.x)] *
                           weights[1][static_cast<std::size_t>(step.y)] *
                           weights[2][static_cast<std::size_t>(step.z)];
          if (w == 0) continue;
          const glm::ivec3 v = base + step - 1;
          const double value = volume.contains(v) ? volume.voxels[volume.index(v.x, v.y, v.z)] : air;
          sum += w * value;
          low = std::min(low, value);
          high = std::max(high, value);
        }
        sum = std::clamp(sum, low, high);  // no overshoot at edges
        const std::size_t at = result.index(i, j, k);
        result.voxels[at] = static_cast<std::int16_t>(std::floor(sum + 0.5));
        if (!result.labels.is_empty()) {
          const glm::ivec3 v(glm::floor(p + 0.5));
          result.labels[at] =
              volume.contains(v) ? volume.labels[volume.index(v.x, v.y, v.z)] : std::uint8_t{0};
        }
      }
  });
  return output;
}

bool keeps_shear(const std::string& path) { return has_extension(path, ".vdb"); }

Status write_volume(const std::string& path, const Volume& volume) {
  if (has_extension(path, ".seg.nrrd"))
    return Error{.what = "a .seg.nrrd contains labels, not a scan",
                 .where = file_name(path),
                 .expected = ".nrrd",
                 .remedy = "choose another extension; write labels to a separate file (option write-labels)"};
  if (Status error = check_name(path, OutputKind::volume)) return error;
  if (volume.frame.is_orthogonal() || keeps_shear(path))
    return write_voxels(path, VoxelsToWrite::scan_of(volume));
  const Result<Volume> orthogonal = orthogonalized(volume);
  if (!orthogonal) return orthogonal.error();
  return write_voxels(path, VoxelsToWrite::scan_of(orthogonal.value()));
}

Status write_operated(const std::string& path, const volume::Version& version) {
  const auto operated = volume::operated_volume(version);
  return operated ? write_volume(path, operated.value()) : Status(operated.error());
}

Status write_labels(const std::string& path, const Volume& volume) {
  if (volume.labels.is_empty())
    return Error{.what = "this volume has no labels to write",
                 .where = file_name(path),
                 .expected = "a volume with labels",
                 .remedy = "read labels for it (option labels)"};
  if (Status error = check_name(path, OutputKind::volume)) return error;
  if (volume.frame.is_orthogonal() || keeps_shear(path))
    return write_voxels(path, VoxelsToWrite::labels_of(volume));
  const Result<Volume> orthogonal = orthogonalized(volume);
  if (!orthogonal) return orthogonal.error();
  return write_voxels(path, VoxelsToWrite::labels_of(orthogonal.value()));
}

Status write_volume_folder(const std::string& path, FolderFormat format, const Volume& volume,
                           const Progress& progress) {
  return format == FolderFormat::dicom
             ? write_dicom_series(path, volume, progress)
             : write_picture_stack(path, format == FolderFormat::png, volume, progress);
}

}  // namespace trephine::data_tools
