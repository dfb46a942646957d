// Fuzzes the formats of volume files that are read in this process with any bytes: the parsers of this
// project, and the libraries that they call. Files of segmentations (.seg.nrrd, .dcm) are read as labels.
#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <unistd.h>

#include "data-tools/cases/label_file.h"
#include "data-tools/formats/open_volume.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace trephine;
  if (size < 2) return 0;
  static const std::array<const char*, 16> k_extensions{
      ".nii", ".mha",      ".nrrd", ".mhd",  ".nii.gz", ".vti", ".hdr", ".inv3",
      ".raw", ".seg.nrrd", ".dcm",  ".nhdr", ".img",    ".nii", ".mha", ".nrrd"};
  static const std::string k_stem =
      (std::filesystem::temp_directory_path() / "trephine-fuzz-volume-").string() + std::to_string(getpid());
  static const volume::Volume k_scan = volume::make_volume({6, 5, 4}, volume::Frame()).value();
  const std::string extension = k_extensions[data[0] & 15], path = k_stem + extension;
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(data) + 1, static_cast<std::streamsize>(size - 1));
  data_tools::OpenOptions options;
  if (data[0] & 16) options.spacing = glm::dvec3(1, 2, 3);
  if (extension == ".raw") options.raw = data[0] & 32 ? "3,2,2,double,big" : "4,3,2,int16,skip=3";
  if (extension == ".dcm" || extension == ".seg.nrrd")
    (void)data_tools::read_labels(path, k_scan, options);
  else
    (void)data_tools::open_volume(path, options);
  return 0;
}
