#include "data-tools/formats/open_volume.h"

#include <array>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "data-tools/dicom/dicom.h"
#include "data-tools/files/archive.h"
#include "data-tools/files/atomic_file.h"
#include "data-tools/files/words.h"
#include "data-tools/formats/image_files.h"
#include "data-tools/formats/invesalius.h"
#include "data-tools/formats/nifti.h"
#include "data-tools/formats/nrrd.h"
#include "data-tools/formats/picture_stack.h"
#include "data-tools/formats/raw_file.h"
#include "data-tools/formats/vdb.h"
#include "data-tools/formats/vti.h"

namespace trephine::data_tools {

namespace fs = std::filesystem;

namespace {

constexpr const char* k_supported_formats =
    "a DICOM folder, file or archive (.zip, .tar, .gz), .mha, .mhd, .nrrd, .nhdr, .nii, .nii.gz, .hdr, "
    ".vti, .vdb, .inv3, or pictures (a folder of .png or .tif, one .tif)";

/// A file format and its extension.
struct NamedFormat {
  const char *extension, *name;
};
constexpr NamedFormat k_formats[] = {{".nii", "NIfTI"},
                                     {".nii.gz", "NIfTI"},
                                     {".mha", "MetaImage"},
                                     {".mhd", "MetaImage"},
                                     {".nrrd", "NRRD"},
                                     {".nhdr", "NRRD"},
                                     {".hdr", "Analyze or NIfTI"},
                                     {".hdr.gz", "Analyze or NIfTI"},
                                     {".vti", "VTK image"},
                                     {".vdb", "OpenVDB"},
                                     {".inv3", "InVesalius"},
                                     {".mgz", "FreeSurfer"},
                                     {".mgh", "FreeSurfer"},
                                     {".stl", "STL model"},
                                     {".ply", "PLY model"},
                                     {".obj", "OBJ model"}};

/// Returns the format of a file name's extension, or "".
std::string format_of(const std::string& path) {
  for (const auto& [extension, name] : k_formats)
    if (has_extension(path, extension)) return name;
  return "";
}

/// Returns true for a file of a scan, not of a model, in a format that is not DICOM.
bool is_scan(const std::string& path) {
  const std::string format = format_of(path);
  return !format.empty() && !format.ends_with(" model");
}

/// Returns true if the file starts with a DICOM preamble.
bool has_dicom_preamble(const std::string& path) {
  std::array<char, 132> header{};
  std::ifstream in(path, std::ios::binary);
  return in.read(header.data(), header.size()) && std::string_view(header.data() + 128, 4) == "DICM";
}

/// Opens the only scan of an archive, through a temporary file.
Result<OpenedVolume> open_member(const ArchiveMember& member, const OpenOptions& options) {
  std::string folder = (fs::temp_directory_path() / "trephine-XXXXXX").string();
  if (mkdtemp(folder.data()) == nullptr) return cannot_write(folder, errno);
  const fs::path name = fs::path(member.name).filename(), file = fs::path(folder) / name;
  std::ofstream out(file, std::ios::binary);
  out.write(member.bytes->data(), static_cast<std::streamsize>(member.bytes->size()));
  out.close();
  Result<OpenedVolume> opened =
      out ? open_volume(file.string(), options) : Result<OpenedVolume>(cannot_write(name.string(), errno));
  std::error_code ignored;
  fs::remove_all(folder, ignored);
  if (opened)
    opened.value().notices.push_back("the archive contains one scan, of format " + format_of(name.string()));
  return opened;
}

/// Opens a folder or archive without DICOM images that contains one scan of another format. With several
/// scans, returns an error about them; without any scan, returns `error`, the result of the search for DICOM
/// images.
Result<OpenedVolume> open_other_contents(const std::string& path, const OpenOptions& options, Error error) {
  std::vector<std::string> scans;
  std::string format;
  std::error_code failure;
  const bool is_folder = fs::is_directory(path, failure);
  if (is_folder) {
    for (fs::directory_iterator at(path, failure), end; !failure && at != end; at.increment(failure))
      if (at->is_regular_file(failure) && is_scan(at->path().string())) scans.push_back(at->path().string());
  } else if (const auto members = read_archive(path, options.progress)) {
    const ArchiveMember* scan = nullptr;
    for (const ArchiveMember& member : members.value())
      if (is_scan(member.name)) scans.push_back(member.name), scan = &member;
    if (scans.size() == 1) return open_member(*scan, options);
  }
  if (scans.empty()) return error;
  format = format_of(scans[0]);
  if (is_folder && scans.size() == 1) {
    Result<OpenedVolume> opened = open_volume(scans[0], options);
    if (opened) opened.value().notices.push_back("the folder contains one scan, of format " + format);
    return opened;
  }
  error.what = is_folder ? "the folder contains several scans that are not DICOM"
                         : "the archive contains several scans that are not DICOM";
  error.found = counted(scans.size(), "file") + ", the first of format " + format;
  error.expected = "DICOM images, or one scan";
  error.remedy = is_folder ? "pass the file to open" : "unpack it and pass the file to open";
  return error;
}

Result<OpenedVolume> open_by_kind(const std::string& path, const OpenOptions& options) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  const std::string where = file_name(path);
  if (!fs::exists(status))
    return Error{.what = "the file or folder does not exist",
                 .where = where,
                 .expected = k_supported_formats,
                 .remedy = "check the spelling; the built-in phantoms are called head and spine"};
  const auto open_dicom_or_other = [&]() -> Result<OpenedVolume> {
    Result<OpenedVolume> opened = open_dicom(path, options);
    if (opened || opened.error().what != k_no_dicom) return opened;
    return open_other_contents(path, options, opened.error());
  };
  if (fs::is_directory(status))
    return is_picture_stack(path) ? open_picture_stack(path, options) : open_dicom_or_other();
  if (!fs::is_regular_file(status))
    return Error{.what = "neither a file nor a folder",
                 .where = where,
                 .found = "a pipe, a device or a socket",
                 .expected = k_supported_formats,
                 .remedy = "copy its contents to a file"};
  if (fs::file_size(path, error) == 0)
    return Error{.what = "the file is empty",
                 .where = where,
                 .found = "0 bytes",
                 .expected = "a scan",
                 .remedy = "copy or export it again"};
  if (!options.raw.empty()) return open_raw(path, options);
  if (has_dicom_preamble(path)) return open_dicom(path, options);
  if (has_extension(path, ".mgz") || has_extension(path, ".mgh"))
    return Error{.what = "FreeSurfer volumes are not supported",
                 .where = where,
                 .found = "a file .mgz or .mgh",
                 .expected = k_supported_formats,
                 .remedy = "convert it: mri_convert in.mgz out.nii.gz"};
  for (const char* extension : {".mha", ".mhd"})
    if (has_extension(path, extension)) return open_image_file(path, options);
  if (has_extension(path, ".vti")) return open_vti(path, options);
  for (const char* extension : {".nrrd", ".nhdr"})
    if (has_extension(path, extension)) return open_nrrd(path, options);
  for (const char* extension : {".nii", ".nii.gz", ".hdr", ".img", ".hdr.gz", ".img.gz"})
    if (has_extension(path, extension)) return open_nifti(path, options);
  if (has_extension(path, ".vdb")) return open_vdb(path, options);
  if (has_extension(path, ".inv3")) return open_invesalius(path, options);
  if (is_picture_stack(path)) return open_picture_stack(path, options);
  if (is_archive(path)) return open_dicom_or_other();
  if (is_dicom_file(path) || has_extension(path, ".dcm")) return open_dicom(path, options);
  for (const char* extension : {".png", ".jpg", ".jpeg", ".bmp", ".pgm"})
    if (has_extension(path, extension))
      return Error{.what = "a single picture is not a scan",
                   .where = where,
                   .found = "a picture",
                   .expected = "a folder with one picture per slice",
                   .remedy = "pass the folder that contains all slices"};
  return Error{.what = "unknown file format",
               .where = where,
               .found = "a file of another kind",
               .expected = k_supported_formats,
               .remedy = "convert it, pass the folder of the scanner, or describe its layout (option raw)"};
}

}  // namespace

Result<OpenedVolume> open_volume(const std::string& path, const OpenOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  Result<OpenedVolume> opened = open_by_kind(path, options);
  if (opened)
    opened.value().read_seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return opened;
}

}  // namespace trephine::data_tools
