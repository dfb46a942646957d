// Adds the published methods to the catalogue of a test program.
#include "haptics/baselines/baselines.h"

namespace {
const bool is_added = (trephine::haptics::baselines::add_methods(), true);
}  // namespace
