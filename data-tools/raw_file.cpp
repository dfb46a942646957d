#include "data-tools/raw_file.h"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cstring>
#include <sstream>

#include "data-tools/atomic_file.h"
#include "data-tools/byte_source.h"
#include "data-tools/opening.h"
#include "data-tools/voxel_values.h"

namespace trephine::data_tools {

using volume::Error;
using volume::Result;

namespace {

struct NumberType {
  const char* name;
  std::size_t bytes;
  ValueReader (*values)(const void*);
};
template <class T>
ValueReader plain(const void* data) {
  return values_of<T>(data);
}
constexpr std::array<NumberType, 8> k_types{{{"uint8", 1, plain<std::uint8_t>},
                                             {"int8", 1, plain<std::int8_t>},
                                             {"uint16", 2, plain<std::uint16_t>},
                                             {"int16", 2, plain<std::int16_t>},
                                             {"uint32", 4, plain<std::uint32_t>},
                                             {"int32", 4, plain<std::int32_t>},
                                             {"float", 4, plain<float>},
                                             {"double", 8, plain<double>}}};

struct Layout {
  glm::ivec3 size{0};
  NumberType type = k_types[0];
  bool is_big = false;
  std::uint64_t skip = 0;
};

template <class T>
bool parse_whole(const std::string& text, T& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size();
}

Result<Layout> parse_layout(const std::string& text) {
  const Error bad{"this is no layout of numbers", "raw", text,
                  "X,Y,Z,TYPE[,big][,skip=N] with TYPE uint8, int8, uint16, int16, uint32, int32, float or "
                  "double",
                  "for example 512,512,300,int16"};
  std::vector<std::string> words;
  std::istringstream in(text);
  for (std::string word; std::getline(in, word, ',');) words.push_back(word);
  Layout layout;
  if (words.size() < 4) return bad;
  for (std::size_t a = 0; a < 3; ++a)
    if (int n = 0; parse_whole(words[a], n) && n > 0)
      layout.size[static_cast<int>(a)] = n;
    else
      return bad;
  const auto type = std::find_if(k_types.begin(), k_types.end(),
                                 [&](const NumberType& one) { return words[3] == one.name; });
  if (type == k_types.end()) return bad;
  layout.type = *type;
  for (std::size_t i = 4; i < words.size(); ++i) {
    if (words[i] == "big")
      layout.is_big = true;
    else if (words[i] != "little" &&
             !(words[i].starts_with("skip=") && parse_whole(words[i].substr(5), layout.skip)))
      return bad;
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
  if (!source) return Error{"the file cannot be read", where, "", "a plain file", ""};
  OpenedVolume opened;
  opened.format = "raw";
  const Result<volume::Frame> frame = given_frame(opened, options, where);
  if (!frame) return frame.error();
  // The file first, the memory for it then.
  std::size_t bytes = layout.type.bytes;
  bool fits = true;
  for (int a = 0; a < 3; ++a)
    fits = fits && !__builtin_mul_overflow(bytes, static_cast<std::size_t>(layout.size[a]), &bytes);
  const std::uint64_t held = source->size() - std::min(layout.skip, source->size());
  const std::size_t one = fits ? bytes : 0;
  if (one == 0 || held < one || held % one != 0)
    return Error{"the file has another size than its layout", where,
                 std::to_string(held) + " bytes of numbers",
                 fits ? std::to_string(one) + " bytes a volume of " + options.raw : "a size that can be",
                 "is it size, type, or a header to skip (skip=N)?"};
  const std::size_t volumes = held / one;
  const Result<std::size_t> index = volume_index(options, volumes, where);
  if (!index) return index.error();
  Result<volume::Volume> made = make_room(layout.size, frame, where);
  if (!made) return made.error();
  if (volume::Status error = check_memory(one, where)) return *error;
  opened.volume = std::move(made).value();
  volume::Buffer<char> numbers(one);
  constexpr std::size_t k_part = 64u << 20;
  for (std::size_t done = 0; done < one; done += k_part) {
    if (options.progress && !options.progress(static_cast<double>(done) / static_cast<double>(one)))
      return reading_interrupted(where);
    if (!source->read(layout.skip + index.value() * one + done, numbers.data() + done,
                      std::min(k_part, one - done)))
      return Error{"the file cannot be read", where, "it ended while it was read", "a whole file", ""};
  }
  if (layout.is_big != (std::endian::native == std::endian::big) && layout.type.bytes > 1)
    for (std::size_t i = 0; i < one; i += layout.type.bytes)
      std::reverse(numbers.data() + i, numbers.data() + i + layout.type.bytes);
  const std::size_t told = opened.notices.size();
  if (volume::Status error = fill_voxels(opened.volume, layout.type.values(numbers.data()), options.scale,
                                         where, opened.notices))
    return *error;
  opened.is_rounded = opened.notices.size() > told;
  if (volumes > 1) tell_volumes(opened, index.value(), volumes);
  know_units(opened, false);
  return opened;
}

}  // namespace trephine::data_tools
