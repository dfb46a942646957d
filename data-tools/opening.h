// Common parts of readers of all formats: room for what they read, the words of what can go wrong, the choice
// of one volume of several, units.
#pragma once

#include "data-tools/apart.h"
#include "data-tools/open_volume.h"

namespace trephine::data_tools {

/// A volume to be filled, of what a file says of its place; errors are those of `where`.
volume::Result<volume::Volume> make_room(const glm::ivec3& size, const volume::Result<volume::Frame>& frame,
                                         const std::string& where);
/// Error of contents that do not fit into memory; check_memory() gives it when they do not.
volume::Error too_large(std::size_t bytes, const std::string& where);
volume::Status check_memory(std::size_t bytes, const std::string& where);
volume::Error reading_interrupted(const std::string& where);

/// End of work in processes of their own, in words.
volume::Status apart_status(const ApartResult& ended, const std::string& where);

/// The chosen one of several volumes, from 0; error when there is no such one.
volume::Result<std::size_t> volume_index(const OpenOptions& options, std::size_t volumes,
                                         const std::string& where);
/// Spacing and axes of the options; 1 mm and LPS where they are not given.
glm::dmat3 given_axes(const OpenOptions& options);
/// The frame of a file that does not say it, by spacing and axes of the options, which must be there; with a
/// notice.
volume::Result<volume::Frame> given_frame(OpenedVolume& opened, const OpenOptions& options,
                                          const std::string& where);
/// Says so when there was a choice.
void tell_volumes(OpenedVolume& opened, std::size_t index, std::size_t volumes);
/// Hounsfield units by the file's word, or else by evidence, with a notice.
void know_units(OpenedVolume& opened, bool says_hounsfield);
/// Largest distance between the corners of a volume in two frames, mm.
double farthest_corner(const volume::Frame& a, const volume::Frame& b, const glm::ivec3& size);
/// Names a file that does not lie in its header's folder, or below: not part of it.
bool leaves_folder(const std::string& name);

}  // namespace trephine::data_tools
