#include "data-tools/formats/nrrd.h"

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
#include <map>
#include <memory>
#include <set>
#include <sstream>
#include <teem/nrrd.h>

#include "data-tools/files/atomic_file.h"
#include "data-tools/files/words.h"
#include "data-tools/formats/reader_support.h"
#include "data-tools/formats/voxel_values.h"
#include "volume/base/text.h"

namespace trephine::data_tools {

namespace {

using File = std::unique_ptr<Nrrd, Nrrd* (*)(Nrrd*)>;

/// Returns the signs that convert the axes of a space to LPS; empty if the space is not anatomical.
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

/// Returns the millimetres per unit of an axis of the space; empty for an unknown unit.
std::optional<double> mm_per_unit(const Nrrd& file, int axis) {
  const char* unit = file.spaceUnits[axis];
  if (unit == nullptr || *unit == '\0' || std::strcmp(unit, "mm") == 0) return 1;
  if (std::strcmp(unit, "m") == 0) return 1000;
  if (std::strcmp(unit, "cm") == 0) return 10;
  if (std::strcmp(unit, "um") == 0 || std::strcmp(unit, "microns") == 0) return 1e-3;
  return std::nullopt;
}

/// Returns the millimetres per unit of each axis of the file's space. Error for an unknown unit.
Result<glm::dvec3> space_unit_mm(const Nrrd& file, const std::string& where) {
  glm::dvec3 units(1);
  for (int axis = 0; axis < 3; ++axis) {
    const auto unit = mm_per_unit(file, axis);
    if (!unit)
      return Error{.what = "unknown unit of lengths",
                   .where = where,
                   .found = file.spaceUnits[axis],
                   .expected = "mm, cm, m or um",
                   .remedy = "export it with its space in mm"};
    units[axis] = *unit;
  }
  return units;
}

/// Axes of the file that are axes of the volume, and the volume's frame (LPS, mm).
struct Layout {
  std::array<unsigned, 3> axes{};
  glm::dvec3 origin{0.0};
  glm::dmat3 directions{1.0};
};

Result<Layout> layout_of(const Nrrd& file, const OpenOptions& options, const std::string& where) {
  Layout layout;
  // A file with "space dimension: 3" but without a space has unknown axes: the axes of the options are used
  // if the options contain a spacing.
  if (file.spaceDim == 0 || (file.space == nrrdSpaceUnknown && options.spacing)) {
    std::string spacings;
    for (unsigned a = 0; a < file.dim; ++a)
      if (std::isfinite(file.axis[a].spacing))
        spacings.append(spacings.empty() ? "" : " ").append(text_of(file.axis[a].spacing));
    if (!options.spacing)
      return Error{
          .what = "the position of the volume in the patient is missing",
          .where = where,
          .found = spacings.empty() ? "neither space directions nor spacings"
                                    : "spacings (" + spacings + ") without directions",
          .expected = "space, space directions and space origin",
          .remedy =
              "state the voxel size (option spacing X,Y,Z), and the axes if they are not left, back and up (option axes)"};
    if (file.dim < 3 || file.dim > 4)
      return Error{.what = "the file contains no volume",
                   .where = where,
                   .found = std::to_string(file.dim) + " dimensions",
                   .expected = "3, or 4 for several volumes",
                   .remedy = "export it again"};
    for (unsigned a = 0; a < 3; ++a) layout.axes[a] = a;
    layout.directions = axes_from_options(options);
    return layout;
  }
  const auto signs = signs_to_lps(file.space);
  if (!signs)
    return Error{.what = "the axes of the file are not directions of the patient",
                 .where = where,
                 .found = file.space ? airEnumStr(nrrdSpace, file.space) : "no space",
                 .expected = "left-posterior-superior, right-anterior-superior or left-anterior-superior",
                 .remedy = file.space
                               ? "export it with its anatomical space"
                               : "state the voxel size and the axes (option spacing X,Y,Z, option axes LPS)"};
  const Result<glm::dvec3> unit = space_unit_mm(file, where);
  if (!unit) return unit.error();
  std::size_t direction_count = 0;
  for (unsigned a = 0; a < file.dim; ++a) {
    const double* d = file.axis[a].spaceDirection;
    if (!std::isfinite(d[0])) continue;
    if (direction_count < 3) {
      layout.axes[direction_count] = a;
      layout.directions[static_cast<int>(direction_count)] =
          unit.value() * *signs * glm::dvec3(d[0], d[1], d[2]);
    }
    ++direction_count;
  }
  if (direction_count != 3)
    return Error{.what = "the file does not have three axes with a direction in space",
                 .where = where,
                 .found = std::to_string(direction_count) + " axes with a direction",
                 .expected = "three",
                 .remedy = "export it as one volume with three spatial axes"};
  for (int i = 0; i < 3; ++i)
    layout.origin[i] =
        std::isfinite(file.spaceOrigin[i]) ? unit.value()[i] * (*signs)[i] * file.spaceOrigin[i] : 0;
  return layout;
}

std::string value_of(const Nrrd& file, const std::string& key) {
  char* raw_value = nrrdKeyValueGet(&file, key.c_str());
  const std::string value = raw_value ? raw_value : "";
  std::free(raw_value);
  return value;
}

/// Parses a colour, "0.5 0.25 1" (0 to 1).
std::optional<glm::u8vec3> colour_of(const std::string& text) {
  std::istringstream in(text);
  in.imbue(std::locale::classic());
  glm::dvec3 c(0);
  if (!(in >> c.x >> c.y >> c.z)) return std::nullopt;
  return glm::u8vec3(glm::floor(255.0 * glm::clamp(c, 0.0, 1.0) + 0.5));
}

/// Returns Slicer's segments: Segment0_Name, Segment0_LabelValue, Segment0_Layer, ...; numbers may have gaps.
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

/// Returns true if a header refers to a data file outside its folder.
bool has_outside_data_file(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  bool is_list = false;
  std::size_t lines = 0;
  for (std::string line; std::getline(in, line) && lines++ < 100'000;) {
    while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.pop_back();
    if (line.empty()) break;
    if (is_list && escapes_folder(line)) return true;
    for (const char* key : {"data file", "datafile"})
      if (const std::optional<std::string> name = header_value(line, key)) {
        is_list = name->starts_with("LIST");
        if (!is_list && escapes_folder(*name)) return true;
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
    for (const char* key : {"data file", "datafile"}) {
      const std::string name = header_value(line, key).value_or("");
      if (name.empty() || name.starts_with("LIST") || name.find('%') != std::string::npos) continue;
      std::error_code failure;
      if (!std::filesystem::is_regular_file(std::filesystem::path(path).parent_path() / name, failure))
        return file_name(name);
    }
  }
  return "";
}

/// Fields of a header by name, and its length in bytes.
struct HeaderText {
  std::map<std::string, std::string> fields;
  std::string repeated;  ///< a field that appears twice, or ""
  std::size_t bytes = 0;
  bool has_end = false;  ///< the header ends with an empty line, before the voxels
  std::string operator[](const char* name) const {
    const auto found = fields.find(name);
    return found == fields.end() ? "" : found->second;
  }
};
HeaderText header_text(const std::string& path) {
  HeaderText text;
  std::ifstream in(path, std::ios::binary);
  std::size_t lines = 0;
  for (std::string line; std::getline(in, line) && lines++ < 100'000;) {
    text.bytes += line.size() + 1;
    while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.pop_back();
    text.has_end = line.empty();
    if (text.has_end) break;
    const std::size_t colon = line.find(": ");
    if (line[0] == '#' || colon == std::string::npos) continue;
    const std::string name = line.substr(0, colon);
    if (!text.fields.emplace(name, line.substr(colon + 2)).second) text.repeated = name;
  }
  return text;
}

/// Returns the fault of a header that teem refuses.
std::string header_fault(const HeaderText& text) {
  if (!text.repeated.empty()) return "two fields " + text.repeated;
  for (const char* name : {"type", "dimension", "sizes", "encoding"})
    if (text[name].empty()) return std::string("no field ") + name;
  std::size_t size_count = 0;
  std::istringstream sizes(text["sizes"]);
  sizes.imbue(std::locale::classic());
  for (std::string size; sizes >> size; ++size_count)
    if (const long long number = std::strtoll(size.c_str(), nullptr, 10); number < 1 || number > 1'000'000)
      return "sizes: " + text["sizes"];
  if (std::to_string(size_count) != text["dimension"])
    return "dimension: " + text["dimension"] + ", sizes: " + text["sizes"];
  const std::string type = text["type"];
  const bool is_byte = type.find("char") != std::string::npos || type.find("int8") != std::string::npos;
  if (text["endian"].empty() && !is_byte && text["encoding"] != "ascii" && text["encoding"] != "text" &&
      text["encoding"] != "txt")
    return "no field endian, for " + type + " in encoding " + text["encoding"];
  for (const char* name : {"space directions", "space origin", "spacings"})
    for (const char* word : {"nan", "NaN", "inf"})
      if (text[name].find(word) != std::string::npos) return std::string(name) + ": " + text[name];
  for (const char* name : {"line skip", "lineskip", "byte skip", "byteskip"})
    if (!text[name].empty()) return std::string(name) + ": " + text[name];
  return "no valid NRRD header";
}

/// Loads a file, or only its header; false on failure.
bool load(Nrrd* nrrd, const std::string& path, bool reads_voxels) {
  const std::unique_ptr<NrrdIoState, NrrdIoState* (*)(NrrdIoState*)> io_state(nrrdIoStateNew(),
                                                                              nrrdIoStateNix);
  io_state->skipData = !reads_voxels;
  nrrdStateVerboseIO = 0;  // keeps teem from printing
  if (nrrdLoad(nrrd, path.c_str(), io_state.get()) == 0) return true;
  std::free(biffGetDone(NRRD));  // discards teem's message
  return false;
}

}  // namespace

Result<OpenedVolume> open_nrrd(const std::string& path, const OpenOptions& options) {
  const std::string where = file_name(path);
  const auto read_error = [&](const std::string& found) {
    return Error{.what = "the NRRD file cannot be read",
                 .where = where,
                 .found = found,
                 .expected = "a complete file of that format",
                 .remedy = "copy or export it again"};
  };
  if (has_outside_data_file(path)) return read_error("voxels in a file outside its folder");
  if (const std::string name = missing_data_file(path); !name.empty())
    return read_error("no file " + name + " with the voxels");
  // Read the header before allocating memory.
  const File header(nrrdNew(), nrrdNuke);
  const HeaderText text = header_text(path);
  if (!load(header.get(), path, false)) return read_error(header_fault(text));
  if (header->type == nrrdTypeBlock || header->type <= 0) return read_error("voxels of an unknown type");
  const Result<Layout> layout = layout_of(*header, options, where);
  if (!layout) return layout.error();
  for (unsigned a = 0; a < header->dim; ++a)
    if (const int kind = header->axis[a].kind; kind == nrrdKindRGBColor || kind == nrrdKindRGBAColor ||
                                               kind == nrrdKindHSVColor || kind == nrrdKindXYZColor ||
                                               kind == nrrdKind3Color || kind == nrrdKind4Color)
      return Error{.what = "the file contains colours",
                   .where = where,
                   .found = airEnumStr(nrrdKind, kind),
                   .expected = "one grey value per voxel",
                   .remedy = "export the scan itself, without colours"};
  glm::ivec3 size(1);
  std::size_t count = 1, volumes = 1;
  std::array<std::size_t, NRRD_DIM_MAX> stride{};
  for (unsigned a = 0; a < header->dim; ++a) {
    stride[a] = count;
    if (__builtin_mul_overflow(count, header->axis[a].size, &count)) return read_error("an impossible size");
    const auto& axes = layout.value().axes;
    if (std::find(axes.begin(), axes.end(), a) == axes.end()) volumes *= header->axis[a].size;
  }
  for (std::size_t i = 0; i < 3; ++i)
    size[static_cast<int>(i)] =
        static_cast<int>(std::min<std::size_t>(header->axis[layout.value().axes[i]].size, 2'000'000'000));
  const Result<std::size_t> index = volume_index(options, volumes, where);
  if (!index) return index.error();
  Result<volume::Volume> result = allocate_volume(
      size, volume::Frame::from_axes(layout.value().origin, layout.value().directions), where);
  if (!result) return result.error();
  std::size_t bytes = 0;
  if (__builtin_mul_overflow(count, nrrdElementSize(header.get()), &bytes))
    return read_error("an impossible size");
  if (Status error = check_memory(bytes, where)) return *error;
  if (options.progress && !options.progress(0)) return reading_interrupted(where);
  const File file(nrrdNew(), nrrdNuke);
  if (!load(file.get(), path, true)) return read_error("its data are shorter than its header states");

  OpenedVolume opened;
  opened.volume = std::move(result).value();
  opened.format = "NRRD";
  opened.uses_given_frame = file->spaceDim == 0 || file->space == nrrdSpaceUnknown;
  // The remaining axes index the volumes.
  std::size_t offset = 0, remaining_index = index.value();
  for (unsigned a = 0; a < file->dim; ++a) {
    const auto& axes = layout.value().axes;
    if (std::find(axes.begin(), axes.end(), a) != axes.end()) continue;
    offset += remaining_index % file->axis[a].size * stride[a];
    remaining_index /= file->axis[a].size;
  }
  const auto& axes = layout.value().axes;
  const auto lookup = nrrdDLookup[file->type];
  const ValueReader values = [&, nx = static_cast<std::size_t>(size.x),
                              ny = static_cast<std::size_t>(size.y)](std::size_t first,
                                                                     std::span<double> range) {
    std::size_t x = first % nx, y = first / nx % ny, z = first / nx / ny;
    for (double& v : range) {
      v = lookup(file->data, offset + x * stride[axes[0]] + y * stride[axes[1]] + z * stride[axes[2]]);
      if (++x == nx && (x = 0, ++y == ny)) y = 0, ++z;
    }
  };
  const bool is_plain =
      file->type == nrrdTypeShort && volumes == 1 && !options.scale && axes[0] < axes[1] && axes[1] < axes[2];
  if (is_plain)
    std::memcpy(opened.volume.voxels.data(), file->data, opened.volume.voxels.bytes());
  else if (Status error = fill_voxels(opened.volume, values, options.scale, where, opened.notices))
    return *error;
  opened.is_rounded = !opened.notices.empty();
  std::error_code failure;
  const std::size_t file_bytes = std::filesystem::file_size(path, failure);
  if (text.has_end && text["encoding"] == "raw" && text["data file"].empty() && text["datafile"].empty() &&
      !failure && file_bytes > text.bytes + bytes)
    opened.notices.push_back(counted(file_bytes - text.bytes - bytes, "byte") +
                             " after the voxels were ignored");
  opened.segments = segments_of(*file);
  // The caller reads the layers of segments one by one: they need no notice.
  if (volumes > 1 && opened.segments.empty()) add_volume_notice(opened, index.value(), volumes);
  if (opened.segments.empty()) detect_units(opened, value_of(*file, k_units_key) == k_units);
  return opened;
}

}  // namespace trephine::data_tools
