// Options from tables of fields: name, unit, range and help are defined once.
#pragma once

#include "apps/cli/options/options.h"
#include "sim/api/fields.h"

namespace trephine::cli {

/// Adds the option of a field of `object`. Errors of libraries name it with its struct: "burr diameter".
Option add_field(Options& options, const sim::Schema& schema, void* object, std::string_view field,
                 const char* names);

}  // namespace trephine::cli
