#include "apps/trephine/outputs.h"

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "data-tools/atomic_file.h"
#include "data-tools/open_volume.h"

namespace trephine::app {

using volume::Error;

namespace {
namespace fs = std::filesystem;

/// Where those files are that a MetaImage or NRRD header names; a pattern stands for all that match it.
class FilesOfHeader {
 public:
  explicit FilesOfHeader(const fs::path& header) : folder_(header.parent_path()) {
    std::ifstream file(header, std::ios::binary);
    bool is_list = false;
    for (std::string line; std::getline(file, line) && names_.size() < 100'000;) {
      while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.pop_back();
      if (is_list) {
        names_.push_back(line);
        continue;
      }
      for (const char* key : {"ElementDataFile", "data file", "datafile"}) {
        const std::size_t colon = line.find_first_of("=:");
        if (colon == std::string::npos || line.compare(0, std::strlen(key), key) != 0) continue;
        const std::size_t start = line.find_first_not_of(" =:", colon);
        const std::string value = start == std::string::npos ? "" : line.substr(start);
        is_list = value.compare(0, 4, "LIST") == 0;
        if (!is_list) names_.push_back(value);
      }
    }
  }
  bool hold(const fs::path& canonical_file) const {
    return std::any_of(names_.begin(), names_.end(), [&](const std::string& name) {
      const std::size_t percent = name.find('%');
      std::error_code ignored;
      if (percent == std::string::npos)
        return fs::weakly_canonical(folder_ / name, ignored) == canonical_file;
      // What the pattern begins with, and numbers behind it.
      const std::string begin = fs::weakly_canonical(folder_ / name.substr(0, percent), ignored).string();
      return canonical_file.string().compare(0, begin.size(), begin) == 0;
    });
  }

 private:
  fs::path folder_;
  std::vector<std::string> names_;
};

/// Is `output` what `other` names, a file of the folder that it names, or one of those with the voxels of a
/// header that it names?
bool belongs_to(const fs::path& output, const fs::path& other) {
  std::error_code ignored;
  if (output.lexically_normal() == other.lexically_normal() || fs::equivalent(output, other, ignored))
    return true;
  if (!fs::exists(output, ignored)) return false;
  const fs::path here = fs::weakly_canonical(output, ignored), there = fs::weakly_canonical(other, ignored);
  if (fs::is_directory(there, ignored)) {
    const fs::path inside = here.lexically_relative(there);
    return !inside.empty() && *inside.begin() != "..";
  }
  const auto is = [](const fs::path& file, const char* extension) {
    return data_tools::has_extension(file.string(), extension);
  };
  if (is(there, ".hdr") || is(there, ".img"))
    return here.parent_path() == there.parent_path() && here.stem() == there.stem() &&
           (is(here, ".hdr") || is(here, ".img"));
  return (is(there, ".mhd") || is(there, ".nhdr")) && FilesOfHeader(there).hold(here);
}
}  // namespace

volume::Status check_apart(const std::string& output, const std::vector<std::string>& others) {
  for (const std::string& other : others) {
    if (other.empty() || output.empty() || !belongs_to(output, other)) continue;
    return Error{
        "the output would replace what was given: that file, one of its folder, or the voxels of its header",
        data_tools::file_name(output), "", "a name of its own", "choose another name for it"};
  }
  return std::nullopt;
}

volume::Status check_output(const std::string& output, const std::vector<std::string>& others) {
  if (output.empty()) return std::nullopt;
  if (volume::Status error = data_tools::check_writable(output)) return error;
  return check_apart(output, others);
}

volume::Status check_volume_output(const std::string& output, const std::vector<std::string>& others) {
  if (output.empty() || data_tools::is_writable_volume_file(output)) return check_output(output, others);
  return Error{"this is no volume format that trephine writes", data_tools::file_name(output), "",
               ".mha, .nrrd, .nii or .nii.gz", "choose one of these extensions"};
}

volume::Status check_picture_output(const std::string& output, const std::vector<std::string>& others) {
  if (output.empty() || data_tools::has_extension(output, ".png")) return check_output(output, others);
  return Error{"this is no picture format that trephine writes", data_tools::file_name(output), "", ".png",
               "choose this extension"};
}

}  // namespace trephine::app
