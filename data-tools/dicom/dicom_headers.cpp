#include "data-tools/dicom/dicom_headers.h"

#include <algorithm>
#include <filesystem>

#include "data-tools/files/archive.h"
#include "data-tools/files/atomic_file.h"
#include "data-tools/formats/reader_support.h"
#include "volume/base/parallel.h"

namespace trephine::data_tools {

namespace fs = std::filesystem;
using namespace dicom_tag;

namespace {

constexpr std::size_t k_max_files = 200'000;

/// Returns the paths of plain files in a folder, to any depth; links to folders are not followed.
std::vector<std::string> files_below(const std::string& path) {
  std::vector<std::string> files;
  std::error_code failure;
  for (fs::recursive_directory_iterator it(path, fs::directory_options::skip_permission_denied, failure), end;
       !failure && it != end && files.size() < k_max_files; it.increment(failure)) {
    if (it->path().filename().string().starts_with(".")) {  // hidden files never come from scanners
      if (it->is_directory(failure)) it.disable_recursion_pending();
      continue;
    }
    // A broken link may be a missing slice: it is included.
    std::error_code ignored;
    if (!it->is_directory(ignored)) files.push_back(it->path().string());
  }
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace

Result<std::vector<DicomHeader>> read_dicom_headers(const std::string& path, const Progress& progress) {
  const std::string where = file_name(path);
  const bool is_folder = fs::is_directory(path);
  std::vector<std::string> files = is_folder ? files_below(path) : std::vector{path};
  // Members of archives follow the files and are kept in memory.
  std::vector<ArchiveMember> members;
  if (!is_folder)  // an index (DICOMDIR) stands for all files of its disk
    if (const auto file = read_dicom_file(ByteSource::open(path));
        std::holds_alternative<DicomFile>(file) &&
        std::get<DicomFile>(file).data.text(k_sop_class) == k_dicom_index_class)
      return read_dicom_headers(fs::absolute(path).parent_path().string(), progress);
  if (files.size() >= k_max_files)
    return Error{.what = "the folder contains too many files",
                 .where = where,
                 .found = std::to_string(files.size()) + " and more",
                 .expected = "fewer than " + std::to_string(k_max_files),
                 .remedy = "pass the folder of one patient"};
  const auto name_of = [&](const std::string& file) {  // all of them start with the folder's path
    return is_folder ? file.substr(file.find_first_not_of('/', path.size())) : file_name(file);
  };
  // The headers of each part are read in parallel; the user may cancel between two parts.
  std::vector<std::variant<DicomFile, DicomFailure>> results;
  const auto read_headers = [&](std::size_t source_count, const auto& source_of) -> bool {
    const std::size_t first = results.size();
    results.resize(first + source_count);
    constexpr std::size_t k_part = 512;
    for (std::size_t begin = 0; begin < source_count; begin += k_part) {
      if (progress && !progress(0.3 * static_cast<double>(begin) / static_cast<double>(source_count)))
        return false;
      const auto count = static_cast<int>(std::min(k_part, source_count - begin));
      parallel_for(count, 0, [&](int i) {
        const std::size_t n = begin + static_cast<std::size_t>(i);
        auto& result = results[first + n];
        result = read_dicom_file(source_of(n));
        if (auto* file = std::get_if<DicomFile>(&result); file && file->source->is_file())
          file->source.reset();
      });
    }
    return true;
  };
  const Error interrupted_error = reading_interrupted(where);
  std::vector<std::string> archives;
  if (!is_folder && is_archive(path)) {
    archives.push_back(path);
    files.clear();
  }
  if (!read_headers(files.size(), [&](std::size_t n) { return ByteSource::open(files[n]); }))
    return interrupted_error;
  // In a folder each slice may be compressed separately; archives of whole disks are unpacked only if the
  // folder has no images.
  const bool has_images = std::any_of(results.begin(), results.end(), [](const auto& result) {
    const auto* file = std::get_if<DicomFile>(&result);
    return file && file->has_pixels;
  });
  for (std::size_t n = 0; n < files.size(); ++n)
    if (std::holds_alternative<DicomFailure>(results[n]) &&
        (!has_images || (has_extension(files[n], ".gz") && !has_extension(files[n], ".tar.gz"))) &&
        !has_extension(files[n], ".nii.gz") && is_archive(files[n]))
      archives.push_back(files[n]);
  std::vector<std::string> names;
  for (const std::string& file : files) names.push_back(name_of(file));
  for (const std::string& archive : archives) {
    auto unpacked = read_archive(archive, progress);
    if (!unpacked && (!is_folder || unpacked.error().kind == ErrorKind::interrupted)) return unpacked.error();
    if (!unpacked) continue;  // reported as a file that is not DICOM
    for (ArchiveMember& member : unpacked.value()) {
      const bool is_alone = unpacked.value().size() == 1;
      names.push_back(!is_folder ? member.name
                      : is_alone ? name_of(archive)
                                 : name_of(archive) + ": " + member.name);
      members.push_back(std::move(member));
    }
    if (const auto at = std::find(files.begin(), files.end(), archive); at != files.end())
      names[static_cast<std::size_t>(at - files.begin())].clear();  // replaced by its members
  }
  if (!read_headers(members.size(), [&](std::size_t n) { return ByteSource::of(members[n].bytes); }))
    return interrupted_error;
  files.resize(files.size() + members.size());
  members.clear();

  std::vector<DicomHeader> headers;
  for (std::size_t n = 0; n < results.size(); ++n)
    if (!names[n].empty()) headers.push_back({files[n], std::move(names[n]), std::move(results[n])});
  return headers;
}

}  // namespace trephine::data_tools
