#include "data-tools/formats/reader_support.h"

#include <algorithm>
#include <filesystem>
#include <glm/geometric.hpp>

#include "data-tools/formats/voxel_values.h"

namespace trephine::data_tools {

namespace fs = std::filesystem;

Result<volume::Volume> allocate_volume(const glm::ivec3& size, const Result<volume::Frame>& frame,
                                       const std::string& where) {
  Result<volume::Volume> result =
      frame ? volume::make_volume(size, frame.value()) : Result<volume::Volume>(frame.error());
  if (result) return result;
  Error error = result.error();
  error.where = where;
  return error;
}

Error too_large(std::size_t bytes, const std::string& where) {
  return Error{.what = "the file is larger than the available memory",
               .where = where,
               .found = std::to_string(bytes >> 20) + " MiB",
               .expected = "at most " + std::to_string(volume::available_memory_bytes() >> 20) + " MiB",
               .remedy = "crop or resample it, or close other programs",
               .kind = ErrorKind::missing_here};
}

Status check_memory(std::size_t bytes, const std::string& where) {
  return bytes <= volume::available_memory_bytes() ? std::nullopt : Status(too_large(bytes, where));
}

Error reading_interrupted(const std::string& where) {
  return Error{.what = "reading was interrupted", .where = where, .kind = ErrorKind::interrupted};
}

Status subprocess_status(const SubprocessResult& result, const std::string& where) {
  switch (result.end) {
    case SubprocessResult::End::done:
      return std::nullopt;
    case SubprocessResult::End::stopped:
      return reading_interrupted(where);
    case SubprocessResult::End::failed:
      break;
  }
  return Error{.what = "the file cannot be processed",
               .where = where,
               .found = result.found,
               .expected = "a complete file of its format",
               .remedy = "copy or export it again; if it is complete, free memory"};
}

double max_corner_distance(const volume::Frame& a, const volume::Frame& b, const glm::ivec3& size) {
  double largest = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec3 at = glm::dvec3(size - 1) * glm::dvec3(corner & 1, corner >> 1 & 1, corner >> 2);
    largest = std::max(largest, glm::length(a.world_from_volume(at) - b.world_from_volume(at)));
  }
  return largest;
}

bool escapes_folder(const std::string& name) {
  const fs::path path(name);
  return path.is_absolute() ||
         std::any_of(path.begin(), path.end(), [](const fs::path& part) { return part == ".."; });
}

Result<std::size_t> volume_index(const OpenOptions& options, std::size_t volumes, const std::string& where) {
  if (options.volume <= static_cast<int>(std::min<std::size_t>(volumes, 1'000'000)) && options.volume >= 0)
    return static_cast<std::size_t>(std::max(options.volume - 1, 0));
  return Error{.what = "unknown volume of the file",
               .where = where,
               .found = std::to_string(options.volume),
               .expected = "1 to " + std::to_string(volumes),
               .remedy = "choose another volume (option volume)"};
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

glm::dmat3 axes_from_options(const OpenOptions& options) {
  glm::dmat3 axes = axes_of(options.axes).value_or(glm::dmat3(1.0));
  for (int a = 0; a < 3; ++a) axes[a] *= options.spacing.value_or(glm::dvec3(1.0))[a];
  return axes;
}

Result<volume::Frame> frame_from_options(OpenedVolume& opened, const OpenOptions& options,
                                         const std::string& where) {
  if (!options.spacing)
    return Error{
        .what = "the voxel spacing is missing",
        .where = where,
        .expected = "the voxel size in mm",
        .remedy =
            "state the voxel size (option spacing X,Y,Z), and the axes if they are not left, back and up (option axes)"};
  opened.uses_given_frame = true;
  opened.notices.push_back(opened.format + " has no position in the patient: axes " + options.axes +
                           " (option axes) and a first voxel at 0, 0, 0 were assumed");
  return volume::Frame::from_axes(glm::dvec3(0), axes_from_options(options));
}

void detect_units(OpenedVolume& opened, bool states_hounsfield) {
  if (states_hounsfield) {
    opened.volume.is_hounsfield = true;
    opened.modality = "CT";
  } else if (const std::string notice = guess_hounsfield(opened.volume); !notice.empty()) {
    opened.modality = "CT";
    opened.notices.push_back(notice);
  }
}

void add_volume_notice(OpenedVolume& opened, std::size_t index, std::size_t volumes) {
  opened.notices.push_back("volume " + std::to_string(index + 1) + " of " + std::to_string(volumes) +
                           " was read; select another (option volume)");
}

}  // namespace trephine::data_tools
