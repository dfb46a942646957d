#include "data-tools/formats/raw_file.h"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cstring>
#include <sstream>

#include "data-tools/files/atomic_file.h"
#include "data-tools/files/byte_source.h"
#include "data-tools/formats/reader_support.h"
#include "data-tools/formats/voxel_values.h"

namespace trephine::data_tools {

namespace {

struct NumberType {
  const char* name;
  std::size_t bytes;
  ValueReader (*values)(const void*);
};
template <class T>
ValueReader read_as(const void* data) {
  return values_of<T>(data);
}
constexpr std::array<NumberType, 8> k_types{{{"uint8", 1, read_as<std::uint8_t>},
                                             {"int8", 1, read_as<std::int8_t>},
                                             {"uint16", 2, read_as<std::uint16_t>},
                                             {"int16", 2, read_as<std::int16_t>},
                                             {"uint32", 4, read_as<std::uint32_t>},
                                             {"int32", 4, read_as<std::int32_t>},
                                             {"float", 4, read_as<float>},
                                             {"double", 8, read_as<double>}}};

struct Layout {
  glm::ivec3 size{0};
  NumberType type = k_types[0];
  bool is_big_endian = false;
  std::uint64_t skip = 0;
};

template <class T>
bool parse_integer(const std::string& text, T& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size();
}

Result<Layout> parse_layout(const std::string& text) {
  const Error layout_error{
      "invalid layout of numbers", "raw", text,
      "X,Y,Z,TYPE[,big][,skip=N] with TYPE uint8, int8, uint16, int16, uint32, int32, float or "
      "double",
      "state size and type of the numbers, for example 512,512,300,int16"};
  std::vector<std::string> words;
  std::istringstream in(text);
  for (std::string word; std::getline(in, word, ',');) words.push_back(word);
  Layout layout;
  if (words.size() < 4) return layout_error;
  for (std::size_t a = 0; a < 3; ++a)
    if (int n = 0; parse_integer(words[a], n) && n > 0)
      layout.size[static_cast<int>(a)] = n;
    else
      return layout_error;
  const auto type = std::find_if(k_types.begin(), k_types.end(), [&](const NumberType& type_candidate) {
    return words[3] == type_candidate.name;
  });
  if (type == k_types.end()) return layout_error;
  layout.type = *type;
  for (std::size_t i = 4; i < words.size(); ++i) {
    if (words[i] == "big")
      layout.is_big_endian = true;
    else if (words[i] != "little" &&
             !(words[i].starts_with("skip=") && parse_integer(words[i].substr(5), layout.skip)))
      return layout_error;
  }
  return layout;
}

}  // namespace

Result<OpenedVolume> open_raw(const std::string& path, const OpenOptions& options) {
  const std::string where = file_name(path);
  const Result<Layout> parsed = parse_layout(options.raw);
  if (!parsed) return parsed.error();
  const Layout& layout = parsed.value();
  const auto source = ByteSource::open(path);
  if (!source)
    return Error{.what = "the file cannot be read",
                 .where = where,
                 .expected = "a plain file",
                 .remedy = "check that you may read it"};
  OpenedVolume opened;
  opened.format = "raw";
  const Result<volume::Frame> frame = frame_from_options(opened, options, where);
  if (!frame) return frame.error();
  // Check the file before allocating memory.
  std::size_t bytes = layout.type.bytes;
  bool fits = true;
  for (int a = 0; a < 3; ++a)
    fits = fits && !__builtin_mul_overflow(bytes, static_cast<std::size_t>(layout.size[a]), &bytes);
  const std::uint64_t data_bytes = source->size() - std::min(layout.skip, source->size());
  const std::size_t volume_bytes = fits ? bytes : 0;
  if (volume_bytes == 0 || data_bytes < volume_bytes || data_bytes % volume_bytes != 0)
    return Error{.what = "the size of the file does not match its layout",
                 .where = where,
                 .found = std::to_string(data_bytes) + " bytes of numbers",
                 .expected = fits ? std::to_string(volume_bytes) + " bytes per volume of " + options.raw
                                  : "a possible size",
                 .remedy = "check size and type; skip a header with skip=N"};
  const std::size_t volumes = data_bytes / volume_bytes;
  const Result<std::size_t> index = volume_index(options, volumes, where);
  if (!index) return index.error();
  Result<volume::Volume> result = allocate_volume(layout.size, frame, where);
  if (!result) return result.error();
  if (Status error = check_memory(volume_bytes, where)) return *error;
  opened.volume = std::move(result).value();
  Buffer<char> numbers(volume_bytes);
  constexpr std::size_t k_part = 64u << 20;
  for (std::size_t offset = 0; offset < volume_bytes; offset += k_part) {
    if (options.progress &&
        !options.progress(static_cast<double>(offset) / static_cast<double>(volume_bytes)))
      return reading_interrupted(where);
    if (!source->read(layout.skip + index.value() * volume_bytes + offset, numbers.data() + offset,
                      std::min(k_part, volume_bytes - offset)))
      return Error{.what = "the file cannot be read",
                   .where = where,
                   .found = "it ended while it was read",
                   .expected = "a complete file",
                   .remedy = "copy it again"};
  }
  if (layout.is_big_endian != (std::endian::native == std::endian::big) && layout.type.bytes > 1)
    for (std::size_t i = 0; i < volume_bytes; i += layout.type.bytes)
      std::reverse(numbers.data() + i, numbers.data() + i + layout.type.bytes);
  const std::size_t notice_count = opened.notices.size();
  if (Status error = fill_voxels(opened.volume, layout.type.values(numbers.data()), options.scale, where,
                                 opened.notices))
    return *error;
  opened.is_rounded = opened.notices.size() > notice_count;
  if (volumes > 1) add_volume_notice(opened, index.value(), volumes);
  detect_units(opened, false);
  return opened;
}

}  // namespace trephine::data_tools
