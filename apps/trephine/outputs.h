// What a command writes: it can be written, and replaces nothing that the command was given. Asked before any
// work is done for it; an empty name is nothing to write.
#pragma once

#include <string>
#include <vector>

#include "volume/error.h"

namespace trephine::app {

/// Error when `output` is one of the files that a command reads or records, lies among those of a folder, or
/// holds the voxels of a header: nothing that was given is lost.
volume::Status check_apart(const std::string& output, const std::vector<std::string>& others);

/// That, and whether the file can be written at all.
volume::Status check_output(const std::string& output, const std::vector<std::string>& others);
/// A volume, a picture: by the extension too.
volume::Status check_volume_output(const std::string& output, const std::vector<std::string>& others);
volume::Status check_picture_output(const std::string& output, const std::vector<std::string>& others);

}  // namespace trephine::app
