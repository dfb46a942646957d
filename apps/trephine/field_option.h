// Options out of tables of fields: name, unit, range and help are said once.
#pragma once

#include "apps/trephine/options.h"
#include "sim/fields.h"

namespace trephine::app {

/// The option of a field of a struct. Errors speak of it as the struct's: "burr diameter".
Option add_field(Options& options, const sim::Schema& schema, void* of, std::string_view field,
                 const char* called);

}  // namespace trephine::app
