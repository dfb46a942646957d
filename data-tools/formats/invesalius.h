// open_invesalius(): reads the scan of an InVesalius project, which is an archive (.inv3).
#pragma once

#include "data-tools/formats/opened_volume.h"

namespace trephine::data_tools {

/// Reads only the scan, without patient data; see open_volume().
Result<OpenedVolume> open_invesalius(const std::string& path, const OpenOptions& options);

}  // namespace trephine::data_tools
