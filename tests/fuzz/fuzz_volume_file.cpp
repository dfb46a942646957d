// A NIfTI, MetaImage or NRRD file of any bytes: the headers that our own code reads before a library does.
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <unistd.h>

#include "data-tools/open_volume.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace trephine;
  if (size < 2) return 0;
  static const char* const k_extensions[] = {".nii", ".mha", ".nrrd", ".mhd"};
  static const std::string k_stem =
      (std::filesystem::temp_directory_path() / "trephine-fuzz-volume-").string() + std::to_string(getpid());
  const std::string path = k_stem + k_extensions[data[0] & 3];
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(data) + 1, static_cast<std::streamsize>(size - 1));
  (void)data_tools::open_volume(path);
  return 0;
}
