// Compression of a session's bytes by zstd, preceded by their length.
#pragma once

#include <string>
#include <string_view>

#include "volume/base/error.h"

namespace trephine::sim {

std::string compress(std::string_view bytes);
/// Error if the bytes are not output of compress().
Result<std::string> decompress(std::string_view bytes);

}  // namespace trephine::sim
