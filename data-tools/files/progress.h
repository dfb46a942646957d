// Progress: callback for progress and cancellation of long work.
#pragma once

#include <functional>

namespace trephine::data_tools {

/// Called on the caller's thread with the finished share, 0 to 1; returns false to cancel. May be empty.
using Progress = std::function<bool(double)>;

}  // namespace trephine::data_tools
