// Archives: unpacks .zip, .tar, .7z and compressed files (.gz, .bz2, .xz) into memory, not onto the disk.
#pragma once

#include <memory>
#include <vector>

#include "data-tools/files/progress.h"
#include "volume/base/error.h"

namespace trephine::data_tools {

struct ArchiveMember {
  std::string name;
  std::shared_ptr<const std::string> bytes;
};

/// Returns true if the file has the signature of an archive or of a compressed file.
bool is_archive(const std::string& path);

/// Returns all plain members. Error if interrupted, or if the archive is damaged, is protected by a password,
/// contains too many files, or unpacks to more than half of the available memory or to an implausible
/// multiple of its packed size.
Result<std::vector<ArchiveMember>> read_archive(const std::string& path, const Progress& progress);

}  // namespace trephine::data_tools
