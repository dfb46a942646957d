#include "data-tools/formats/picture_stack.h"

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <limits>
#include <new>
#include <nlohmann/json.hpp>
#include <sstream>

#include "data-tools/files/atomic_file.h"
#include "data-tools/files/subprocess.h"
#include "data-tools/files/words.h"
#include "data-tools/formats/loaded_formats.h"
#include "data-tools/formats/reader_support.h"
#include "data-tools/formats/voxel_values.h"
#include "data-tools/formats/write_volume.h"

namespace trephine::data_tools {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr const char* k_stack_file = "stack.json";
constexpr const char* k_kind = "trephine.stack";
constexpr std::size_t k_max_pictures = 20'000;
/// Limits of a stack that is read in one pass: numbers of values and of pages. The kernel does not allocate
/// unused shared memory.
constexpr std::size_t k_small_values = 16 << 20, k_small_pages = 4096;

bool is_picture(const std::string& name) {
  for (const char* end : {".png", ".tif", ".tiff", ".jpg", ".jpeg", ".bmp", ".pgm", ".jp2"})
    if (has_extension(name, end)) return true;
  return false;
}

/// Returns true if name `a` precedes `b`; numbers in the names are compared by value: slice2 before slice10.
bool comes_before(const std::string& a, const std::string& b) {
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  std::size_t i = 0, k = 0;
  while (i < a.size() && k < b.size()) {
    if (is_digit(a[i]) && is_digit(b[k])) {
      const auto number = [&](const std::string& s, std::size_t& at) {
        while (at + 1 < s.size() && s[at] == '0' && is_digit(s[at + 1])) ++at;
        const std::size_t begin = at;
        while (at < s.size() && is_digit(s[at])) ++at;
        return s.substr(begin, at - begin);
      };
      const std::string x = number(a, i), y = number(b, k);
      if (x.size() != y.size()) return x.size() < y.size();
      if (x != y) return x < y;
      continue;
    }
    if (a[i] != b[k]) return a[i] < b[k];
    ++i, ++k;
  }
  if (a.size() - i != b.size() - k) return a.size() - i < b.size() - k;
  return a < b;
}

/// Returns the pictures of a folder in order; empty if there are too many, or if the folder contains anything
/// else except .json, .txt and hidden files and Thumbs.db.
std::vector<std::string> find_pictures(const std::string& folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    if (name.front() != '.' && is_picture(name) && entry.is_regular_file(error))
      names.push_back(name);
    else if (name.front() != '.' && name != "Thumbs.db" && !has_extension(name, ".json") &&
             !has_extension(name, ".txt"))
      return {};
    if (names.size() > k_max_pictures) return {};
  }
  std::sort(names.begin(), names.end(), comes_before);
  return names;
}

/// The numbers in a name, and the name with # for each.
struct NumberedName {
  std::vector<long long> numbers;
  std::string pattern;

  explicit NumberedName(const std::string& name) {
    for (std::size_t i = 0; i < name.size();) {
      if (name[i] < '0' || name[i] > '9') {
        pattern += name[i++];
        continue;
      }
      long long number = 0;
      for (; i < name.size() && name[i] >= '0' && name[i] <= '9'; ++i)
        number = std::min(number, 100'000'000'000'000LL) * 10 + (name[i] - '0');
      numbers.push_back(number);
      pattern += '#';
    }
  }
};

/// Returns an error if the names have different patterns, or if the only number that changes is duplicated or
/// does not increase in equal steps.
Status check_consecutive(const std::vector<std::string>& names, const std::string& where) {
  std::vector<NumberedName> parsed(names.begin(), names.end());
  const auto name_error = [&](const std::string& what, const std::string& found) {
    return Error{.what = what,
                 .where = where,
                 .found = found,
                 .expected = "consecutive names: slice1, slice2, ...",
                 .remedy = "remove other files, or copy the missing ones; .json and .txt files are ignored"};
  };
  std::optional<std::size_t> counter;
  for (const NumberedName& name : parsed) {
    if (name.pattern != parsed[0].pattern || name.numbers.size() != parsed[0].numbers.size())
      return name_error("the names of the pictures have different patterns",
                        names[0] + " and " + names[static_cast<std::size_t>(&name - parsed.data())]);
    for (std::size_t k = 0; k < name.numbers.size(); ++k)
      if (name.numbers[k] != parsed[0].numbers[k]) {
        if (counter && *counter != k)
          return std::nullopt;  // several numbers change, e.g. dates: only the order is known
        counter = k;
      }
  }
  const auto step_to = [&](std::size_t i) -> long long {
    return counter ? parsed[i].numbers[*counter] - parsed[i - 1].numbers[*counter] : 0;
  };
  long long least = std::numeric_limits<long long>::max();
  for (std::size_t i = 1; i < parsed.size(); ++i) {
    if (step_to(i) == 0)
      return name_error("two pictures have the same number", names[i - 1] + " and " + names[i]);
    least = std::min(least, step_to(i));
  }
  for (std::size_t i = 1; i < parsed.size(); ++i) {
    if (step_to(i) != least)
      return name_error("pictures are missing", "no picture between " + names[i - 1] + " and " + names[i]);
  }
  return std::nullopt;
}

/// Contents of stack.json.
struct StackFile {
  glm::dvec3 origin{0.0};
  glm::dmat3 axes{1.0};
  double offset = 0;
  bool is_hounsfield = false;
  std::size_t slices = 0;
};

Result<std::optional<StackFile>> read_stack_file(const std::string& folder) {
  std::ifstream file(fs::path(folder) / k_stack_file, std::ios::binary);
  if (!file) return std::optional<StackFile>();
  std::ostringstream text;
  text << file.rdbuf();
  const json root = json::parse(text.str(), nullptr, false);
  const Error format_error{"the file next to the pictures cannot be read", k_stack_file, "",
                           "schema, origin, axes, offset and slices, as trephine writes them",
                           "remove it, and state the voxel size (option spacing)"};
  if (!root.is_object() || root.value("schema", json()) != std::string(k_kind) + "/1") return format_error;
  StackFile contents;
  try {
    for (std::size_t a = 0; a < 3; ++a) {
      contents.origin[static_cast<int>(a)] = root.at("origin").at(a).get<double>();
      for (std::size_t row = 0; row < 3; ++row)
        contents.axes[static_cast<int>(a)][static_cast<int>(row)] =
            root.at("axes").at(a).at(row).get<double>();
    }
    contents.offset = root.at("offset").get<double>();
    contents.is_hounsfield = root.at("hounsfield").get<bool>();
    contents.slices = root.at("slices").get<std::size_t>();
  } catch (const json::exception&) {
    return format_error;
  }
  return std::optional(contents);
}

struct Slice {
  std::string path, name;
  int page = 0;
};

}  // namespace

bool is_picture_stack(const std::string& path) {
  std::error_code error;
  if (fs::is_directory(path, error)) {
    const std::size_t count = find_pictures(path).size();
    return count > 1 || (count == 1 && fs::exists(fs::path(path) / k_stack_file, error));
  }
  return has_extension(path, ".tif") || has_extension(path, ".tiff");
}

Result<OpenedVolume> open_picture_stack(const std::string& path, const OpenOptions& options) {
  const std::string where = file_name(path);
  std::error_code error;
  const bool is_folder = fs::is_directory(path, error);
  OpenedVolume opened;
  opened.format = "a stack of pictures";
  std::optional<StackFile> contents;
  std::vector<Slice> slices;
  if (is_folder) {
    Result<std::optional<StackFile>> stack_file = read_stack_file(path);
    if (!stack_file) return stack_file.error();
    contents = stack_file.value();
    const std::vector<std::string> names = find_pictures(path);
    if (Status name_error = check_consecutive(names, where); name_error && !contents) return *name_error;
    for (const std::string& name : names)
      slices.push_back({(fs::path(path) / name).string(), where + "/" + name, 0});
    if (contents && contents->slices != slices.size())
      return Error{.what = "wrong number of pictures",
                   .where = where,
                   .found = counted(slices.size(), "picture"),
                   .expected = std::to_string(contents->slices) + ", as stated in " + k_stack_file,
                   .remedy = "copy all files"};
  } else {
    slices.push_back({path, where, 0});
  }
  const Result<volume::Frame> frame = contents ? volume::Frame::from_axes(contents->origin, contents->axes)
                                               : frame_from_options(opened, options, where);
  if (!frame) return frame.error();

  // Find the sizes before allocating memory. A small stack is read in the same pass: loading the library
  // takes longer than reading a few pictures.
  const auto shared = SharedBytes::make(sizeof(PictureFacts));
  auto values = SharedBytes::make(k_small_values * sizeof(float));
  auto faults = SharedBytes::make(std::max(k_small_pages, slices.size()) * sizeof(PictureFacts));
  if (!shared || !values || !faults) return too_large(k_small_values * sizeof(float), where);
  const PictureFacts& first = *new (shared->data()) PictureFacts;
  const auto read_slice = [&](const PictureLibrary& library, const std::string& file, int page, std::size_t i,
                              const PictureFacts& expected) {
    auto* const facts = new (faults->data() + i * sizeof(PictureFacts)) PictureFacts(expected);
    const std::size_t area =
        static_cast<std::size_t>(expected.width) * static_cast<std::size_t>(expected.height);
    library.read(file.c_str(), page, *facts, reinterpret_cast<float*>(values->data()) + i * area);
  };
  const auto is_small = [](const PictureFacts& facts, std::size_t count) {
    return facts.fault[0] == 0 && facts.width > 0 && facts.height > 0 && count <= k_small_pages &&
           count * static_cast<std::size_t>(facts.width) * static_cast<std::size_t>(facts.height) <=
               k_small_values;
  };
  const auto name_of = [&slices](int item) { return slices[static_cast<std::size_t>(item)].name; };
  const auto share_of = [&options](double start, double length) {
    return [&options, start, length](double share) {
      return !options.progress || options.progress(start + length * share);
    };
  };
  PictureFacts child_first;  // each child process sets its own copy
  if (Status failure = with_library(
          LoadedFormat::pictures, static_cast<int>(std::min(slices.size(), k_small_pages)), where,
          [&](const void* table, int i) {
            const auto& library = *static_cast<const PictureLibrary*>(table);
            if (child_first.width == 0) library.describe(slices[0].path.c_str(), child_first);
            if (i == 0) new (shared->data()) PictureFacts(child_first);
            const auto pages = static_cast<std::size_t>(std::max(child_first.pages, 1));
            if (!is_small(child_first, is_folder ? slices.size() : pages)) return;
            const auto n = static_cast<std::size_t>(i);
            for (std::size_t page = 0; page < (is_folder ? 1 : pages); ++page)
              read_slice(library, slices[n].path, static_cast<int>(page), n + page, child_first);
          },
          share_of(0, 0.1), name_of))
    return *failure;
  const auto slice_error = [](const Slice& slice, const std::string& found) {
    return Error{.what = "a slice cannot be used",
                 .where = slice.name,
                 .found = found,
                 .expected = "grey pictures of one size",
                 .remedy = "remove it if it is not a slice, or export it again"};
  };
  if (first.fault[0] != 0) return slice_error(slices[0], first.fault);
  for (int page = 1; !is_folder && page < first.pages; ++page) {
    std::string name = where;
    slices.push_back({path, name.append(", page ").append(std::to_string(page + 1)), page});
  }
  const glm::ivec3 size(first.width, first.height, static_cast<int>(slices.size()));
  Result<volume::Volume> result = allocate_volume(size, frame, where);
  if (!result) return result.error();
  opened.volume = std::move(result).value();
  if (!is_small(first, slices.size())) {
    const std::size_t bytes = opened.volume.voxels.size() * sizeof(float);
    values = SharedBytes::make(bytes);
    faults = SharedBytes::make(slices.size() * sizeof(PictureFacts));
    if (!values || !faults) return too_large(bytes, where);
    if (Status failure = with_library(
            LoadedFormat::pictures, static_cast<int>(slices.size()), where,
            [&](const void* library, int i) {
              const auto n = static_cast<std::size_t>(i);
              read_slice(*static_cast<const PictureLibrary*>(library), slices[n].path, slices[n].page, n,
                         first);
            },
            share_of(0.1, 0.9), name_of))
      return *failure;
  }
  const auto* const numbers = reinterpret_cast<const float*>(values->data());
  const auto* const slice_facts = reinterpret_cast<const PictureFacts*>(faults->data());
  const auto size_of = [](const PictureFacts& facts) {
    return std::to_string(facts.width) + " x " + std::to_string(facts.height);
  };
  for (std::size_t i = 0; i < slices.size(); ++i) {
    if (size_of(slice_facts[i]) != size_of(first))
      return slice_error(slices[i], size_of(slice_facts[i]) + " pixels; the first has " + size_of(first));
    if (is_folder && slice_facts[i].pages > 1) return slice_error(slices[i], "several pages");
    if (slice_facts[i].fault[0] != 0) return slice_error(slices[i], slice_facts[i].fault);
  }
  const std::size_t notice_count = opened.notices.size();
  if (Status failure =
          fill_voxels(opened.volume, values_of<float>(numbers, 1, contents ? contents->offset : 0),
                      options.scale, where, opened.notices))
    return *failure;
  opened.is_rounded = opened.notices.size() > notice_count;
  detect_units(opened, contents && contents->is_hounsfield);
  return opened;
}

Status write_picture_stack(const std::string& path, bool is_png, const volume::Volume& volume,
                           const Progress& progress) {
  if (Status error = check_slices(volume.size.z, path)) return error;
  const char* extension = is_png ? ".png" : ".tif";
  json contents = {{"schema", std::string(k_kind) + "/1"},
                   {"slices", volume.size.z},
                   {"offset", is_png ? -k_png_offset : 0},
                   {"hounsfield", volume.is_hounsfield},
                   {"world", "LPS, mm"}};
  for (int a = 0; a < 3; ++a) {
    contents["origin"].push_back(volume.frame.origin()[a]);
    const glm::dvec3& axis = volume.frame.axes()[a];
    contents["axes"].push_back({axis.x, axis.y, axis.z});
  }
  const auto write = [&](const std::string& folder) -> Status {
    const auto failure_flag = SharedBytes::make(1);
    if (!failure_flag) return too_large(1, file_name(path));
    const std::size_t area =
        static_cast<std::size_t>(volume.size.x) * static_cast<std::size_t>(volume.size.y);
    if (Status error = with_library(
            LoadedFormat::pictures, volume.size.z, file_name(path),
            [&](const void* library, int z) {
              const auto at = static_cast<std::size_t>(z);
              if (!static_cast<const PictureLibrary*>(library)->write(
                      (fs::path(folder) / slice_name(z, extension)).c_str(), volume.size.x, volume.size.y,
                      true, volume.voxels.data() + at * area))
                *failure_flag->data() = 1;
            },
            progress))
      return error;
    if (*failure_flag->data() != 0) return cannot_write(path, ENOSPC);
    return write_file_atomically((fs::path(folder) / k_stack_file).string(), contents.dump(2) + "\n");
  };
  return write_folder_atomically(path, {std::string("slice-####") + extension, k_stack_file}, write,
                                 volume.size.z);
}

}  // namespace trephine::data_tools
