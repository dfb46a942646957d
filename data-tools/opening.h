// What readers of all formats share: room for what they read, the words of what can go wrong, the choice of
// one volume of several, units.
#pragma once

#include "data-tools/apart.h"
#include "data-tools/open_volume.h"

namespace trephine::data_tools {

/// A volume to be filled, of what a file says of its place; errors are those of `where`.
volume::Result<volume::Volume> make_room(const glm::ivec3& size, const volume::Result<volume::Frame>& frame,
                                         const std::string& where);
/// Of contents that do not fit into memory; check_memory() gives it when they do not.
volume::Error too_large(std::size_t bytes, const std::string& where);
volume::Status check_memory(std::size_t bytes, const std::string& where);
volume::Error reading_interrupted(const std::string& where);

/// How work in processes of their own ended, in words.
volume::Status apart_status(const ApartResult& ended, const std::string& where);

/// Which of several volumes is meant, from 0; error when there is none such.
volume::Result<std::size_t> volume_index(const OpenOptions& options, std::size_t volumes,
                                         const std::string& where);
/// What the options say of spacing and axes; 1 mm and LPS where they do not.
glm::dmat3 given_axes(const OpenOptions& options);
/// The frame of a file that does not say it, by spacing and axes of the options, which must be there; told.
volume::Result<volume::Frame> given_frame(OpenedVolume& opened, const OpenOptions& options,
                                          const std::string& where);
/// Says so when there was a choice.
void tell_volumes(OpenedVolume& opened, std::size_t index, std::size_t volumes);
/// Hounsfield units by the file's word, or else by evidence, which is told.
void know_units(OpenedVolume& opened, bool says_hounsfield);
/// How far apart two frames put the corners of a volume, mm, at most.
double farthest_corner(const volume::Frame& a, const volume::Frame& b, const glm::ivec3& size);
/// Names a file that does not lie in its header's folder, or below: somebody else's.
bool leaves_folder(const std::string& name);

}  // namespace trephine::data_tools
