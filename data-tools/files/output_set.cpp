#include "data-tools/files/output_set.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "data-tools/files/atomic_file.h"
#include "data-tools/files/words.h"

namespace trephine::data_tools {

namespace fs = std::filesystem;

namespace {

struct KindInfo {
  const char* noun;
  std::vector<const char*> extensions;
};
const KindInfo& kind_info(OutputKind kind) {
  static const std::array<KindInfo, 8> k_kinds{{
      {"file", {}},
      {"volume", {".mha", ".nrrd", ".nii", ".nii.gz", ".vti", ".vdb"}},
      {"mesh", {".stl", ".ply", ".obj", ".vtp", ".glb"}},
      {"picture", {".png"}},
      {"chart", {".png", ".svg", ".csv"}},
      {"table", {".csv"}},
      {"data", {".h5", ".hdf5"}},
      {"folder", {}},
  }};
  return k_kinds[static_cast<std::size_t>(kind)];
}

/// Data files that a MetaImage or NRRD header names. A pattern such as "slice%03d.raw" stands for all files
/// that match it.
class HeaderDataFiles {
 public:
  explicit HeaderDataFiles(const fs::path& header) : folder_(header.parent_path()) {
    std::ifstream file(header, std::ios::binary);
    bool is_list = false;
    for (std::string line; std::getline(file, line) && names_.size() < 100'000;) {
      while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.pop_back();
      if (is_list) {
        names_.push_back(line);
        continue;
      }
      for (const char* key : {"ElementDataFile", "data file", "datafile"}) {
        const std::optional<std::string> value = header_value(line, key);
        if (!value) continue;
        is_list = value->compare(0, 4, "LIST") == 0;
        if (!is_list) names_.push_back(*value);
      }
    }
  }
  bool contains(const fs::path& canonical_file) const {
    return std::any_of(names_.begin(), names_.end(), [&](const std::string& name) {
      const std::size_t percent = name.find('%');
      std::error_code ignored;
      if (percent == std::string::npos)
        return fs::weakly_canonical(folder_ / name, ignored) == canonical_file;
      // Only the part of a pattern before its number is compared.
      const std::string prefix = fs::weakly_canonical(folder_ / name.substr(0, percent), ignored).string();
      return canonical_file.string().compare(0, prefix.size(), prefix) == 0;
    });
  }

 private:
  fs::path folder_;
  std::vector<std::string> names_;
};

/// Returns true if `output` is `other`, a file in the folder `other`, or a data file of the header `other`.
bool belongs_to(const fs::path& output, const fs::path& other) {
  std::error_code ignored;
  if (output.lexically_normal() == other.lexically_normal() || fs::equivalent(output, other, ignored))
    return true;
  if (!fs::exists(output, ignored)) return false;
  const fs::path output_path = fs::weakly_canonical(output, ignored),
                 other_path = fs::weakly_canonical(other, ignored);
  if (fs::is_directory(other_path, ignored)) {
    const fs::path inside = output_path.lexically_relative(other_path);
    return !inside.empty() && *inside.begin() != "..";
  }
  const auto ends_with = [](const fs::path& file, const char* extension) {
    return has_extension(file.string(), extension);
  };
  if (ends_with(other_path, ".hdr") || ends_with(other_path, ".img"))
    return output_path.parent_path() == other_path.parent_path() && output_path.stem() == other_path.stem() &&
           (ends_with(output_path, ".hdr") || ends_with(output_path, ".img"));
  return (ends_with(other_path, ".mhd") || ends_with(other_path, ".nhdr")) &&
         HeaderDataFiles(other_path).contains(output_path);
}

/// Returns true if both paths refer to one file, which need not exist.
bool is_same_file(const std::string& a, const std::string& b) {
  std::error_code ignored;
  return fs::weakly_canonical(a, ignored) == fs::weakly_canonical(b, ignored) ||
         fs::equivalent(a, b, ignored);
}

}  // namespace

std::string extensions_of(OutputKind kind) {
  const auto& extensions = kind_info(kind).extensions;
  std::string text;
  for (std::size_t i = 0; i < extensions.size(); ++i)
    text += (i == 0 ? "" : i + 1 < extensions.size() ? ", " : " or ") + std::string(extensions[i]);
  return text;
}

bool is_output_of(OutputKind kind, const std::string& path) {
  const auto& extensions = kind_info(kind).extensions;
  return extensions.empty() || std::any_of(extensions.begin(), extensions.end(),
                                           [&](const char* end) { return has_extension(path, end); });
}

Status check_extension(OutputKind kind, const std::string& path) {
  if (is_output_of(kind, path)) return std::nullopt;
  return Error{.what = std::string("unsupported ") + kind_info(kind).noun + " format",
               .where = file_name(path),
               .found = fs::path(path).extension().string(),
               .expected = extensions_of(kind),
               .remedy = kind_info(kind).extensions.size() > 1 ? "choose one of these extensions"
                                                               : "choose this extension"};
}

void OutputSet::add_input(const std::string& path) {
  if (!path.empty()) inputs_.push_back(path);
}

void OutputSet::add_output(std::string name, const std::string& path, OutputKind kind) {
  if (!path.empty()) outputs_.push_back({std::move(name), path, kind});
}

Status OutputSet::check() const {
  for (std::size_t i = 0; i < outputs_.size(); ++i) {
    const std::string& path = outputs_[i].path;
    for (const std::string& input : inputs_)
      if (belongs_to(path, input))
        return Error{.what =
                         "the output would replace an input file, a file in an input folder, or the voxels "
                         "of an input header",
                     .where = file_name(path),
                     .expected = "a different name",
                     .remedy = "choose another name for it"};
    if (Status error = check_extension(outputs_[i].kind, path)) return error;
    if (outputs_[i].kind == OutputKind::folder) {
      if (Status error = check_new_folder(path)) return error;
    } else if (Status error = check_writable(path)) {
      return error;
    }
    for (std::size_t k = 0; k < i; ++k)
      if (is_same_file(path, outputs_[k].path))
        return Error{.what = "two outputs have the same file name",
                     .where = file_name(path),
                     .found = outputs_[k].name + " and " + outputs_[i].name,
                     .expected = "a different name for each",
                     .remedy = "choose another name for one of them"};
  }
  return std::nullopt;
}

void OutputSet::write(const std::string& path, const std::function<Status()>& write) {
  if (path.empty()) return;
  const auto output = std::find_if(outputs_.begin(), outputs_.end(),
                                   [&](const Output& candidate) { return candidate.path == path; });
  TREPHINE_ASSERT(output != outputs_.end());
  if (Status error = write())
    failures_.push_back(std::move(*error));
  else
    written_.push_back(output->name), written_paths_.push_back(path);
}

void OutputSet::add_recording_status(const Status& status) {
  if (status) failures_.push_back(*status);
}

Status OutputSet::result() const {
  if (failures_.empty()) return std::nullopt;
  Error error = failures_.front();
  for (std::size_t i = 1; i < failures_.size(); ++i) error.where += ", " + failures_[i].where;
  for (std::size_t i = 0; i < written_.size(); ++i)
    error.remedy +=
        (i == 0 ? (error.remedy.empty() ? "" : "; ") + std::string("written nevertheless: ") : ", ") +
        written_[i];
  return error;
}

}  // namespace trephine::data_tools
