#include "data-tools/picture_stack.h"

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <new>
#include <nlohmann/json.hpp>
#include <sstream>

#include "data-tools/apart.h"
#include "data-tools/atomic_file.h"
#include "data-tools/loaded_formats.h"
#include "data-tools/opening.h"
#include "data-tools/voxel_values.h"
#include "data-tools/words.h"
#include "data-tools/writing.h"

namespace trephine::data_tools {

namespace fs = std::filesystem;
using nlohmann::json;
using volume::Error;
using volume::Result;
using volume::Status;

namespace {

constexpr const char* k_place_file = "stack.json";
constexpr const char* k_kind = "trephine.stack";
constexpr std::size_t k_most_pictures = 20'000;
constexpr std::size_t k_ready_values = 16 << 20, k_ready_pages = 4096;  // of which only what is used is there

bool is_picture(const std::string& name) {
  for (const char* end : {".png", ".tif", ".tiff", ".jpg", ".jpeg", ".bmp", ".pgm", ".jp2"})
    if (has_extension(name, end)) return true;
  return false;
}

/// By the numbers in them: slice2 before slice10.
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

/// Its pictures in order; empty when something else lies there, too.
std::vector<std::string> pictures_of(const std::string& folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    if (name.front() != '.' && is_picture(name) && entry.is_regular_file(error))
      names.push_back(name);
    else if (name.front() != '.' && name != "Thumbs.db" && !has_extension(name, ".json") &&
             !has_extension(name, ".txt"))
      return {};
    if (names.size() > k_most_pictures) return {};
  }
  std::sort(names.begin(), names.end(), comes_before);
  return names;
}

/// The numbers in a name, and the rest of it.
struct NumberedName {
  std::vector<long long> numbers;
  std::string rest;

  explicit NumberedName(const std::string& name) {
    for (std::size_t i = 0; i < name.size();) {
      if (name[i] < '0' || name[i] > '9') {
        rest += name[i++];
        continue;
      }
      long long number = 0;
      for (; i < name.size() && name[i] >= '0' && name[i] <= '9'; ++i)
        number = std::min(number, 100'000'000'000'000LL) * 10 + (name[i] - '0');
      numbers.push_back(number);
      rest += '#';
    }
  }
};

/// Slices of one stack have names that count: none is missing, none is there twice.
Status check_counting(const std::vector<std::string>& names, const std::string& where) {
  std::vector<NumberedName> all(names.begin(), names.end());
  const auto refused = [&](const std::string& what, const std::string& found) {
    return Error{what, where, found, "names that count: slice1, slice2, ...",
                 "take away what does not belong there, or copy what is missing; names that end in .json or "
                 ".txt are passed over"};
  };
  std::optional<std::size_t> counter;
  for (const NumberedName& name : all) {
    if (name.rest != all[0].rest || name.numbers.size() != all[0].numbers.size())
      return refused("the pictures have names of two kinds: are they of one stack?",
                     names[0] + " and " + names[static_cast<std::size_t>(&name - all.data())]);
    for (std::size_t k = 0; k < name.numbers.size(); ++k)
      if (name.numbers[k] != all[0].numbers[k]) {
        if (counter && *counter != k)
          return std::nullopt;  // dates among counters: their order is all we know
        counter = k;
      }
  }
  for (std::size_t i = 1; i < all.size(); ++i) {
    const long long step = counter ? all[i].numbers[*counter] - all[i - 1].numbers[*counter] : 0;
    if (step == 0) return refused("two pictures have one number", names[i - 1] + " and " + names[i]);
    if (step != all[1].numbers[*counter] - all[0].numbers[*counter])
      return refused("pictures are missing", "none between " + names[i - 1] + " and " + names[i]);
  }
  return std::nullopt;
}

/// Contents of stack.json.
struct Place {
  glm::dvec3 origin{0.0};
  glm::dmat3 axes{1.0};
  double offset = 0;
  bool is_hounsfield = false;
  std::size_t slices = 0;
};

Result<std::optional<Place>> read_place(const std::string& folder) {
  std::ifstream file(fs::path(folder) / k_place_file, std::ios::binary);
  if (!file) return std::optional<Place>();
  std::ostringstream text;
  text << file.rdbuf();
  const json read = json::parse(text.str(), nullptr, false);
  const Error bad{"the file next to the pictures cannot be read", k_place_file, "",
                  "schema, origin, axes, offset and slices, as trephine writes them",
                  "take it away and say --spacing instead"};
  if (!read.is_object() || read.value("schema", json()) != std::string(k_kind) + "/1") return bad;
  Place place;
  try {
    for (std::size_t a = 0; a < 3; ++a) {
      place.origin[static_cast<int>(a)] = read.at("origin").at(a).get<double>();
      for (std::size_t row = 0; row < 3; ++row)
        place.axes[static_cast<int>(a)][static_cast<int>(row)] = read.at("axes").at(a).at(row).get<double>();
    }
    place.offset = read.at("offset").get<double>();
    place.is_hounsfield = read.at("hounsfield").get<bool>();
    place.slices = read.at("slices").get<std::size_t>();
  } catch (const json::exception&) {
    return bad;
  }
  return std::optional(place);
}

struct Slice {
  std::string path, name;
  int page = 0;
};

}  // namespace

bool is_picture_stack(const std::string& path) {
  std::error_code error;
  if (fs::is_directory(path, error)) {
    const std::size_t count = pictures_of(path).size();
    return count > 1 || (count == 1 && fs::exists(fs::path(path) / k_place_file, error));
  }
  return has_extension(path, ".tif") || has_extension(path, ".tiff");
}

Result<OpenedVolume> open_picture_stack(const std::string& path, const OpenOptions& options) {
  const std::string where = file_name(path);
  std::error_code error;
  const bool is_folder = fs::is_directory(path, error);
  OpenedVolume opened;
  opened.format = "a stack of pictures";
  std::optional<Place> place;
  std::vector<Slice> slices;
  if (is_folder) {
    Result<std::optional<Place>> said = read_place(path);
    if (!said) return said.error();
    place = said.value();
    const std::vector<std::string> names = pictures_of(path);
    if (Status odd = check_counting(names, where); odd && !place) return *odd;
    for (const std::string& name : names)
      slices.push_back({(fs::path(path) / name).string(), where + "/" + name, 0});
    if (place && place->slices != slices.size())
      return Error{"pictures are missing or too many", where, counted(slices.size(), "picture"),
                   std::to_string(place->slices) + ", says " + k_place_file, "copy all of them"};
  } else {
    slices.push_back({path, where, 0});
  }
  const Result<volume::Frame> frame =
      place ? volume::Frame::from_axes(place->origin, place->axes) : given_frame(opened, options, where);
  if (!frame) return frame.error();

  // Sizes first, the memory then. What is small is read at once into memory that lies ready: the library
  // takes longer to load than a few pictures to read.
  const auto shared = SharedBytes::make(sizeof(PictureFacts));
  auto values = SharedBytes::make(k_ready_values * sizeof(float));
  auto faults = SharedBytes::make(std::max(k_ready_pages, slices.size()) * sizeof(PictureFacts));
  if (!shared || !values || !faults) return too_large(k_ready_values * sizeof(float), where);
  const PictureFacts& first = *new (shared->data()) PictureFacts;
  const auto read_slice = [&](const PictureLibrary& library, const std::string& file, int page, std::size_t i,
                              const PictureFacts& like) {
    auto* const read = new (faults->data() + i * sizeof(PictureFacts)) PictureFacts(like);
    const std::size_t area = static_cast<std::size_t>(like.width) * static_cast<std::size_t>(like.height);
    library.read(file.c_str(), page, *read, reinterpret_cast<float*>(values->data()) + i * area);
  };
  const auto is_small = [](const PictureFacts& of, std::size_t count) {
    return of.fault[0] == 0 && of.width > 0 && of.height > 0 && count <= k_ready_pages &&
           count * static_cast<std::size_t>(of.width) * static_cast<std::size_t>(of.height) <= k_ready_values;
  };
  const auto name_of = [&slices](int work) { return slices[static_cast<std::size_t>(work)].name; };
  const auto share_of = [&options](double from, double length) {
    return [&options, from, length](double share) {
      return !options.progress || options.progress(from + length * share);
    };
  };
  PictureFacts known;  // in each of the processes
  if (Status failed = with_library(
          LoadedFormat::pictures, static_cast<int>(std::min(slices.size(), k_ready_pages)), where,
          [&](const void* loaded, int i) {
            const auto& library = *static_cast<const PictureLibrary*>(loaded);
            if (known.width == 0) library.describe(slices[0].path.c_str(), known);
            if (i == 0) new (shared->data()) PictureFacts(known);
            const auto pages = static_cast<std::size_t>(std::max(known.pages, 1));
            if (!is_small(known, is_folder ? slices.size() : pages)) return;
            const auto n = static_cast<std::size_t>(i);
            for (std::size_t page = 0; page < (is_folder ? 1 : pages); ++page)
              read_slice(library, slices[n].path, static_cast<int>(page), n + page, known);
          },
          share_of(0, 0.1), name_of))
    return *failed;
  const auto refused = [](const Slice& slice, const std::string& found) {
    return Error{"a slice cannot be used", slice.name, found, "grey pictures of one size",
                 "remove it if it is not a slice, or export it again"};
  };
  if (first.fault[0] != 0) return refused(slices[0], first.fault);
  for (int page = 1; !is_folder && page < first.pages; ++page) {
    std::string name = where;
    slices.push_back({path, name.append(", page ").append(std::to_string(page + 1)), page});
  }
  const glm::ivec3 size(first.width, first.height, static_cast<int>(slices.size()));
  Result<volume::Volume> made = make_room(size, frame, where);
  if (!made) return made.error();
  opened.volume = std::move(made).value();
  if (!is_small(first, slices.size())) {
    const std::size_t bytes = opened.volume.voxels.size() * sizeof(float);
    values = SharedBytes::make(bytes);
    faults = SharedBytes::make(slices.size() * sizeof(PictureFacts));
    if (!values || !faults) return too_large(bytes, where);
    if (Status failed = with_library(
            LoadedFormat::pictures, static_cast<int>(slices.size()), where,
            [&](const void* library, int i) {
              const auto n = static_cast<std::size_t>(i);
              read_slice(*static_cast<const PictureLibrary*>(library), slices[n].path, slices[n].page, n,
                         first);
            },
            share_of(0.1, 0.9), name_of))
      return *failed;
  }
  const auto* const numbers = reinterpret_cast<const float*>(values->data());
  const auto* const reads = reinterpret_cast<const PictureFacts*>(faults->data());
  const auto size_of = [](const PictureFacts& facts) {
    return std::to_string(facts.width) + " x " + std::to_string(facts.height);
  };
  for (std::size_t i = 0; i < slices.size(); ++i) {
    if (size_of(reads[i]) != size_of(first))
      return refused(slices[i], size_of(reads[i]) + " pixels, where the first has " + size_of(first));
    if (is_folder && reads[i].pages > 1) return refused(slices[i], "several pages");
    if (reads[i].fault[0] != 0) return refused(slices[i], reads[i].fault);
  }
  const std::size_t told = opened.notices.size();
  if (Status failed = fill_voxels(opened.volume, values_of<float>(numbers, 1, place ? place->offset : 0),
                                  options.scale, where, opened.notices))
    return *failed;
  opened.is_rounded = opened.notices.size() > told;
  know_units(opened, place && place->is_hounsfield);
  return opened;
}

Status write_picture_stack(const std::string& path, bool is_png, const volume::Volume& volume,
                           const Progress& progress) {
  if (Status error = check_slices(volume.size.z, path)) return error;
  const char* extension = is_png ? ".png" : ".tif";
  json place = {{"schema", std::string(k_kind) + "/1"},
                {"slices", volume.size.z},
                {"offset", is_png ? -k_png_offset : 0},
                {"hounsfield", volume.is_hounsfield},
                {"world", "LPS, mm"}};
  for (int a = 0; a < 3; ++a) {
    place["origin"].push_back(volume.frame.origin()[a]);
    const glm::dvec3& axis = volume.frame.axes()[a];
    place["axes"].push_back({axis.x, axis.y, axis.z});
  }
  const auto write = [&](const std::string& folder) -> Status {
    const auto failed = SharedBytes::make(1);
    if (!failed) return too_large(1, file_name(path));
    const std::size_t area =
        static_cast<std::size_t>(volume.size.x) * static_cast<std::size_t>(volume.size.y);
    if (Status error = with_library(
            LoadedFormat::pictures, volume.size.z, file_name(path),
            [&](const void* library, int z) {
              const auto at = static_cast<std::size_t>(z);
              if (!static_cast<const PictureLibrary*>(library)->write(
                      (fs::path(folder) / slice_name(z, extension)).c_str(), volume.size.x, volume.size.y,
                      true, volume.voxels.data() + at * area))
                *failed->data() = 1;
            },
            progress))
      return error;
    if (*failed->data() != 0) return cannot_write(path, ENOSPC);
    return write_file_atomically((fs::path(folder) / k_place_file).string(), place.dump(2) + "\n");
  };
  return write_folder_atomically(path, {std::string("slice-####") + extension, k_place_file}, write,
                                 volume.size.z);
}

}  // namespace trephine::data_tools
