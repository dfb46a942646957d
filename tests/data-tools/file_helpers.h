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

/// The folder of real data, or "" (then the test is reported as skipped).
inline std::string real_data() {
  if (const char* given = std::getenv("TREPHINE_DATA")) return given;
  const std::filesystem::path beside = std::filesystem::path(TREPHINE_SOURCE_DIR) / ".." / "shared" / "data";
  return std::filesystem::exists(beside / "GOLDEN.json") ? beside.string() : "";
}

}  // namespace trephine::data_tools
