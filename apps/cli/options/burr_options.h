// Options of a burr, from the table of its fields.
#pragma once

#include "apps/cli/options/options.h"
#include "modules/drilling/burr.h"

namespace trephine::cli {

/// Adds --burr-diameter, --burr-shape, --burr-length, --shaft, --grade, --rpm, --dry, --removal-rate,
/// --feed-limit and --round. Returns --burr-diameter.
Option add_burr(Options& options, drilling::Burr& burr);

}  // namespace trephine::cli
