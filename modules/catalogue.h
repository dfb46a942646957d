// Catalogue of the modules of a program: the modules of this build, and those that the program adds or loads.
#pragma once

#include <string>

#include "sim/api/catalogue.h"

namespace trephine::modules {

/// Returns all modules of modules/CMakeLists.txt in its order, then those that were added.
const sim::Catalogue& catalogue();

/// Adds a module. The module must outlive all uses of the catalogue. Operations that already run keep their
/// modules. Error if the name of the module, or of one of its types, is in use. Call before other threads use
/// the catalogue.
Status add_module(const sim::Module& module);

/// Loads a shared library with a module (sim/api/module_export.h) and adds the module. The library stays
/// loaded. Errors name the file: it cannot be loaded, it has no module, or it was built against another
/// version.
Result<const sim::Module*> load_module(const std::string& path);

}  // namespace trephine::modules
