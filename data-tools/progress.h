// Progress of long work, and its cancellation.
#pragma once

#include <functional>

namespace trephine::data_tools {

/// Called with the share done, 0 to 1, on the calling thread; returns whether to go on. May be empty.
using Progress = std::function<bool(double)>;

}  // namespace trephine::data_tools
