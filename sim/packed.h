// Bytes of a session made smaller: deflated, with their length before them.
#pragma once

#include <string>
#include <string_view>

#include "volume/error.h"

namespace trephine::sim {

enum class Packing { fast = 1, small = 6 };

std::string packed(std::string_view bytes, Packing how);
/// Error when they are not what packed() made.
volume::Result<std::string> unpacked(std::string_view bytes);

}  // namespace trephine::sim
