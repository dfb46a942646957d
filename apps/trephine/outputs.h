// What a command writes must replace nothing that it was given.
#pragma once

#include <string>
#include <vector>

#include "volume/error.h"

namespace trephine::app {

/// Error when `output` is one of the files that a command reads or records, lies among those of a folder, or
/// holds the voxels of a header: nothing that was given is lost.
volume::Status check_apart(const std::string& output, const std::vector<std::string>& others);

}  // namespace trephine::app
