#include "data-tools/opening.h"

#include <algorithm>
#include <filesystem>
#include <glm/geometric.hpp>

#include "data-tools/voxel_values.h"

namespace trephine::data_tools {

namespace fs = std::filesystem;
using volume::Error;
using volume::Result;

Result<volume::Volume> make_room(const glm::ivec3& size, const Result<volume::Frame>& frame,
                                 const std::string& where) {
  Result<volume::Volume> made =
      frame ? volume::make_volume(size, frame.value()) : Result<volume::Volume>(frame.error());
  if (made) return made;
  Error error = made.error();
  error.where = where;
  return error;
}

Error too_large(std::size_t bytes, const std::string& where) {
  return {"the file is larger than the memory of this machine",
          where,
          std::to_string(bytes >> 20) + " MiB",
          "at most " + std::to_string(volume::available_memory_bytes() >> 20) + " MiB",
          "crop or resample it, or close other programs",
          volume::ErrorKind::missing_here};
}

volume::Status check_memory(std::size_t bytes, const std::string& where) {
  return bytes <= volume::available_memory_bytes() ? std::nullopt : volume::Status(too_large(bytes, where));
}

Error reading_interrupted(const std::string& where) {
  return {"reading was interrupted", where, "", "", "", volume::ErrorKind::interrupted};
}

volume::Status apart_status(const ApartResult& ended, const std::string& where) {
  switch (ended.end) {
    case ApartResult::End::done:
      return std::nullopt;
    case ApartResult::End::stopped:
      return reading_interrupted(where);
    case ApartResult::End::failed:
      break;
  }
  return Error{"the file cannot be worked on", where, ended.found, "a whole file of its format",
               "copy or export it again"};
}

double farthest_corner(const volume::Frame& a, const volume::Frame& b, const glm::ivec3& size) {
  double most = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec3 at = glm::dvec3(size - 1) * glm::dvec3(corner & 1, corner >> 1 & 1, corner >> 2);
    most = std::max(most, glm::length(a.world_from_volume(at) - b.world_from_volume(at)));
  }
  return most;
}

bool leaves_folder(const std::string& name) {
  const fs::path path(name);
  return path.is_absolute() ||
         std::any_of(path.begin(), path.end(), [](const fs::path& part) { return part == ".."; });
}

Result<std::size_t> volume_index(const OpenOptions& options, std::size_t volumes, const std::string& where) {
  if (options.volume <= static_cast<int>(std::min<std::size_t>(volumes, 1'000'000)) && options.volume >= 0)
    return static_cast<std::size_t>(std::max(options.volume - 1, 0));
  return Error{"there is no such volume in the file", where, std::to_string(options.volume),
               "1 to " + std::to_string(volumes), "choose another: --volume"};
}

std::optional<glm::dmat3> axes_of(const std::string& letters) {
  constexpr std::string_view k_directions = "LPSRAI";
  if (letters.size() != 3) return std::nullopt;
  glm::dmat3 axes(0.0);
  glm::ivec3 uses(0);
  for (int a = 0; a < 3; ++a) {
    const std::size_t at = k_directions.find(letters[static_cast<std::size_t>(a)]);
    if (at == std::string_view::npos) return std::nullopt;
    const int row = static_cast<int>(at % 3);
    axes[a][row] = at < 3 ? 1 : -1;
    ++uses[row];
  }
  return uses == glm::ivec3(1) ? std::optional(axes) : std::nullopt;
}

glm::dmat3 given_axes(const OpenOptions& options) {
  glm::dmat3 axes = axes_of(options.axes).value_or(glm::dmat3(1.0));
  for (int a = 0; a < 3; ++a) axes[a] *= options.spacing.value_or(glm::dvec3(1.0))[a];
  return axes;
}

Result<volume::Frame> given_frame(OpenedVolume& opened, const OpenOptions& options,
                                  const std::string& where) {
  if (!options.spacing)
    return Error{"the file does not say how large its voxels are", where, "", "their size in mm",
                 "say it: --spacing X,Y,Z; and where x, y and z go, if not to the left, back and up: --axes"};
  opened.uses_given_frame = true;
  opened.notices.push_back(opened.format +
                           " does not say how it lies in the patient: its axes were taken as " +
                           options.axes + " (--axes), its first voxel as 0, 0, 0");
  return volume::Frame::from_axes(glm::dvec3(0), given_axes(options));
}

void know_units(OpenedVolume& opened, bool says_hounsfield) {
  if (says_hounsfield) {
    opened.volume.is_hounsfield = true;
    opened.modality = "CT";
  } else if (const std::string notice = guess_hounsfield(opened.volume); !notice.empty()) {
    opened.modality = "CT";
    opened.notices.push_back(notice);
  }
}

void tell_volumes(OpenedVolume& opened, std::size_t index, std::size_t volumes) {
  opened.notices.push_back("volume " + std::to_string(index + 1) + " of " + std::to_string(volumes) +
                           " was taken: --volume chooses");
}

}  // namespace trephine::data_tools
