#include "data-tools/formats/nifti.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <glm/geometric.hpp>
#include <memory>
#include <nifti2_io.h>
#include <vector>
#include <zlib.h>

#include "data-tools/files/archive.h"
#include "data-tools/files/atomic_file.h"
#include "data-tools/files/words.h"
#include "data-tools/formats/reader_support.h"
#include "data-tools/formats/voxel_values.h"
#include "volume/base/text.h"

namespace trephine::data_tools {

using volume::Volume;

namespace {

constexpr double k_frames_agree_mm = 0.1;

std::string short_mm(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.2f mm", value);
  return text;
}

using Image = std::unique_ptr<nifti_image, decltype(&nifti_image_free)>;

/// Converts a matrix in RAS to a frame in LPS, mm; `unit_mm`: mm per unit of the matrix.
Result<volume::Frame> frame_of(const nifti_dmat44& m, double unit_mm) {
  glm::dmat3 axes;
  glm::dvec3 origin;
  for (int row = 0; row < 3; ++row) {
    const double sign = row < 2 ? -unit_mm : unit_mm;
    for (int column = 0; column < 3; ++column) axes[column][row] = sign * m.m[row][column];
    origin[row] = sign * m.m[row][3];
  }
  return volume::Frame::from_axes(origin, axes);
}

std::optional<ValueReader> reader_of(const nifti_image& image, const void* data) {
  const double slope = image.scl_slope != 0 ? image.scl_slope : 1;
  const double intercept = image.scl_slope != 0 ? image.scl_inter : 0;
  switch (image.datatype) {
    case DT_UINT8:
      return values_of<unsigned char>(data, slope, intercept);
    case DT_INT8:
      return values_of<signed char>(data, slope, intercept);
    case DT_UINT16:
      return values_of<unsigned short>(data, slope, intercept);
    case DT_INT16:
      return values_of<short>(data, slope, intercept);
    case DT_UINT32:
      return values_of<unsigned>(data, slope, intercept);
    case DT_INT32:
      return values_of<int>(data, slope, intercept);
    case DT_UINT64:
      return values_of<std::uint64_t>(data, slope, intercept);
    case DT_INT64:
      return values_of<std::int64_t>(data, slope, intercept);
    case DT_FLOAT32:
      return values_of<float>(data, slope, intercept);
    case DT_FLOAT64:
      return values_of<double>(data, slope, intercept);
    default:
      return std::nullopt;
  }
}

/// Converts a header of the other byte order to the native byte order, so that it can be checked.
void swap_to_native(void* header, int version) {
  std::int32_t size = 0;  // the first field of every version
  std::memcpy(&size, header, sizeof size);
  const std::int32_t expected = version == 2 ? 540 : 348;
  if (size != expected &&
      __builtin_bswap32(static_cast<std::uint32_t>(size)) == static_cast<std::uint32_t>(expected))
    swap_nifti_header(header, version);
}

/// Returns scl_slope of a header in native byte order; 1 for Analyze 7.5.
float slope_of(const void* header, int version) {
  if (version == 0) return 1;
  return version == 2 ? static_cast<float>(static_cast<const nifti_2_header*>(header)->scl_slope)
                      : static_cast<const nifti_1_header*>(header)->scl_slope;
}

/// Returns the fault of a header that niftilib refuses.
std::string header_fault(const void* header, int version) {
  if (header == nullptr) return "no NIfTI header";
  std::array<std::int64_t, 8> dim{};
  for (std::size_t i = 0; i < dim.size(); ++i)
    dim[i] = version == 2 ? static_cast<const nifti_2_header*>(header)->dim[i]
                          : static_cast<const nifti_1_header*>(header)->dim[i];
  if (dim[0] < 1 || dim[0] > 7) return "dim[0] = " + std::to_string(dim[0]) + ", the number of dimensions";
  for (std::int64_t i = 1; i <= dim[0]; ++i)
    if (const std::int64_t size = dim[static_cast<std::size_t>(i)]; size < 1)
      return "dim[" + std::to_string(i) + "] = " + std::to_string(size) + ", a size";
  return "no valid NIfTI header";
}

/// Returns true if the file can contain `bytes` of voxels. A compressed file contains at most 1100 times its
/// size, because deflate compresses by a factor of at most 1032.
bool can_hold(const nifti_image& image, std::size_t bytes) {
  std::error_code error;
  const auto file_bytes = std::filesystem::file_size(image.iname, error);
  const std::size_t largest_ratio = has_extension(image.iname, ".gz") ? 1100 : 1;
  return !error && file_bytes * largest_ratio >= static_cast<std::size_t>(image.iname_offset) + bytes;
}

/// Returns the value of an XML attribute, or "".
std::string attribute_of(std::string_view tag, const std::string& name) {
  for (const char quote : {'"', '\''}) {
    const std::string key = " " + name + "=" + quote;
    const std::size_t at = tag.find(key);
    if (at == std::string_view::npos) continue;
    const std::size_t first = at + key.size(), end = tag.find(quote, first);
    if (end != std::string_view::npos) return std::string(tag.substr(first, end - first));
  }
  return "";
}

/// Replaces the five entities that XML defines.
std::string xml_text(std::string text) {
  for (const auto& [entity, letter] :
       {std::pair("&lt;", "<"), {"&gt;", ">"}, {"&quot;", "\""}, {"&apos;", "'"}, {"&amp;", "&"}})
    for (std::size_t at = 0; (at = text.find(entity, at)) != std::string::npos; ++at)
      text.replace(at, std::strlen(entity), letter);
  return text;
}

/// Returns the label table of a Caret extension, as TotalSegmentator and Connectome Workbench write it. The
/// code of the extension is ignored. Example of a label: <Label Key="1" Red="1" Green="0" Blue="0"
/// Alpha="1"><![CDATA[spleen]]></Label>.
std::vector<SegmentFacts> segments_of(const nifti_image& image) {
  std::vector<SegmentFacts> segments;
  for (int i = 0; i < image.num_ext; ++i) {
    const nifti1_extension& extension = image.ext_list[i];
    if (extension.esize <= 8 || extension.edata == nullptr) continue;
    const std::string_view xml(extension.edata, static_cast<std::size_t>(extension.esize) - 8);
    if (xml.find("<CaretExtension") == std::string_view::npos) continue;
    for (std::size_t at = 0; (at = xml.find("<Label ", at)) != std::string_view::npos; ++at) {
      const std::size_t tag_end = xml.find('>', at), end = xml.find("</Label>", at);
      if (tag_end == std::string_view::npos || end == std::string_view::npos || end < tag_end) break;
      const std::string_view tag = xml.substr(at, tag_end - at);
      std::string_view name = xml.substr(tag_end + 1, end - tag_end - 1);
      constexpr std::string_view k_open = "<![CDATA[", k_close = "]]>";
      const std::size_t open = name.find(k_open), close = name.rfind(k_close);
      const bool is_literal = open != std::string_view::npos && close != std::string_view::npos;
      if (is_literal) name = name.substr(open + k_open.size(), close - open - k_open.size());
      const long key = std::strtol(attribute_of(tag, "Key").c_str(), nullptr, 10);
      if (key <= 0 || key > 32767 || name.empty()) continue;
      SegmentFacts segment{utf8_text(is_literal ? std::string(name) : xml_text(std::string(name))),
                           static_cast<int>(key), 0};
      glm::dvec3 colour(0);
      bool has_colour = true;
      int channel = 0;
      for (const char* part : {"Red", "Green", "Blue"}) {
        const std::string text = attribute_of(tag, part);
        has_colour = has_colour && !text.empty();
        colour[channel++] = std::clamp(std::strtod(text.c_str(), nullptr), 0.0, 1.0);
      }
      if (has_colour) segment.colour = glm::u8vec3(255.0 * colour + 0.5);
      segments.push_back(std::move(segment));
    }
  }
  return segments;
}

/// Reads voxels from a compressed or plain file, in native byte order and otherwise unchanged (niftilib
/// replaces non-finite values by 0). Checks the checksum of a compressed file. Returns false if the file is
/// incomplete.
bool read_voxels(const nifti_image& image, Buffer<char>& voxels) {
  std::unique_ptr<std::remove_pointer_t<gzFile>, int (*)(gzFile)> file(gzopen(image.iname, "rb"), gzclose_r);
  if (!file) return false;
  const auto read = [&](char* bytes, std::size_t count) {
    for (std::size_t offset = 0; offset < count;) {
      const auto part = static_cast<unsigned>(std::min<std::size_t>(count - offset, 1u << 26));
      const int count_read = gzread(file.get(), bytes + offset, part);
      if (count_read <= 0) return false;
      offset += static_cast<std::size_t>(count_read);
    }
    return true;
  };
  std::vector<char> skipped(static_cast<std::size_t>(image.iname_offset));
  if (!read(skipped.data(), skipped.size()) || !read(voxels.data(), voxels.size())) return false;
  std::vector<char> trailing(1 << 16);
  while (gzread(file.get(), trailing.data(), static_cast<unsigned>(trailing.size())) > 0) {}
  if (gzclose_r(file.release()) != Z_OK) return false;  // zlib checks the checksum after the last byte
  if (image.swapsize > 1 && image.byteorder != nifti_short_order())
    nifti_swap_Nbytes(static_cast<std::int64_t>(voxels.size()) / image.swapsize, image.swapsize,
                      voxels.data());
  return true;
}

}  // namespace

Result<OpenedVolume> open_nifti(const std::string& path, const OpenOptions& options) {
  const std::string where = file_name(path);
  const auto read_error = [&](const std::string& found) {
    return Error{.what = "the NIfTI file cannot be read",
                 .where = where,
                 .found = found,
                 .expected = "a complete NIfTI file",
                 .remedy = "copy or export it again"};
  };
  std::vector<std::string> notices;
  nifti_set_debug_level(-1);  // keeps niftilib from printing
  // The header is checked first, because niftilib prints messages when it converts a broken header.
  int version = 0;  // 0: Analyze 7.5
  const std::unique_ptr<void, decltype(&std::free)> header(nifti_read_header(path.c_str(), &version, 0),
                                                           &std::free);
  if (header) swap_to_native(header.get(), version);
  const bool is_valid =
      header && (version == 2 ? nifti_hdr2_looks_good(static_cast<nifti_2_header*>(header.get()))
                              : nifti_hdr1_looks_good(static_cast<nifti_1_header*>(header.get())));
  if (!is_valid && has_extension(path, ".nii") && is_archive(path))
    return Error{.what = "the NIfTI file is compressed, but its extension is .nii",
                 .where = where,
                 .found = "a name ending in .nii",
                 .expected = "a name ending in .nii.gz",
                 .remedy = "rename it to .nii.gz"};
  if (!is_valid) return read_error(header_fault(header.get(), version));
  const int datatype = version == 2 ? static_cast<nifti_2_header*>(header.get())->datatype
                                    : static_cast<nifti_1_header*>(header.get())->datatype;
  if (nifti_is_valid_datatype(datatype) == 0)
    return read_error("voxels of an unknown type (" + std::to_string(datatype) + ")");
  const Image image(nifti_image_read(path.c_str(), 0), &nifti_image_free);
  if (!image) return read_error(header_fault(header.get(), version));
  if (image->ndim < 3 || image->nu > 1 || image->nv > 1 || image->nw > 1)
    return read_error(std::to_string(image->ndim) + " dimensions instead of 3");
  const auto volumes = static_cast<std::size_t>(std::max<std::int64_t>(image->nt, 1));
  const Result<std::size_t> index = volume_index(options, volumes, where);
  if (!index) return index.error();
  for (const double s : {image->dx, image->dy, image->dz})
    if (!(s > 0) || !std::isfinite(s))
      return Error{.what = "the spacing is not a positive number",
                   .where = where,
                   .found = rounded_text(s) + " mm",
                   .expected = "a spacing above 0 mm on each axis",
                   .remedy = "export the volume again"};

  if (const int code = image->xyz_units;
      code != NIFTI_UNITS_METER && code != NIFTI_UNITS_MICRON && code != NIFTI_UNITS_MM && version != 0)
    notices.push_back("the file does not state its unit of lengths (code " + std::to_string(code) +
                      "): millimetres are assumed");
  if (const float slope = slope_of(header.get(), version); !std::isfinite(slope))
    notices.emplace_back("the slope of the file's values is not a number: the stored numbers are used");
  const double unit = image->xyz_units == NIFTI_UNITS_METER    ? 1000
                      : image->xyz_units == NIFTI_UNITS_MICRON ? 1e-3
                                                               : 1;
  const bool is_single_file =
      image->nifti_type == NIFTI_FTYPE_NIFTI1_1 || image->nifti_type == NIFTI_FTYPE_NIFTI2_1;
  if (is_single_file && image->iname_offset < (version == 2 ? 544 : 352))
    return read_error("voxels that begin at byte " + std::to_string(image->iname_offset) +
                      ", within its header");
  constexpr std::int64_t k_max = 1'000'000;
  if (image->nx > k_max || image->ny > k_max || image->nz > k_max) return read_error("an impossible size");
  const glm::ivec3 size(static_cast<int>(image->nx), static_cast<int>(image->ny),
                        static_cast<int>(image->nz));
  const bool has_no_frame = image->sform_code <= 0 && image->qform_code <= 0;
  if (has_no_frame && !options.spacing)
    return Error{
        .what = "the position of the volume in the patient is missing",
        .where = where,
        .found = version == 0 ? "an Analyze file, which has no position" : "neither sform nor qform",
        .expected = "one of them",
        .remedy =
            "export the volume with its orientation; if its axes are left, back and up, state the voxel "
            "size (option spacing X,Y,Z)"};
  using FrameChoice = OpenOptions::NiftiFrame;
  const bool has_both = image->sform_code > 0 && image->qform_code > 0;
  const bool uses_qform = has_both ? options.nifti_frame == FrameChoice::qform : image->sform_code <= 0;
  Result<volume::Frame> frame = has_no_frame
                                    ? volume::Frame::from_axes(glm::dvec3(0), axes_from_options(options))
                                    : frame_of(uses_qform ? image->qto_xyz : image->sto_xyz, unit);
  if (has_both) {
    const Result<volume::Frame> other = frame_of(uses_qform ? image->sto_xyz : image->qto_xyz, unit);
    const double distance = frame && other ? max_corner_distance(frame.value(), other.value(), size) : 0;
    if (distance > k_frames_agree_mm && options.nifti_frame == FrameChoice::any)
      return Error{.what = "the file contains two different positions of the volume",
                   .where = where,
                   .found = "sform and qform put a corner " + short_mm(distance) + " apart",
                   .expected = "at most 0.1 mm",
                   .remedy = "choose one (option sform, option qform)"};
    if (distance > k_frames_agree_mm)
      notices.push_back("sform and qform put a corner " + short_mm(distance) + " apart; the " +
                        (uses_qform ? "qform" : "sform") + " was used");
  }
  // Check the file before allocating memory.
  const std::size_t volume_bytes =
      static_cast<std::size_t>(image->nx * image->ny * image->nz) * static_cast<std::size_t>(image->nbyper);
  std::size_t bytes = 0;
  if (__builtin_mul_overflow(volume_bytes, volumes, &bytes) || !can_hold(*image, bytes))
    return read_error("fewer voxels than its header states");
  Result<Volume> result = allocate_volume(size, frame, where);
  if (!result) return result.error();
  OpenedVolume opened;
  opened.volume = std::move(result).value();
  opened.format = "NIfTI";
  opened.uses_given_frame = has_no_frame;
  opened.notices = std::move(notices);
  if (options.progress && !options.progress(0)) return reading_interrupted(where);
  if (Status error = check_memory(bytes, where)) return *error;
  Buffer<char> voxels(bytes);
  if (!read_voxels(*image, voxels)) return read_error("fewer voxels than its header states");
  const auto values = reader_of(*image, voxels.data() + index.value() * volume_bytes);
  if (!values)
    return Error{.what = "the NIfTI file contains no grey values",
                 .where = where,
                 .found = std::string("voxels of type ") + nifti_datatype_string(image->datatype),
                 .expected = "one real number per voxel",
                 .remedy = "export one channel, or the magnitude"};
  const std::size_t notice_count = opened.notices.size();
  if (Status error = fill_voxels(opened.volume, *values, options.scale, where, opened.notices)) return *error;
  opened.is_rounded = opened.notices.size() > notice_count;
  if (volumes > 1) add_volume_notice(opened, index.value(), volumes);
  opened.segments = segments_of(*image);
  detect_units(opened, std::string_view(image->descrip, strnlen(image->descrip, sizeof image->descrip)) ==
                           k_hounsfield_note);
  return opened;
}

Status write_nifti(const std::string& temporary, const std::string& path, const VoxelsToWrite& voxels) {
  const glm::ivec3& size = voxels.size;
  const volume::Frame& frame = voxels.frame;
  if (size.x > 32767 || size.y > 32767 || size.z > 32767)
    return Error{.what = "the volume is too large for NIfTI-1",
                 .where = file_name(path),
                 .found = std::to_string(std::max({size.x, size.y, size.z})) + " voxels along an axis",
                 .expected = "at most 32767",
                 .remedy = "write .mha or .nrrd"};
  nifti_1_header header{};
  header.sizeof_hdr = sizeof header;
  header.regular = 'r';
  header.dim[0] = 3;
  for (int a = 0; a < 3; ++a) {
    header.dim[a + 1] = static_cast<short>(size[a]);
    header.pixdim[a + 1] = static_cast<float>(frame.spacing()[a]);
  }
  for (int a = 4; a < 8; ++a) header.dim[a] = 1;
  header.datatype = voxels.is_int16() ? DT_INT16 : DT_UINT8;
  header.bitpix = voxels.is_int16() ? 16 : 8;
  header.vox_offset = 352;
  header.scl_slope = 1;
  header.xyzt_units = NIFTI_UNITS_MM;
  if (voxels.is_hounsfield) std::strncpy(header.descrip, k_hounsfield_note, sizeof header.descrip - 1);
  // LPS to RAS.
  nifti_dmat44 ras{};
  float* rows[] = {header.srow_x, header.srow_y, header.srow_z};
  for (int row = 0; row < 3; ++row) {
    const double sign = row < 2 ? -1 : 1;
    for (int column = 0; column < 3; ++column) ras.m[row][column] = sign * frame.axes()[column][row];
    ras.m[row][3] = sign * frame.origin()[row];
    for (int column = 0; column < 4; ++column) rows[row][column] = static_cast<float>(ras.m[row][column]);
  }
  ras.m[3][3] = 1;
  header.sform_code = header.qform_code = NIFTI_XFORM_SCANNER_ANAT;
  double q[3], at[3], d[3], qfac = 1;
  nifti_dmat44_to_quatern(ras, &q[0], &q[1], &q[2], &at[0], &at[1], &at[2], &d[0], &d[1], &d[2], &qfac);
  header.quatern_b = static_cast<float>(q[0]);
  header.quatern_c = static_cast<float>(q[1]);
  header.quatern_d = static_cast<float>(q[2]);
  header.qoffset_x = static_cast<float>(at[0]);
  header.qoffset_y = static_cast<float>(at[1]);
  header.qoffset_z = static_cast<float>(at[2]);
  header.pixdim[0] = static_cast<float>(qfac);
  std::memcpy(header.magic, "n+1", 4);

  // gzopen() writes both .nii.gz and .nii; mode "T" writes without compression.
  gzFile file = gzopen(temporary.c_str(), has_extension(path, ".gz") ? "wb" : "wbT");
  if (file == nullptr) return cannot_write(path, errno);
  const auto put = [file](const void* data, std::size_t count) {
    const char* at = static_cast<const char*>(data);
    for (std::size_t offset = 0; offset < count;) {
      const auto part = static_cast<unsigned>(std::min<std::size_t>(count - offset, 1u << 26));
      if (gzwrite(file, at + offset, part) != static_cast<int>(part)) return false;
      offset += part;
    }
    return true;
  };
  const char no_extensions[4] = {};
  errno = 0;
  bool is_written =
      put(&header, sizeof header) && put(no_extensions, 4) && put(voxels.data(), voxels.bytes());
  int number = errno;
  if (gzclose(file) != Z_OK && is_written) is_written = false, number = errno;
  if (is_written) return std::nullopt;
  return cannot_write(path, number != 0 ? number : ENOSPC);
}

}  // namespace trephine::data_tools
