// DicomHeader: the headers of all files in a folder, on a copied disk, or in an archive.
#pragma once

#include "data-tools/dicom/dicom_file.h"
#include "data-tools/files/progress.h"

namespace trephine::data_tools {

inline constexpr std::string_view k_dicom_index_class = "1.2.840.10008.1.3.10";  ///< SOP class of a DICOMDIR

struct DicomHeader {
  std::string path, name;  ///< name: relative to the folder, for messages
  std::variant<DicomFile, DicomFailure> read;
};

/// Reads the headers of the files in a folder, to any depth; of one file; of the members of an archive; or of
/// the files on the disk of an index (DICOMDIR). In a folder, compressed slices (.gz) are unpacked, and other
/// archives only if the folder has no image. A damaged archive in a folder is listed as a file that is not
/// DICOM. Error if interrupted, if `path` is a damaged archive, or if the folder contains too many files.
Result<std::vector<DicomHeader>> read_dicom_headers(const std::string& path, const Progress& progress);

}  // namespace trephine::data_tools
