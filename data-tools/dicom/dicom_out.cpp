#include "data-tools/dicom/dicom_out.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <filesystem>
#include <glm/geometric.hpp>

#include "data-tools/dicom/dicom_writer.h"
#include "data-tools/files/atomic_file.h"
#include "data-tools/files/subprocess.h"
#include "data-tools/formats/open_volume.h"
#include "data-tools/formats/reader_support.h"
#include "data-tools/formats/write_volume.h"

namespace trephine::data_tools {

namespace fs = std::filesystem;

namespace {

std::string vector_text(const glm::dvec3& v) {
  return dicom_decimal(v.x) + "\\" + dicom_decimal(v.y) + "\\" + dicom_decimal(v.z);
}

/// Attributes of all slices of a series.
struct Series {
  std::uint64_t hash;
  std::string name;  ///< hash as text, used as patient id
  bool is_ct;
  glm::dvec3 row, column;  ///< unit vectors
  double thickness;        ///< mm between slices, along their normal
};

bool write_slice(const volume::Volume& v, const Series& series, int z, const std::string& path) {
  const char* sop_class = series.is_ct ? "1.2.840.10008.5.1.4.1.1.2" : "1.2.840.10008.5.1.4.1.1.4";
  DicomWriter image;
  image.set_anonymous_attributes(series.name)
      .set(0x0008, 0x0008, "CS", "DERIVED\\SECONDARY\\" + std::string(series.is_ct ? "AXIAL" : "OTHER"))
      .set(0x0008, 0x0016, "UI", sop_class)
      .set(0x0008, 0x0018, "UI", dicom_identifier(series.hash, 16 + static_cast<std::uint64_t>(z)))
      .set(0x0008, 0x0060, "CS", series.is_ct ? "CT" : "MR")
      .set(0x0008, 0x103e, "LO", "trephine export")
      .set(0x0008, 0x2111, "ST", "Voxels exported by trephine; not for diagnosis")
      .set(0x0018, 0x0050, "DS", dicom_decimal(series.thickness))
      .set(0x0020, 0x000d, "UI", dicom_identifier(series.hash, 0))
      .set(0x0020, 0x000e, "UI", dicom_identifier(series.hash, 1))
      .set(0x0020, 0x0012, "IS", series.is_ct ? "1" : "")
      .set(0x0020, 0x0013, "IS", std::to_string(z + 1))
      .set(0x0020, 0x0032, "DS", vector_text(v.frame.world_from_volume({0, 0, z})))
      .set(0x0020, 0x0037, "DS", vector_text(series.row) + "\\" + vector_text(series.column))
      .set(0x0020, 0x0052, "UI", dicom_identifier(series.hash, 2))
      .set(0x0020, 0x1040, "LO", "")
      .set_short(0x0028, 0x0002, 1)
      .set(0x0028, 0x0004, "CS", "MONOCHROME2")
      .set_short(0x0028, 0x0010, v.size.y)
      .set_short(0x0028, 0x0011, v.size.x)
      .set(0x0028, 0x0030, "DS",
           dicom_decimal(v.frame.spacing().y) + "\\" + dicom_decimal(v.frame.spacing().x))
      .set_short(0x0028, 0x0100, 16)
      .set_short(0x0028, 0x0101, 16)
      .set_short(0x0028, 0x0102, 15)
      .set_short(0x0028, 0x0103, 1);
  if (series.is_ct)
    image.set(0x0018, 0x0060, "DS", "")
        .set(0x0028, 0x1050, "DS", "400")
        .set(0x0028, 0x1051, "DS", "1800")
        .set(0x0028, 0x1052, "DS", "0")
        .set(0x0028, 0x1053, "DS", "1")
        .set(0x0028, 0x1054, "LO", "HU");
  else
    image.set(0x0018, 0x0020, "CS", "RM")
        .set(0x0018, 0x0021, "CS", "NONE")
        .set(0x0018, 0x0022, "CS", "")
        .set(0x0018, 0x0023, "CS", "3D")
        .set(0x0018, 0x0080, "DS", "")
        .set(0x0018, 0x0081, "DS", "")
        .set(0x0018, 0x0091, "IS", "");
  const std::size_t area = static_cast<std::size_t>(v.size.x) * static_cast<std::size_t>(v.size.y);
  return image.set_pixels(v.voxels.data() + static_cast<std::size_t>(z) * area, area).write(path);
}

}  // namespace

Status write_dicom_series(const std::string& path, const volume::Volume& volume, const Progress& progress) {
  constexpr double k_right_angle = 1e-4;  // cosine; DICOM requires right angles
  const glm::dvec3 row = glm::normalize(volume.frame.axes()[0]),
                   column = glm::normalize(volume.frame.axes()[1]);
  if (std::abs(glm::dot(row, column)) > k_right_angle) {
    const Result<volume::Volume> orthogonal = orthogonalized(volume);
    return orthogonal ? write_dicom_series(path, orthogonal.value(), progress) : Status(orthogonal.error());
  }
  if (std::max(volume.size.x, volume.size.y) > 65535)
    return Error{.what = "the volume is too large for DICOM",
                 .where = file_name(path),
                 .found = std::to_string(std::max(volume.size.x, volume.size.y)) + " voxels along an axis",
                 .expected = "at most 65535",
                 .remedy = "write .nrrd"};
  char name[20];
  const std::uint64_t hash = volume::content_hash(volume);
  std::snprintf(name, sizeof name, "%016llx", static_cast<unsigned long long>(hash));
  const Series series{hash, name,   volume.is_hounsfield,
                      row,  column, std::abs(glm::dot(glm::cross(row, column), volume.frame.axes()[2]))};
  if (Status error = check_slices(volume.size.z, path)) return error;
  // Child processes write the slices, because DicomWriter::write() may abort.
  const auto write = [&](const std::string& folder) -> Status {
    const auto failure_flag = SharedBytes::make(1);
    if (!failure_flag) return too_large(1, file_name(path));
    const std::size_t bytes =
        2 * static_cast<std::size_t>(volume.size.x) * static_cast<std::size_t>(volume.size.y);
    const SubprocessResult result = run_in_subprocess(
        volume.size.z,
        [&](int z) {
          const std::string file = (fs::path(folder) / slice_name(z, ".dcm")).string();
          if (!write_slice(volume, series, z, file) || check_written(file, path, bytes))
            *failure_flag->data() = 1;
        },
        progress);
    if (result.end == SubprocessResult::End::stopped)
      return Error{.what = "writing was interrupted; nothing was written",
                   .where = file_name(path),
                   .kind = ErrorKind::interrupted};
    if (result.end == SubprocessResult::End::failed || *failure_flag->data() != 0)
      return cannot_write(path, ENOSPC);
    return std::nullopt;
  };
  return write_folder_atomically(path, {"slice-####.dcm"}, write, volume.size.z);
}

}  // namespace trephine::data_tools
