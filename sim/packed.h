// Bytes of a session made smaller (zstd), with their length before them.
#pragma once

#include <string>
#include <string_view>

#include "volume/error.h"

namespace trephine::sim {

std::string packed(std::string_view bytes);
/// Error when they are not what packed() made.
volume::Result<std::string> unpacked(std::string_view bytes);

}  // namespace trephine::sim
