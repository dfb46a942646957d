#include "data-tools/dicom_heads.h"

#include <algorithm>
#include <filesystem>

#include "data-tools/archive.h"
#include "data-tools/atomic_file.h"
#include "data-tools/opening.h"
#include "volume/parallel.h"

namespace trephine::data_tools {

namespace fs = std::filesystem;
using namespace dicom_tag;
using volume::Error;
using volume::Result;

namespace {

constexpr std::size_t k_most_files = 200'000;

/// Names of plain files below a folder; links to folders are not followed.
std::vector<std::string> files_below(const std::string& path) {
  std::vector<std::string> files;
  std::error_code failed;
  for (fs::recursive_directory_iterator it(path, fs::directory_options::skip_permission_denied, failed), end;
       !failed && it != end && files.size() < k_most_files; it.increment(failed)) {
    if (it->path().filename().string().starts_with(".")) {  // of file systems and cameras, never of scanners
      if (it->is_directory(failed)) it.disable_recursion_pending();
      continue;
    }
    // A link that leads nowhere may be a slice that is missing: it is looked at too.
    std::error_code unknown;
    if (!it->is_directory(unknown)) files.push_back(it->path().string());
  }
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace

Result<std::vector<DicomHead>> read_dicom_heads(const std::string& path, const Progress& progress) {
  const std::string where = file_name(path);
  const bool is_folder = fs::is_directory(path);
  std::vector<std::string> files = is_folder ? files_below(path) : std::vector{path};
  // Files in archives come in memory, after the files: of the one that was named, or of those in a
  // folder.
  std::vector<ArchiveMember> members;
  if (!is_folder)  // an index stands for the disk that it lies on
    if (const auto one = read_dicom_file(ByteSource::open(path));
        std::holds_alternative<DicomFile>(one) &&
        std::get<DicomFile>(one).data.text(k_sop_class) == k_dicom_index_class)
      return read_dicom_heads(fs::absolute(path).parent_path().string(), progress);
  if (files.size() >= k_most_files)
    return Error{"the folder holds too many files", where, std::to_string(files.size()) + " and more",
                 "fewer than " + std::to_string(k_most_files), "point at the folder of one patient"};
  const auto name_of = [&](const std::string& file) {  // all of them begin with the folder's path
    return is_folder ? file.substr(file.find_first_not_of('/', path.size())) : file_name(file);
  };
  // Heads are read side by side, in parts between which it may be stopped.
  std::vector<std::variant<DicomFile, DicomRefusal>> read;
  const auto read_heads = [&](std::size_t count_all, const auto& source_of) -> bool {
    const std::size_t first = read.size();
    read.resize(first + count_all);
    constexpr std::size_t k_part = 512;
    for (std::size_t from = 0; from < count_all; from += k_part) {
      if (progress && !progress(0.3 * static_cast<double>(from) / static_cast<double>(count_all)))
        return false;
      const auto count = static_cast<int>(std::min(k_part, count_all - from));
      volume::parallel_for(count, 0, [&](int i) {
        const std::size_t n = from + static_cast<std::size_t>(i);
        auto& one = read[first + n];
        one = read_dicom_file(source_of(n));
        if (auto* file = std::get_if<DicomFile>(&one); file && file->source->is_file()) file->source.reset();
      });
    }
    return true;
  };
  const Error stopped = reading_interrupted(where);
  std::vector<std::string> archives;
  if (!is_folder && is_archive(path)) {
    archives.push_back(path);
    files.clear();
  }
  if (!read_heads(files.size(), [&](std::size_t n) { return ByteSource::open(files[n]); })) return stopped;
  // In a folder each slice may be compressed by itself; whole disks in it are unpacked when nothing else is
  // there.
  const bool has_images = std::any_of(read.begin(), read.end(), [](const auto& one) {
    const auto* file = std::get_if<DicomFile>(&one);
    return file && file->has_pixels;
  });
  for (std::size_t n = 0; n < files.size(); ++n)
    if (std::holds_alternative<DicomRefusal>(read[n]) &&
        (!has_images || (has_extension(files[n], ".gz") && !has_extension(files[n], ".tar.gz"))) &&
        !has_extension(files[n], ".nii.gz") && is_archive(files[n]))
      archives.push_back(files[n]);
  std::vector<std::string> names;
  for (const std::string& file : files) names.push_back(name_of(file));
  for (const std::string& archive : archives) {
    auto unpacked = read_archive(archive, progress);
    if (!unpacked && (!is_folder || unpacked.error().kind == volume::ErrorKind::interrupted))
      return unpacked.error();
    if (!unpacked) continue;  // it stays among what is no DICOM
    for (ArchiveMember& member : unpacked.value()) {
      const bool is_alone = unpacked.value().size() == 1;
      names.push_back(!is_folder ? member.name
                      : is_alone ? name_of(archive)
                                 : name_of(archive) + ": " + member.name);
      members.push_back(std::move(member));
    }
    if (const auto at = std::find(files.begin(), files.end(), archive); at != files.end())
      names[static_cast<std::size_t>(at - files.begin())].clear();  // its members stand for it
  }
  if (!read_heads(members.size(), [&](std::size_t n) { return ByteSource::of(members[n].bytes); }))
    return stopped;
  files.resize(files.size() + members.size());
  members.clear();

  std::vector<DicomHead> heads;
  for (std::size_t n = 0; n < read.size(); ++n)
    if (!names[n].empty()) heads.push_back({files[n], std::move(names[n]), std::move(read[n])});
  return heads;
}

}  // namespace trephine::data_tools
