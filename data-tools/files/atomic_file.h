// Atomic writes: a file or folder appears complete or not at all.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "volume/base/error.h"

namespace trephine::data_tools {

/// Checks in advance that `path` can be written. Error if its folder or the permission is missing, or the
/// name belongs to something other than a plain file (a folder, a pipe, a device).
Status check_writable(const std::string& path);

/// Calls write(temporary path in the same folder, with the same extension), syncs this file, renames it to
/// `path`, and syncs the folder. On failure no partial file remains and an existing `path` is unchanged. A
/// symbolic link remains a link: its target is written. Permissions of an existing file are kept.
Status write_atomically(const std::string& path, const std::function<Status(const std::string&)>& write);

/// Writes a string as a file.
Status write_file_atomically(const std::string& path, const std::string& contents);

/// Checks that a new folder can be created at `path`.
Status check_new_folder(const std::string& path);

/// Creates a new folder, which write(temporary folder) fills. `files`: names of the files in this folder, for
/// remove_unfinished(); "####" in a name means 0001 to `number_count`. Error if `path` exists.
Status write_folder_atomically(const std::string& path, const std::vector<std::string>& files,
                               const std::function<Status(const std::string&)>& write, int number_count = 0);

/// Creates a folder for outputs and its parents; an existing folder is not an error.
Status make_folder(const std::string& path);

/// Returns the error of a failed write; `number` is an errno. The kind of the error is missing_here (a full
/// or protected disk), or bad_input if the path is invalid.
Error cannot_write(const std::string& path, int number);

/// Removes partly written files. The handler of a signal that ends the program may call it, because it calls
/// only unlink and rmdir.
void remove_unfinished() noexcept;

/// Returns true if the name ends with `end` (lower case), ignoring case.
bool has_extension(const std::string& path, const std::string& end);

/// Returns the last part of a path, for messages, which never name folders.
std::string file_name(const std::string& path);

}  // namespace trephine::data_tools
