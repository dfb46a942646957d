// Catalogue of the modules of this build.
#pragma once

#include "sim/api/catalogue.h"

namespace trephine::modules {

/// Returns all modules of modules/CMakeLists.txt, in its order.
const sim::Catalogue& catalogue();

}  // namespace trephine::modules
