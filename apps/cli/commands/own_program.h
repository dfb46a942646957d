// Runs another command of this program in a process of its own.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "volume/base/error.h"

namespace trephine::cli {

/// Runs this program with these arguments until it ends. Its standard output is discarded; its standard
/// error becomes the error if it fails. `progress` is called ten times per second, with a share of 0; if it
/// returns false, the process is stopped.
Status run_own_program(const std::vector<std::string>& arguments,
                       const std::function<bool(double share)>& progress);

}  // namespace trephine::cli
