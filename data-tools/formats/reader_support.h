// Common parts of the readers of all formats: allocation, errors, selection of a volume, frames, units.
#pragma once

#include "data-tools/files/subprocess.h"
#include "data-tools/formats/opened_volume.h"

namespace trephine::data_tools {

/// Allocates a volume for the size and frame of a file; `where` is the file's name in errors.
Result<volume::Volume> allocate_volume(const glm::ivec3& size, const Result<volume::Frame>& frame,
                                       const std::string& where);
/// Returns the error for contents that do not fit into memory.
Error too_large(std::size_t bytes, const std::string& where);
/// Error if `bytes` exceed the available memory.
Status check_memory(std::size_t bytes, const std::string& where);
/// Returns the error for cancelled reading.
Error reading_interrupted(const std::string& where);

/// Converts the result of child processes to a status; `where` is the name of the file in errors.
Status subprocess_status(const SubprocessResult& result, const std::string& where);

/// Returns the index of the requested volume, from 0; error if it does not exist.
Result<std::size_t> volume_index(const OpenOptions& options, std::size_t volumes, const std::string& where);
/// Returns the axes of the options, scaled by their spacing, mm. The spacing is 1 mm by default.
glm::dmat3 axes_from_options(const OpenOptions& options);
/// Returns the frame for a file without one, from the options, and adds a notice. Error if the options have
/// no spacing.
Result<volume::Frame> frame_from_options(OpenedVolume& opened, const OpenOptions& options,
                                         const std::string& where);
/// Adds a notice about the selected volume.
void add_volume_notice(OpenedVolume& opened, std::size_t index, std::size_t volumes);
/// Sets Hounsfield units and modality CT if the file states Hounsfield units, or if guess_hounsfield()
/// detects them; the second case adds a notice.
void detect_units(OpenedVolume& opened, bool states_hounsfield);
/// Returns the largest distance between corresponding corners of a volume in two frames, mm.
double max_corner_distance(const volume::Frame& a, const volume::Frame& b, const glm::ivec3& size);
/// Returns true if a file name in a header refers to a file outside the header's folder.
bool escapes_folder(const std::string& name);

}  // namespace trephine::data_tools
