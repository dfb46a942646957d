// MetaImage in, MetaImage and NRRD out, by ITK's ImageIO; and what formats have in common.
#pragma once

#include "data-tools/open_volume.h"

namespace trephine::data_tools {

/// See open_volume.
volume::Result<OpenedVolume> open_image_file(const std::string& path, const OpenOptions& options);

/// Which of several volumes is meant, from 0; error when there is none such.
volume::Result<std::size_t> volume_index(const OpenOptions& options, std::size_t volumes,
                                         const std::string& where);
/// Says so when there was a choice.
void tell_volumes(OpenedVolume& opened, std::size_t index, std::size_t volumes);

/// Hounsfield units by the file's word, or else by evidence, which is told.
void know_units(OpenedVolume& opened, bool says_hounsfield);

/// Names a file that does not lie in its header's folder, or below: somebody else's.
bool leaves_folder(const std::string& name);

}  // namespace trephine::data_tools
