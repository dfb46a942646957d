// NRRD in, by teem, whose format it is.
#pragma once

#include "data-tools/open_volume.h"

namespace trephine::data_tools {

/// See open_volume. Any space of a patient, any order of axes; one of several volumes.
volume::Result<OpenedVolume> open_nrrd(const std::string& path, const OpenOptions& options);

}  // namespace trephine::data_tools
