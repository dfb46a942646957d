// Files that are there whole or not at all.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "volume/error.h"

namespace trephine::data_tools {

/// Checks that `path` can be written, before any work is done for it: no folder, no permission, or
/// something of that name that is no plain file (a folder, a pipe, a device).
volume::Status check_writable(const std::string& path);

/// Calls write(temporary path in the same folder, same extension), then syncs it and its folder and renames
/// it to `path`. Whatever fails, no partial file stays and an older `path` is untouched. A link stays a link:
/// what it names is written. An older file's permissions are kept.
volume::Status write_atomically(const std::string& path,
                                const std::function<volume::Status(const std::string&)>& write);

/// Writes contents at hand.
volume::Status write_file_atomically(const std::string& path, const std::string& contents);

/// Checks that a new folder can be made there.
volume::Status check_new_folder(const std::string& path);

/// Makes a new folder, into which write(temporary folder) writes; `files` are the names that it may
/// use there, in which "####" stands for 0001 to `numbered`. Error when there is something of that name.
volume::Status write_folder_atomically(const std::string& path, const std::vector<std::string>& files,
                                       const std::function<volume::Status(const std::string&)>& write,
                                       int numbered = 0);

/// A folder for outputs, with those above it; one that is there already is taken.
volume::Status make_folder(const std::string& path);

/// Error of a failed write: `number` is an errno. A full or broken disk is this machine's fault.
volume::Error cannot_write(const std::string& path, int number);

/// Takes away what is half written. For the handler of a signal that ends the program: it calls nothing but
/// unlink and rmdir.
void remove_unfinished() noexcept;

/// Does the name end so, whatever its case? `end` is lower case.
bool has_extension(const std::string& path, const std::string& end);

/// The last part of a path: for messages, which never name folders.
std::string file_name(const std::string& path);

}  // namespace trephine::data_tools
