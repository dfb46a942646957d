// Modules of this build.
#pragma once

#include "sim/catalogue.h"

namespace trephine::modules {

/// All modules of modules/CMakeLists.txt, in its order.
const sim::Catalogue& catalogue();

}  // namespace trephine::modules
