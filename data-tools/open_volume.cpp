#include "data-tools/open_volume.h"

#include <chrono>
#include <filesystem>
#include <fstream>

#include "data-tools/archive.h"
#include "data-tools/atomic_file.h"
#include "data-tools/dicom.h"
#include "data-tools/image_files.h"
#include "data-tools/invesalius.h"
#include "data-tools/nifti.h"
#include "data-tools/nrrd.h"
#include "data-tools/picture_stack.h"
#include "data-tools/raw_file.h"
#include "data-tools/vdb.h"
#include "data-tools/vti.h"

namespace trephine::data_tools {

namespace fs = std::filesystem;
using volume::Error;
using volume::Result;

namespace {

constexpr const char* k_what_is_read =
    "a DICOM folder, file or archive (.zip, .tar, .gz), .mha, .mhd, .nrrd, .nhdr, .nii, .nii.gz, .hdr, "
    ".vti, .vdb, .inv3, or pictures (a folder of .png or .tif, one .tif)";

Result<OpenedVolume> open_by_kind(const std::string& path, const OpenOptions& options) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  const std::string where = file_name(path);
  if (!fs::exists(status))
    return Error{"there is no such file or folder", where, "", k_what_is_read,
                 "check the spelling; the built-in phantoms are called head and spine"};
  if (fs::is_directory(status))
    return is_picture_stack(path) ? open_picture_stack(path, options) : open_dicom(path, options);
  if (!fs::is_regular_file(status)) return Error{"this is neither a file nor a folder", where, "", "", ""};
  if (fs::file_size(path, error) == 0)
    return Error{"the file is empty", where, "0 bytes", "a scan", "copy or export it again"};
  if (!options.raw.empty()) return open_raw(path, options);
  for (const char* extension : {".mha", ".mhd"})
    if (has_extension(path, extension)) return open_image_file(path, options);
  if (has_extension(path, ".vti")) return open_vti(path, options);
  for (const char* extension : {".nrrd", ".nhdr"})
    if (has_extension(path, extension)) return open_nrrd(path, options);
  for (const char* extension : {".nii", ".nii.gz", ".hdr", ".img"})
    if (has_extension(path, extension)) return open_nifti(path, options);
  if (has_extension(path, ".vdb")) return open_vdb(path, options);
  if (has_extension(path, ".inv3")) return open_invesalius(path, options);
  if (is_picture_stack(path)) return open_picture_stack(path, options);
  if (is_dicom_file(path) || is_archive(path) || has_extension(path, ".dcm"))
    return open_dicom(path, options);
  for (const char* extension : {".png", ".jpg", ".jpeg", ".bmp", ".pgm"})
    if (has_extension(path, extension))
      return Error{"one picture is no scan", where, "a picture", "a folder of them, slice by slice",
                   "point at the folder that holds all slices"};
  return Error{"this is no scan that trephine reads", where, "a file of another kind", k_what_is_read,
               "convert it, point at the folder with the scanner's files, or say its layout: --raw"};
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
