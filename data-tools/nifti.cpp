#include "data-tools/nifti.h"

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <glm/geometric.hpp>
#include <memory>
#include <nifti/nifti1_io.h>
#include <vector>
#include <zlib.h>

#include "data-tools/atomic_file.h"
#include "data-tools/whole_numbers.h"

namespace trephine::data_tools {

using volume::Error;
using volume::Result;
using volume::Volume;

namespace {

using Image = std::unique_ptr<nifti_image, decltype(&nifti_image_free)>;

/// RAS millimetres to our LPS.
Result<volume::Frame> frame_of(const mat44& m, double unit_mm) {
  glm::dmat3 axes;
  glm::dvec3 origin;
  for (int row = 0; row < 3; ++row) {
    const double sign = row < 2 ? -unit_mm : unit_mm;
    for (int column = 0; column < 3; ++column)
      axes[column][row] = sign * static_cast<double>(m.m[row][column]);
    origin[row] = sign * static_cast<double>(m.m[row][3]);
  }
  return volume::Frame::from_axes(origin, axes);
}

std::optional<double> convert(const nifti_image& image, Volume& volume, bool& is_known) {
  const double slope = image.scl_slope != 0 ? static_cast<double>(image.scl_slope) : 1;
  const double intercept = image.scl_slope != 0 ? static_cast<double>(image.scl_inter) : 0;
  is_known = true;
  const auto fill = [&]<class T>(T) {
    return fill_with_whole_numbers<T>(image.data, volume, slope, intercept);
  };
  switch (image.datatype) {
    case DT_UINT8:
      return fill(static_cast<unsigned char>(0));
    case DT_INT8:
      return fill(static_cast<signed char>(0));
    case DT_UINT16:
      return fill(static_cast<unsigned short>(0));
    case DT_INT16:
      return fill(short{0});
    case DT_UINT32:
      return fill(0u);
    case DT_INT32:
      return fill(0);
    case DT_FLOAT32:
      return fill(0.0f);
    case DT_FLOAT64:
      return fill(0.0);
    default:
      is_known = false;
      return std::nullopt;
  }
}

/// niftilib takes what it gets: does the file hold all its voxels? A compressed one is read to its checksum.
bool is_whole(const std::string& path, const nifti_image& image) {
  if (!has_extension(path, ".gz")) {
    std::error_code error;
    const auto held = std::filesystem::file_size(image.iname, error);
    return !error && held >= static_cast<std::size_t>(image.iname_offset) +
                                 image.nvox * static_cast<std::size_t>(image.nbyper);
  }
  gzFile file = gzopen(path.c_str(), "rb");
  if (file == nullptr) return false;
  std::vector<char> part(1 << 20);
  std::size_t held = 0;
  int got = 0;
  while ((got = gzread(file, part.data(), static_cast<unsigned>(part.size()))) > 0)
    held += static_cast<std::size_t>(got);
  const bool is_closed = gzclose_r(file) == Z_OK;
  const bool is_good = got == 0 && is_closed;
  return is_good && held >= static_cast<std::size_t>(image.iname_offset) +
                                image.nvox * static_cast<std::size_t>(image.nbyper);
}

}  // namespace

Result<OpenedVolume> open_nifti(const std::string& path, const OpenOptions& options) {
  const std::string where = file_name(path);
  const auto broken = [&](const std::string& found) {
    return Error{"the NIfTI file cannot be read", where, found, "a complete NIfTI-1 file with one volume",
                 "copy or export it again"};
  };
  nifti_set_debug_level(-1);  // it would talk to the person itself
  // Looked at first, because the library's conversion of a broken header talks to the person itself.
  const std::unique_ptr<nifti_1_header, decltype(&std::free)> header(
      nifti_read_header(path.c_str(), nullptr, 0), &std::free);
  if (!header || !nifti_hdr_looks_good(header.get())) return broken("no NIfTI header");
  const Image image(nifti_image_read(path.c_str(), 0), &nifti_image_free);
  if (!image) return broken("no NIfTI header");
  if (image->ndim < 3 || image->nt > 1 || image->nu > 1 || image->nv > 1 || image->nw > 1)
    return broken(std::to_string(image->ndim) + " dimensions instead of 3");
  for (const double s : {image->dx, image->dy, image->dz})
    if (!(s > 0) || !std::isfinite(s))
      return Error{"the spacing is not a positive number", where, std::to_string(s) + " mm",
                   "a spacing above 0 mm on each axis", "export the volume again"};

  const double unit = image->xyz_units == NIFTI_UNITS_METER    ? 1000
                      : image->xyz_units == NIFTI_UNITS_MICRON ? 1e-3
                                                               : 1;
  if (image->sform_code <= 0 && image->qform_code <= 0)
    return Error{"the file does not say how the volume lies in the patient", where, "neither sform nor qform",
                 "one of them", "export the volume with its orientation"};
  Result<volume::Frame> frame = frame_of(image->sform_code > 0 ? image->sto_xyz : image->qto_xyz, unit);
  if (!frame) {
    Error error = frame.error();
    error.where = where;
    return error;
  }
  // The file first, the memory for it then.
  if (!is_whole(path, *image)) return broken("fewer voxels than its header promises");
  Result<Volume> made = volume::make_volume({image->nx, image->ny, image->nz}, frame.value());
  if (!made) {
    Error error = made.error();
    error.where = where;
    return error;
  }
  OpenedVolume opened;
  opened.volume = std::move(made).value();
  opened.format = "NIfTI";
  if (image->sform_code > 0 && image->qform_code > 0)
    if (const Result<volume::Frame> other = frame_of(image->qto_xyz, unit); other.is_ok()) {
      const glm::dvec3 far(image->nx - 1, image->ny - 1, image->nz - 1);
      const double apart =
          std::max(glm::length(other.value().origin() - frame.value().origin()),
                   glm::length(other.value().world_from_volume(far) - frame.value().world_from_volume(far)));
      if (apart > 0.1)
        opened.notices.push_back("sform and qform disagree by " + std::to_string(apart) +
                                 " mm; the sform was taken");
    }

  if (options.progress && !options.progress(0))
    return Error{"reading was interrupted", where, "", "", "", volume::ErrorKind::interrupted};
  if (nifti_image_load(image.get()) != 0) return broken("fewer voxels than its header promises");
  bool is_known = false;
  const std::optional<double> misfit = convert(*image, opened.volume, is_known);
  if (!is_known) return broken(std::string("voxels of kind ") + nifti_datatype_string(image->datatype));
  if (misfit) return not_whole(where, *misfit);
  if (std::string_view(image->descrip, strnlen(image->descrip, sizeof image->descrip)) == k_hounsfield_note) {
    opened.volume.is_hounsfield = true;
    opened.modality = "CT";
  } else if (const std::string notice = guess_hounsfield(opened.volume); !notice.empty()) {
    opened.modality = "CT";
    opened.notices.push_back(notice);
  }
  return opened;
}

volume::Status write_nifti(const std::string& temporary, const std::string& path, const glm::ivec3& size,
                           const volume::Frame& frame, bool is_short, const void* voxels,
                           bool is_hounsfield) {
  if (size.x > 32767 || size.y > 32767 || size.z > 32767)
    return Error{"the volume is too large for NIfTI-1", file_name(path),
                 std::to_string(std::max({size.x, size.y, size.z})) + " voxels along an axis",
                 "at most 32767", "write .mha or .nrrd"};
  nifti_1_header header{};
  header.sizeof_hdr = sizeof header;
  header.regular = 'r';
  header.dim[0] = 3;
  for (int a = 0; a < 3; ++a) {
    header.dim[a + 1] = static_cast<short>(size[a]);
    header.pixdim[a + 1] = static_cast<float>(frame.spacing()[a]);
  }
  for (int a = 4; a < 8; ++a) header.dim[a] = 1;
  header.datatype = is_short ? DT_INT16 : DT_UINT8;
  header.bitpix = is_short ? 16 : 8;
  header.vox_offset = 352;
  header.scl_slope = 1;
  header.xyzt_units = NIFTI_UNITS_MM;
  if (is_hounsfield) std::strncpy(header.descrip, k_hounsfield_note, sizeof header.descrip - 1);
  // Our LPS to its RAS.
  mat44 ras{};
  float* rows[] = {header.srow_x, header.srow_y, header.srow_z};
  for (int row = 0; row < 3; ++row) {
    const double sign = row < 2 ? -1 : 1;
    for (int column = 0; column < 3; ++column)
      ras.m[row][column] = static_cast<float>(sign * frame.axes()[column][row]);
    ras.m[row][3] = static_cast<float>(sign * frame.origin()[row]);
    std::copy(ras.m[row], ras.m[row] + 4, rows[row]);
  }
  ras.m[3][3] = 1;
  header.sform_code = header.qform_code = NIFTI_XFORM_SCANNER_ANAT;
  float dx = 0, dy = 0, dz = 0;
  nifti_mat44_to_quatern(ras, &header.quatern_b, &header.quatern_c, &header.quatern_d, &header.qoffset_x,
                         &header.qoffset_y, &header.qoffset_z, &dx, &dy, &dz, &header.pixdim[0]);
  std::memcpy(header.magic, "n+1", 4);

  const std::size_t bytes = static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y) *
                            static_cast<std::size_t>(size.z) * (is_short ? 2 : 1);
  // The same function writes both; T: as it is, without compression.
  gzFile file = gzopen(temporary.c_str(), has_extension(path, ".gz") ? "wb" : "wbT");
  if (file == nullptr) return cannot_write(path, errno);
  const auto put = [file](const void* from, std::size_t count) {
    const char* at = static_cast<const char*>(from);
    for (std::size_t done = 0; done < count;) {
      const auto part = static_cast<unsigned>(std::min<std::size_t>(count - done, 1u << 26));
      if (gzwrite(file, at + done, part) != static_cast<int>(part)) return false;
      done += part;
    }
    return true;
  };
  const char no_extensions[4] = {};
  errno = 0;
  bool is_good = put(&header, sizeof header) && put(no_extensions, 4) && put(voxels, bytes);
  int number = errno;
  if (gzclose(file) != Z_OK && is_good) is_good = false, number = errno;
  if (is_good) return std::nullopt;
  return cannot_write(path, number != 0 ? number : ENOSPC);
}

}  // namespace trephine::data_tools
