// Projects of InVesalius (.inv3): an archive with the scan and what was made of it.
#pragma once

#include "data-tools/open_volume.h"

namespace trephine::data_tools {

/// See open_volume. The scan alone; who and when stay behind.
volume::Result<OpenedVolume> open_invesalius(const std::string& path, const OpenOptions& options);

}  // namespace trephine::data_tools
