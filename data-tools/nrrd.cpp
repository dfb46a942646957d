#include "data-tools/nrrd.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <locale>
#include <memory>
#include <set>
#include <sstream>
#include <teem/nrrd.h>

#include "data-tools/atomic_file.h"
#include "data-tools/opening.h"
#include "data-tools/voxel_values.h"
#include "data-tools/words.h"
#include "volume/text.h"

namespace trephine::data_tools {

using volume::Error;
using volume::Result;

namespace {

using File = std::unique_ptr<Nrrd, Nrrd* (*)(Nrrd*)>;

/// Signs that bring a space's axes to left, posterior, superior; nothing: it is not one of a patient.
std::optional<glm::dvec3> signs_to_lps(int space) {
  switch (space) {
    case nrrdSpaceLeftPosteriorSuperior:
    case nrrdSpaceLeftPosteriorSuperiorTime:
      return glm::dvec3(1, 1, 1);
    case nrrdSpaceRightAnteriorSuperior:
    case nrrdSpaceRightAnteriorSuperiorTime:
      return glm::dvec3(-1, -1, 1);
    case nrrdSpaceLeftAnteriorSuperior:
    case nrrdSpaceLeftAnteriorSuperiorTime:
      return glm::dvec3(1, -1, 1);
    default:
      return std::nullopt;
  }
}

/// Returns the millimetres per unit of an axis of the space; nothing for an unknown unit.
std::optional<double> mm_per_unit(const Nrrd& file, int axis) {
  const char* unit = file.spaceUnits[axis];
  if (unit == nullptr || *unit == '\0' || std::strcmp(unit, "mm") == 0) return 1;
  if (std::strcmp(unit, "m") == 0) return 1000;
  if (std::strcmp(unit, "cm") == 0) return 10;
  if (std::strcmp(unit, "um") == 0 || std::strcmp(unit, "microns") == 0) return 1e-3;
  return std::nullopt;
}

/// Returns the millimetres per unit of each axis of the file's space. Error when a unit is unknown.
Result<glm::dvec3> space_unit_mm(const Nrrd& file, const std::string& where) {
  glm::dvec3 units(1);
  for (int axis = 0; axis < 3; ++axis) {
    const auto unit = mm_per_unit(file, axis);
    if (!unit)
      return Error{"the unit of the file's space is not known", where, file.spaceUnits[axis],
                   "mm, cm, m or um", "export it with its space in mm"};
    units[axis] = *unit;
  }
  return units;
}

/// Axes of the file that are those of the volume, and its place.
struct Layout {
  std::array<unsigned, 3> axes{};
  glm::dvec3 origin{0.0};
  glm::dmat3 directions{1.0};
};

Result<Layout> layout_of(const Nrrd& file, const OpenOptions& options, const std::string& where) {
  Layout layout;
  // "space dimension: 3" alone does not name the axes: then those of the options count, where they are given.
  if (file.spaceDim == 0 || (file.space == nrrdSpaceUnknown && options.spacing)) {
    std::string spacings;
    for (unsigned a = 0; a < file.dim; ++a)
      if (std::isfinite(file.axis[a].spacing))
        spacings.append(spacings.empty() ? "" : " ").append(volume::text_of(file.axis[a].spacing));
    if (!options.spacing)
      return Error{"the file does not say how the volume lies in the patient", where,
                   spacings.empty() ? "neither space directions nor spacings"
                                    : "spacings (" + spacings + ") without directions",
                   "space, space directions and space origin",
                   "say how large a voxel is, --spacing X,Y,Z, and where x, y and z go, if not to the left, "
                   "back and up: "
                   "--axes"};
    if (file.dim < 3 || file.dim > 4)
      return Error{"the file holds no volume", where, std::to_string(file.dim) + " dimensions", "3",
                   "export it again"};
    for (unsigned a = 0; a < 3; ++a) layout.axes[a] = a;
    layout.directions = given_axes(options);
    return layout;
  }
  const auto signs = signs_to_lps(file.space);
  if (!signs)
    return Error{"the file's axes are not named by directions of the patient", where,
                 file.space ? airEnumStr(nrrdSpace, file.space) : "no space",
                 "left-posterior-superior, right-anterior-superior or left-anterior-superior",
                 file.space ? "export it with its anatomical space"
                            : "state the voxel size and the axes: --spacing X,Y,Z --axes LPS"};
  const Result<glm::dvec3> unit = space_unit_mm(file, where);
  if (!unit) return unit.error();
  std::size_t found = 0;
  for (unsigned a = 0; a < file.dim; ++a) {
    const double* d = file.axis[a].spaceDirection;
    if (!std::isfinite(d[0])) continue;
    if (found < 3) {
      layout.axes[found] = a;
      layout.directions[static_cast<int>(found)] = unit.value() * *signs * glm::dvec3(d[0], d[1], d[2]);
    }
    ++found;
  }
  if (found != 3)
    return Error{"the file does not say how the volume lies in the patient", where,
                 std::to_string(found) + " directions", "three", "export it again"};
  for (int i = 0; i < 3; ++i)
    layout.origin[i] =
        std::isfinite(file.spaceOrigin[i]) ? unit.value()[i] * (*signs)[i] * file.spaceOrigin[i] : 0;
  return layout;
}

std::string value_of(const Nrrd& file, const std::string& key) {
  char* found = nrrdKeyValueGet(&file, key.c_str());
  const std::string value = found ? found : "";
  std::free(found);
  return value;
}

/// "0.5 0.25 1", shares of 1.
std::optional<glm::u8vec3> colour_of(const std::string& text) {
  std::istringstream in(text);
  in.imbue(std::locale::classic());
  glm::dvec3 c(0);
  if (!(in >> c.x >> c.y >> c.z)) return std::nullopt;
  return glm::u8vec3(glm::floor(255.0 * glm::clamp(c, 0.0, 1.0) + 0.5));
}

/// Slicer's: Segment0_Name, Segment0_LabelValue, Segment0_Layer, and so on; numbers may be left out.
std::vector<SegmentFacts> segments_of(const Nrrd& file) {
  std::set<int> numbers;
  for (unsigned k = 0; k < nrrdKeyValueSize(&file); ++k) {
    char *key = nullptr, *value = nullptr;
    nrrdKeyValueIndex(&file, &key, &value, k);
    int number = -1, end = 0;
    if (key && std::sscanf(key, "Segment%6d_%n", &number, &end) == 1 && end > 0 && number >= 0)
      numbers.insert(number);
    std::free(key);
    std::free(value);
  }
  std::vector<SegmentFacts> segments;
  for (const int i : numbers) {
    std::string key = "Segment";
    key.append(std::to_string(i)).append("_");
    const std::string name = utf8_text(value_of(file, key + "Name")),
                      value = value_of(file, key + "LabelValue");
    const std::string layer_text = value_of(file, key + "Layer");
    const long number = std::strtol(value.c_str(), nullptr, 10),
               layer = std::strtol(layer_text.c_str(), nullptr, 10);
    // Slicer before 4.11 wrote neither field: segment i is component i, with value 1.
    const bool is_before_layers = value.empty() && layer_text.empty();
    segments.push_back({name,
                        is_before_layers               ? 1
                        : number > 0 && number < 32768 ? static_cast<int>(number)
                                                       : i + 1,
                        is_before_layers             ? i
                        : layer >= 0 && layer < 4096 ? static_cast<int>(layer)
                                                     : 0,
                        colour_of(value_of(file, key + "Color"))});
  }
  return segments;
}

/// Data file of a header whose voxels lie apart.
bool names_file_elsewhere(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  bool is_list = false;
  std::size_t lines = 0;
  for (std::string line; std::getline(in, line) && lines++ < 100'000;) {
    while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.pop_back();
    if (line.empty()) break;
    if (is_list && leaves_folder(line)) return true;
    for (const char* key : {"data file:", "datafile:"})
      if (line.starts_with(key)) {
        const std::size_t at = line.find_first_not_of(' ', std::strlen(key));
        const std::string name = at == std::string::npos ? "" : line.substr(at);
        is_list = name.starts_with("LIST");
        if (!is_list && leaves_folder(name)) return true;
      }
  }
  return false;
}

/// Returns the name of a detached data file that does not exist, or "".
std::string missing_data_file(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::size_t lines = 0;
  for (std::string line; std::getline(in, line) && lines++ < 1000;) {
    while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.pop_back();
    if (line.empty()) break;
    for (const char* key : {"data file:", "datafile:"}) {
      if (!line.starts_with(key)) continue;
      const std::size_t at = line.find_first_not_of(' ', std::strlen(key));
      const std::string name = at == std::string::npos ? "" : line.substr(at);
      if (name.empty() || name.starts_with("LIST") || name.find('%') != std::string::npos) continue;
      std::error_code failed;
      if (!std::filesystem::is_regular_file(std::filesystem::path(path).parent_path() / name, failed))
        return file_name(name);
    }
  }
  return "";
}

bool load(Nrrd* into, const std::string& path, bool wants_voxels) {
  const std::unique_ptr<NrrdIoState, NrrdIoState* (*)(NrrdIoState*)> how(nrrdIoStateNew(), nrrdIoStateNix);
  how->skipData = !wants_voxels;
  nrrdStateVerboseIO = 0;  // it would talk to the person itself
  if (nrrdLoad(into, path.c_str(), how.get()) == 0) return true;
  std::free(biffGetDone(NRRD));  // its words are for programmers
  return false;
}

}  // namespace

Result<OpenedVolume> open_nrrd(const std::string& path, const OpenOptions& options) {
  const std::string where = file_name(path);
  const auto broken = [&](const std::string& found) {
    return Error{"the NRRD file cannot be read", where, found, "a complete file of that format",
                 "copy or export it again"};
  };
  if (names_file_elsewhere(path)) return broken("voxels in a file outside its folder");
  if (const std::string name = missing_data_file(path); !name.empty())
    return broken("no file " + name + " with the voxels");
  // The header first, the memory for it then.
  const File header(nrrdNew(), nrrdNuke);
  if (!load(header.get(), path, false)) return broken("no NRRD header that makes sense");
  if (header->type == nrrdTypeBlock || header->type <= 0) return broken("voxels of an unknown kind");
  const Result<Layout> layout = layout_of(*header, options, where);
  if (!layout) return layout.error();
  for (unsigned a = 0; a < header->dim; ++a)
    if (const int kind = header->axis[a].kind; kind == nrrdKindRGBColor || kind == nrrdKindRGBAColor ||
                                               kind == nrrdKindHSVColor || kind == nrrdKindXYZColor ||
                                               kind == nrrdKind3Color || kind == nrrdKind4Color)
      return Error{"the file holds colours", where, airEnumStr(nrrdKind, kind), "one grey value per voxel",
                   "export the scan itself, without colours"};
  glm::ivec3 size(1);
  std::size_t count = 1, volumes = 1;
  std::array<std::size_t, NRRD_DIM_MAX> stride{};
  for (unsigned a = 0; a < header->dim; ++a) {
    stride[a] = count;
    if (__builtin_mul_overflow(count, header->axis[a].size, &count)) return broken("a size that cannot be");
    const auto& axes = layout.value().axes;
    if (std::find(axes.begin(), axes.end(), a) == axes.end()) volumes *= header->axis[a].size;
  }
  for (std::size_t i = 0; i < 3; ++i)
    size[static_cast<int>(i)] =
        static_cast<int>(std::min<std::size_t>(header->axis[layout.value().axes[i]].size, 2'000'000'000));
  const Result<std::size_t> index = volume_index(options, volumes, where);
  if (!index) return index.error();
  Result<volume::Volume> made =
      make_room(size, volume::Frame::from_axes(layout.value().origin, layout.value().directions), where);
  if (!made) return made.error();
  std::size_t bytes = 0;
  if (__builtin_mul_overflow(count, nrrdElementSize(header.get()), &bytes))
    return broken("a size that cannot be");
  if (volume::Status error = check_memory(bytes, where)) return *error;
  if (options.progress && !options.progress(0)) return reading_interrupted(where);
  const File file(nrrdNew(), nrrdNuke);
  if (!load(file.get(), path, true)) return broken("its data end before its header says");

  OpenedVolume opened;
  opened.volume = std::move(made).value();
  opened.format = "NRRD";
  opened.uses_given_frame = file->spaceDim == 0 || file->space == nrrdSpaceUnknown;
  // The axes that are not the volume's count through the volumes.
  std::size_t offset = 0, rest = index.value();
  for (unsigned a = 0; a < file->dim; ++a) {
    const auto& axes = layout.value().axes;
    if (std::find(axes.begin(), axes.end(), a) != axes.end()) continue;
    offset += rest % file->axis[a].size * stride[a];
    rest /= file->axis[a].size;
  }
  const auto& axes = layout.value().axes;
  const auto lookup = nrrdDLookup[file->type];
  const ValueReader values = [&, nx = static_cast<std::size_t>(size.x),
                              ny = static_cast<std::size_t>(size.y)](std::size_t first,
                                                                     std::span<double> to) {
    std::size_t x = first % nx, y = first / nx % ny, z = first / nx / ny;
    for (double& v : to) {
      v = lookup(file->data, offset + x * stride[axes[0]] + y * stride[axes[1]] + z * stride[axes[2]]);
      if (++x == nx && (x = 0, ++y == ny)) y = 0, ++z;
    }
  };
  const bool is_plain =
      file->type == nrrdTypeShort && volumes == 1 && !options.scale && axes[0] < axes[1] && axes[1] < axes[2];
  if (is_plain)
    std::memcpy(opened.volume.voxels.data(), file->data, opened.volume.voxels.bytes());
  else if (volume::Status error = fill_voxels(opened.volume, values, options.scale, where, opened.notices))
    return *error;
  opened.is_rounded = !opened.notices.empty();
  opened.segments = segments_of(*file);
  // Layers of segments are read one after another.
  if (volumes > 1 && opened.segments.empty()) tell_volumes(opened, index.value(), volumes);
  if (opened.segments.empty()) know_units(opened, value_of(*file, k_units_key) == k_units);
  return opened;
}

}  // namespace trephine::data_tools
