// Fuzzes plans with any bytes: markups of 3D Slicer, or tables.
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <unistd.h>

#include "data-tools/cases/plan_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace trephine;
  if (size < 2) return 0;
  static const std::string k_stem =
      (std::filesystem::temp_directory_path() / "trephine-fuzz-plan-").string() + std::to_string(getpid());
  const std::string path = k_stem + (data[0] & 1 ? ".mrk.json" : ".csv");
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(data) + 1, static_cast<std::streamsize>(size - 1));
  (void)data_tools::read_plan(path);
  return 0;
}
