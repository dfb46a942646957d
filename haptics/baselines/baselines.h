// add_methods(): published contact methods, for comparison.
#pragma once

namespace trephine::haptics::baselines {

/// Adds the published methods to the catalogue of methods. Call it before other threads use the catalogue.
void add_methods();

}  // namespace trephine::haptics::baselines
