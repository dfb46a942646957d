#include "apps/workbench/phantom_cache.h"

#include <array>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <dlfcn.h>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <optional>
#include <unistd.h>

#include "apps/workbench/text.h"
#include "data-tools/phantoms/phantoms.h"
#include "volume/base/mix_hash.h"

namespace trephine::workbench {

namespace {

namespace fs = std::filesystem;
using volume::Volume;

/// Header of a file; voxels and labels follow.
struct Head {
  std::array<char, 8> magic{'T', 'R', 'E', 'P', 'H', 'P', 'H', 'A'};
  std::uint64_t key = 0;           ///< hash of the libraries that made the phantom
  std::uint64_t content_hash = 0;  ///< of the volume
  std::array<std::int32_t, 3> size{};
  std::int32_t label_names = 0;    ///< number of bytes of the names, which follow the header, one per line
  std::array<double, 12> frame{};  ///< origin, then the axes
};

/// Adds the contents of the library, or of the program, that contains a function.
bool add_library(const void* function, MixHash& hash) {
  Dl_info info{};
  if (dladdr(function, &info) == 0 || info.dli_fname == nullptr) return false;
  std::ifstream in(info.dli_fname, std::ios::binary);
  std::array<std::uint64_t, 4096> block{};
  while (in) {
    block.fill(0);
    in.read(reinterpret_cast<char*>(block.data()), sizeof block);
    const auto bytes = static_cast<std::size_t>(in.gcount());
    for (std::size_t i = 0; 8 * i < bytes; ++i) hash.add(block[i]);
  }
  return in.eof();
}

/// Returns the folder of the cache; empty without one.
fs::path cache_folder() {
  if (const char* setting = std::getenv("TREPHINE_CACHE"); setting && std::string_view(setting) == "off")
    return {};
  const char* const cache = std::getenv("XDG_CACHE_HOME");
  if (cache && *cache == '/') return fs::path(cache) / "trephine";
  const char* const home = std::getenv("HOME");
  return home && *home == '/' ? fs::path(home) / ".cache/trephine" : fs::path();
}

using File = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;

bool read(std::FILE* file, void* data, std::size_t bytes) {
  return std::fread(data, 1, bytes, file) == bytes;
}
bool write(std::FILE* file, const void* data, std::size_t bytes) {
  return std::fwrite(data, 1, bytes, file) == bytes;
}

std::optional<Volume> read_phantom(const fs::path& path, std::uint64_t key) {
  const File file(std::fopen(path.c_str(), "rbe"), &std::fclose);
  Head head;
  const Head expected;
  if (!file || !read(file.get(), &head, sizeof head) || head.magic != expected.magic || head.key != key)
    return {};
  constexpr std::int32_t k_longest = 1 << 16;  // bytes of names
  if (head.label_names < 0 || head.label_names > k_longest) return {};
  glm::dmat3 axes(0.0);
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b) axes[a][b] = head.frame[static_cast<std::size_t>(3 + 3 * a + b)];
  const auto frame = volume::Frame::from_axes({head.frame[0], head.frame[1], head.frame[2]}, axes);
  if (!frame) return {};
  auto made = volume::make_volume({head.size[0], head.size[1], head.size[2]}, frame.value(), true);
  if (!made) return {};
  Volume result = std::move(made).value();
  result.is_hounsfield = true;
  std::string names(static_cast<std::size_t>(head.label_names), '\0');
  if (!read(file.get(), names.data(), names.size()) ||
      !read(file.get(), result.voxels.data(), result.voxels.bytes()) ||
      !read(file.get(), result.labels.data(), result.labels.bytes()))
    return {};
  for (std::size_t at = 0; at < names.size();) {
    const std::size_t end = std::min(names.find('\n', at), names.size());
    result.label_names.push_back(names.substr(at, end - at));
    at = end + 1;
  }
  if (volume::content_hash(result) != head.content_hash) return {};
  return result;
}

/// Writes a file under a temporary name, then renames it: other programs see it whole or not at all.
void write_phantom(const fs::path& path, std::uint64_t key, const Volume& phantom) {
  std::error_code error;
  fs::create_directories(path.parent_path(), error);
  const fs::path temporary = path.string() + format_text(".%d", static_cast<int>(::getpid()));
  std::string names;
  for (const std::string& name : phantom.label_names) names += name + '\n';
  Head head;
  head.key = key, head.content_hash = volume::content_hash(phantom);
  head.label_names = static_cast<std::int32_t>(names.size());
  for (int a = 0; a < 3; ++a) {
    head.size[static_cast<std::size_t>(a)] = phantom.size[a];
    head.frame[static_cast<std::size_t>(a)] = phantom.frame.origin()[a];
    for (int b = 0; b < 3; ++b)
      head.frame[static_cast<std::size_t>(3 + 3 * a + b)] = phantom.frame.axes()[a][b];
  }
  File file(std::fopen(temporary.c_str(), "wbxe"), &std::fclose);
  if (!file) return;
  bool is_written = write(file.get(), &head, sizeof head) && write(file.get(), names.data(), names.size()) &&
                    write(file.get(), phantom.voxels.data(), phantom.voxels.bytes()) &&
                    write(file.get(), phantom.labels.data(), phantom.labels.bytes());
  is_written = std::fclose(file.release()) == 0 && is_written;
  if (is_written) fs::rename(temporary, path, error);
  if (!is_written || error) fs::remove(temporary, error);
}

}  // namespace

Result<Volume> builtin_phantom(const std::string& name) {
  const fs::path folder = cache_folder();
  MixHash hash;
  const bool is_known = !folder.empty() &&
                        add_library(reinterpret_cast<const void*>(&data_tools::make_phantom), hash) &&
                        add_library(reinterpret_cast<const void*>(&volume::make_volume), hash);
  if (!is_known) return data_tools::make_phantom(name);
  const fs::path path = folder / (name + ".phantom");
  if (auto kept = read_phantom(path, hash.value())) return std::move(*kept);
  auto made = data_tools::make_phantom(name);
  if (made) write_phantom(path, hash.value(), made.value());
  return made;
}

}  // namespace trephine::workbench
