// Contents of a .zip, .tar or .gz, unpacked into memory: names in it are never names on the disk.
#pragma once

#include <memory>
#include <vector>

#include "data-tools/progress.h"
#include "volume/error.h"

namespace trephine::data_tools {

struct ArchiveMember {
  std::string name;
  std::shared_ptr<const std::string> bytes;
};

/// Does the file begin as archives and compressed files do?
bool is_archive(const std::string& path);

/// All plain members. Error when it is damaged, protected by a password, or larger than memory or reason
/// allow.
volume::Result<std::vector<ArchiveMember>> read_archive(const std::string& path, const Progress& progress);

}  // namespace trephine::data_tools
