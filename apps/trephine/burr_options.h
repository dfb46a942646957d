// The options of a burr, by the table of its parameters.
#pragma once

#include "apps/trephine/options.h"
#include "modules/drilling/burr.h"

namespace trephine::app {

/// --burr-diameter, which is returned, --burr-shape, --burr-length, --shaft, --grade, --rpm, --dry,
/// --removal-rate, --feed-limit, --round.
Option add_burr(Options& options, drilling::Burr& burr);

}  // namespace trephine::app
