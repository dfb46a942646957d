// Scratch: a temporary folder, deleted with its owner.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <string>

namespace trephine::scenes {

struct Scratch {
  std::filesystem::path path;  ///< empty if no folder could be created

  Scratch() {
    std::string name = (std::filesystem::temp_directory_path() / "trephine-XXXXXX").string();
    if (const char* made = ::mkdtemp(name.data())) path = made;
  }
  ~Scratch() {
    std::error_code ignored;
    if (!path.empty()) std::filesystem::remove_all(path, ignored);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  std::string operator/(const std::string& name) const { return (path / name).string(); }
};

}  // namespace trephine::scenes
