#include "data-tools/output_set.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "data-tools/atomic_file.h"

namespace trephine::data_tools {

namespace fs = std::filesystem;
using volume::Error;
using volume::Status;

namespace {

struct KindOfOutput {
  const char* what;
  std::vector<const char*> extensions;
};
const KindOfOutput& facts_of(OutputKind kind) {
  static const std::array<KindOfOutput, 6> k_kinds{{
      {"file", {}},
      {"volume", {".mha", ".nrrd", ".nii", ".nii.gz", ".vti", ".vdb"}},
      {"mesh", {".stl", ".ply", ".obj", ".vtp", ".glb"}},
      {"picture", {".png"}},
      {"table", {".csv"}},
      {"folder", {}},
  }};
  return k_kinds[static_cast<std::size_t>(kind)];
}

/// Data files that a MetaImage or NRRD header names; a pattern stands for all that match it.
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
      // Prefix of the pattern, and numbers behind it.
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
    return has_extension(file.string(), extension);
  };
  if (is(there, ".hdr") || is(there, ".img"))
    return here.parent_path() == there.parent_path() && here.stem() == there.stem() &&
           (is(here, ".hdr") || is(here, ".img"));
  return (is(there, ".mhd") || is(there, ".nhdr")) && FilesOfHeader(there).hold(here);
}

/// Two names of one file, be it there already or not.
bool is_same_file(const std::string& a, const std::string& b) {
  std::error_code ignored;
  return fs::weakly_canonical(a, ignored) == fs::weakly_canonical(b, ignored) ||
         fs::equivalent(a, b, ignored);
}

}  // namespace

std::string extensions_of(OutputKind kind) {
  const auto& all = facts_of(kind).extensions;
  std::string text;
  for (std::size_t i = 0; i < all.size(); ++i)
    text += (i == 0 ? "" : i + 1 < all.size() ? ", " : " or ") + std::string(all[i]);
  return text;
}

bool is_output_of(OutputKind kind, const std::string& path) {
  const auto& all = facts_of(kind).extensions;
  return all.empty() ||
         std::any_of(all.begin(), all.end(), [&](const char* end) { return has_extension(path, end); });
}

Status check_extension(OutputKind kind, const std::string& path) {
  if (is_output_of(kind, path)) return std::nullopt;
  return Error{
      std::string("this is no ") + facts_of(kind).what + " format that trephine writes", file_name(path),
      fs::path(path).extension().string(), extensions_of(kind),
      facts_of(kind).extensions.size() > 1 ? "choose one of these extensions" : "choose this extension"};
}

void OutputSet::reads(const std::string& path) {
  if (!path.empty()) inputs_.push_back(path);
}

void OutputSet::writes(std::string name, const std::string& path, OutputKind kind) {
  if (!path.empty()) outputs_.push_back({std::move(name), path, kind});
}

Status OutputSet::check() const {
  for (std::size_t i = 0; i < outputs_.size(); ++i) {
    const std::string& path = outputs_[i].path;
    for (const std::string& input : inputs_)
      if (belongs_to(path, input))
        return Error{
            "the output would replace what was given: that file, one of its folder, or the voxels of its "
            "header",
            file_name(path), "", "a name of its own", "choose another name for it"};
    if (Status error = check_extension(outputs_[i].kind, path)) return error;
    if (outputs_[i].kind == OutputKind::folder) {
      if (Status error = check_new_folder(path)) return error;
    } else if (Status error = check_writable(path)) {
      return error;
    }
    for (std::size_t k = 0; k < i; ++k)
      if (is_same_file(path, outputs_[k].path))
        return Error{"two outputs are one file", file_name(path),
                     outputs_[k].name + " and " + outputs_[i].name, "a name of its own for each",
                     "choose another name for one of them"};
  }
  return std::nullopt;
}

void OutputSet::write(const std::string& path, const std::function<Status()>& write) {
  if (path.empty()) return;
  const auto output =
      std::find_if(outputs_.begin(), outputs_.end(), [&](const Output& one) { return one.path == path; });
  TREPHINE_ASSERT(output != outputs_.end());
  if (Status error = write())
    failed_.push_back(std::move(*error));
  else
    written_.push_back(output->name);
}

void OutputSet::recorded(const Status& ended) {
  if (ended) failed_.push_back(*ended);
}

Status OutputSet::result() const {
  if (failed_.empty()) return std::nullopt;
  Error error = failed_.front();
  for (std::size_t i = 1; i < failed_.size(); ++i) error.where += ", " + failed_[i].where;
  for (std::size_t i = 0; i < written_.size(); ++i)
    error.remedy +=
        (i == 0 ? (error.remedy.empty() ? "" : "; ") + std::string("written all the same: ") : ", ") +
        written_[i];
  return error;
}

}  // namespace trephine::data_tools
