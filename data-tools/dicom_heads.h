// The heads of all files below a folder, on a disk's copy, or in an archive.
#pragma once

#include "data-tools/dicom_file.h"
#include "data-tools/progress.h"

namespace trephine::data_tools {

inline constexpr std::string_view k_dicom_index_class = "1.2.840.10008.1.3.10";  ///< of a DICOMDIR

struct DicomHead {
  std::string path, name;  ///< name: relative to the folder, for people
  std::variant<DicomFile, DicomRefusal> read;
};

/// Reads the heads of a folder, to any depth; of one file; of an archive (in a folder when nothing else is
/// there); of the disk on which an index lies. Error when it was interrupted, or an archive is damaged.
volume::Result<std::vector<DicomHead>> read_dicom_heads(const std::string& path, const Progress& progress);

}  // namespace trephine::data_tools
