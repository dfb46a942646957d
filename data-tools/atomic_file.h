// Files that are there whole or not at all.
#pragma once

#include <functional>
#include <string>

#include "volume/error.h"

namespace trephine::data_tools {

/// What would keep `path` from being written, before any work is done for it.
volume::Status check_writable(const std::string& path);

/// Calls write(temporary path in the same folder, same extension), then syncs and renames it to `path`.
/// Whatever fails, no partial file stays and an older `path` is untouched.
volume::Status write_atomically(const std::string& path,
                                const std::function<volume::Status(const std::string&)>& write);

/// The same for contents at hand.
volume::Status write_file_atomically(const std::string& path, const std::string& contents);

/// Does the name end so, whatever its case? `end` is lower case.
bool has_extension(const std::string& path, const std::string& end);

/// The last part of a path: what we say and write, never somebody's folders.
std::string file_name(const std::string& path);

}  // namespace trephine::data_tools
