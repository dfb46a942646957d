// Helpers for text files, and the folder of real data.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

namespace trephine::data_tools {

inline void write_text(const std::string& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}
inline std::string read_text(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Returns the folder of real data, or "" if it is missing. Tests that need the data are then skipped.
inline std::string real_data() {
  if (const char* given = std::getenv("TREPHINE_DATA")) return given;
  const std::filesystem::path folder = std::filesystem::path(TREPHINE_SOURCE_DIR) / ".." / "shared" / "data";
  return std::filesystem::exists(folder / "GOLDEN.json") ? folder.string() : "";
}

}  // namespace trephine::data_tools
