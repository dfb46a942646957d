// Fuzzes a DICOM file, an archive or a folder of two files with any bytes: our reader of headers, the volume
// builder, and GDCM and libarchive behind them.
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <unistd.h>

#include "data-tools/formats/open_volume.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace trephine;
  namespace fs = std::filesystem;
  if (size < 3) return 0;
  static const fs::path k_folder =
      fs::temp_directory_path() / ("trephine-fuzz-dicom-" + std::to_string(getpid()));
  fs::create_directories(k_folder);
  const std::size_t cut =
      data[0] % 4 == 0 ? size * data[1] / 256 : size;  // two files in a quarter of all runs
  const auto put = [](const char* name, const std::uint8_t* from, std::size_t count) {
    std::ofstream(k_folder / name, std::ios::binary)
        .write(reinterpret_cast<const char*>(from), static_cast<std::streamsize>(count));
  };
  put("a.dcm", data + 2, std::max<std::size_t>(cut, 2) - 2);
  std::error_code ignored;
  fs::remove(k_folder / "b.dcm", ignored);
  if (cut < size) put("b.dcm", data + cut, size - cut);
  data_tools::OpenOptions options;
  options.is_resampled = data[0] & 8;
  options.maps_padding = data[0] & 16;
  if (data[0] & 32) options.scale = 3;
  (void)data_tools::open_volume((data[0] & 64 ? k_folder / "a.dcm" : k_folder).string(), options);
  return 0;
}
