// Built-in phantoms in the user's cache, so that a program does not compute them at each start.
#pragma once

#include <string>

#include "volume/scan/volume.h"

namespace trephine::workbench {

/// Returns the built-in phantom `name` with its default options: the one in the user's cache, or one that is
/// made and stored there. The file in $XDG_CACHE_HOME/trephine (~/.cache/trephine) belongs to the libraries
/// that make the phantom, and its contents are checked; another file is not used. The cache can be switched
/// off by TREPHINE_CACHE=off. A cache that cannot be written is no error.
Result<volume::Volume> builtin_phantom(const std::string& name);

}  // namespace trephine::workbench
