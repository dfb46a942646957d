// NIfTI in, by niftilib. (ITK 5.2 refuses affines that are off right angles by a rounding, which are common.)
#pragma once

#include "data-tools/open_volume.h"

namespace trephine::data_tools {

/// See open_volume. The sform is taken before the qform; a notice says when they disagree.
volume::Result<OpenedVolume> open_nifti(const std::string& path, const OpenOptions& options);

}  // namespace trephine::data_tools
