// Runs another command of this program in a process of its own.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "volume/base/error.h"

namespace trephine::cli {

/// Starts this program with these arguments in a new process, and returns when the process ends. Its standard
/// output is discarded. If the process fails, the error contains the text of its standard error. `progress`
/// is called ten times per second, with a share of 0; if `progress` returns false, the process is stopped.
Status run_own_program(const std::vector<std::string>& arguments,
                       const std::function<bool(double share)>& progress);

}  // namespace trephine::cli
