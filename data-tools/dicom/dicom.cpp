#include "data-tools/dicom/dicom.h"

#include <algorithm>
#include <filesystem>

#include "data-tools/dicom/dicom_series.h"
#include "data-tools/dicom/dicom_volume.h"
#include "data-tools/files/atomic_file.h"
#include "data-tools/files/words.h"
#include "volume/base/text.h"

namespace trephine::data_tools {

namespace fs = std::filesystem;
using namespace dicom_tag;
using volume::Volume;

namespace {

SeriesFacts series_facts(const DicomFolder& folder, std::size_t s, std::size_t k) {
  const DicomSeries& series = folder.series[s];
  const DicomStack& stack = series.stacks[k];
  const DicomSlice& first = stack.slices[0];
  SeriesFacts facts;
  facts.series = static_cast<int>(s) + 1;
  facts.volume = static_cast<int>(k) + 1;
  facts.volumes = static_cast<int>(series.stacks.size());
  facts.modality = series.modality;
  facts.description = series.description;
  facts.kernel = series.kernel;
  facts.date = series.date;
  facts.mark = stack.mark;
  facts.is_localizer = stack.is_localizer;
  facts.size = {first.columns, first.rows, static_cast<int>(stack.slices.size())};
  std::vector<SlicePosition> positions;
  for (const DicomSlice& slice : stack.slices) positions.push_back(slice.plane);
  const Result<SliceStack> stack_result = stack_slices(positions);
  if (stack_result)
    facts.spacing = stack_result.value().frame.spacing();
  else
    facts.spacing = {first.plane.column_spacing, first.plane.row_spacing, 0},
    facts.problem = stack_result.error().what;
  return facts;
}

std::vector<SeriesFacts> all_series_facts(const DicomFolder& folder) {
  std::vector<SeriesFacts> facts;
  for (std::size_t s = 0; s < folder.series.size(); ++s)
    for (std::size_t k = 0; k < folder.series[s].stacks.size(); ++k)
      facts.push_back(series_facts(folder, s, k));
  return facts;
}

/// Returns an error if unusable files may be slices of this stack. If such a slice is at an end of the stack,
/// no gap reveals that it is missing.
Status check_whole(const DicomFolder& folder, const DicomStack& stack, const std::string& where) {
  const std::string& reference = folder.entries[stack.slices[0].entry].name;
  std::vector<std::string> unusable;
  std::string first_reason;
  const auto collect = [&](const auto& files) {
    for (const auto& [name, reason] : files) {
      if (!are_names_alike(name, reference) ||
          fs::path(name).parent_path() != fs::path(reference).parent_path())
        continue;
      unusable.push_back(name);
      if (first_reason.empty()) first_reason = reason;
    }
  };
  collect(folder.refused);
  collect(folder.no_dicom);
  if (unusable.empty()) return std::nullopt;
  return Error{.what = unusable.size() == 1 ? "another file in the folder cannot be used, and may be a slice"
                                            : "other files in the folder cannot be used, and may be slices",
               .where = where,
               .found = list_of(unusable) + ": " + first_reason,
               .expected = "every slice of the stack, complete",
               .remedy = k_copy_again};
}

/// Returns an error if a few images of the series differ from this stack in plane or grid. If they are
/// rotated slices of this stack, the stack is too short without them; otherwise they do not belong to the
/// scan.
Status check_strays(const DicomFolder& folder, std::size_t s, std::size_t k, const std::string& where) {
  const std::vector<DicomStack>& stacks = folder.series[s].stacks;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < stacks.size(); ++i) {
    if (i == k || stacks[i].is_localizer || !stacks[i].mark.empty()) continue;
    if (4 * stacks[i].slices.size() > stacks[k].slices.size()) continue;
    for (const DicomSlice& slice : stacks[i].slices) names.push_back(slice.plane.name);
  }
  if (names.empty()) return std::nullopt;
  return Error{
      .what = "slices of the series differ in plane or grid",
      .where = where,
      .found = list_of(names) + ", unlike " + counted(stacks[k].slices.size(), "other"),
      .expected = "parallel slices of one size",
      .remedy =
          "remove the listed files if they are not slices of the scan, or read the others alone (option volume " +
          std::to_string(k + 1) + ")"};
}

std::string summary(const SeriesFacts& f) {
  std::string text = f.modality;  // the description is free text that may identify the patient
  if (!f.mark.empty()) text += ", " + f.mark;
  return text + ", " + std::to_string(f.size.x) + " x " + std::to_string(f.size.y) + " x " +
         std::to_string(f.size.z);
}

/// Returns the indices of the requested series and stack, or of the best ones.
Result<std::pair<std::size_t, std::size_t>> choose(const DicomFolder& folder, const OpenOptions& options,
                                                   const std::string& where) {
  const auto count = static_cast<int>(folder.series.size());
  std::pair<std::size_t, std::size_t> chosen = best_stack(folder);
  if (options.series < 0 || options.series > count)
    return Error{.what = "unknown series",
                 .where = where,
                 .found = std::to_string(options.series),
                 .expected = "1 to " + std::to_string(count),
                 .remedy = "choose one that 'trephine info FOLDER --list' lists"};
  if (options.series > 0) {
    chosen = {static_cast<std::size_t>(options.series - 1), 0};
    const auto& stacks = folder.series[chosen.first].stacks;
    for (std::size_t k = 1; k < stacks.size(); ++k)
      if (stacks[k].slices.size() > stacks[chosen.second].slices.size()) chosen.second = k;
  }
  const auto volumes = static_cast<int>(folder.series[chosen.first].stacks.size());
  if (options.volume < 0 || options.volume > volumes)
    return Error{.what = "unknown volume of the series",
                 .where = where,
                 .found = std::to_string(options.volume),
                 .expected = volumes == 1 ? "1, the only one" : "1 to " + std::to_string(volumes),
                 .remedy = "choose one that 'trephine info FOLDER --list' lists"};
  if (options.volume > 0) chosen.second = static_cast<std::size_t>(options.volume - 1);
  return chosen;
}

Error no_series_error(const DicomFolder& folder, const std::string& path) {
  const std::string where = file_name(path);
  if (!folder.refused.empty()) {
    std::vector<std::string> names;
    for (const auto& [name, reason] : folder.refused) names.push_back(name);
    const bool is_mosaic = folder.refused[0].second.find("mosaic") != std::string::npos;
    return Error{.what = "no usable DICOM file",
                 .where = where,
                 .found = list_of(names) + ": " + folder.refused[0].second,
                 .expected = "images of one CT or MR series",
                 .remedy = is_mosaic ? "convert it first, for example with dcm2niix"
                                     : "export the images of one CT or MR series"};
  }
  if (!folder.passed_over.empty())
    return Error{.what = "no image with a patient position",
                 .where = where,
                 .found = list_of(folder.passed_over),
                 .expected = "the slices of a CT or MR series",
                 .remedy = "pass the folder with the slices"};
  return {
      k_no_dicom, where,
      !folder.notices.empty()                             ? list_of(folder.notices)
      : fs::is_directory(path) || folder.no_dicom.empty() ? counted(folder.no_dicom.size(), "other file")
                                                          : folder.no_dicom[0].second,
      "a folder with the slices of one series",
      "pass the folder with the scanner's files; a stack of pictures is a folder with two or more pictures "
      "of one kind, and nothing else"};
}

}  // namespace

bool is_dicom_file(const std::string& path) {
  const auto read = read_dicom_file(ByteSource::open(path));
  const auto* failure = std::get_if<DicomFailure>(&read);
  return !failure || failure->fault == DicomFault::broken;
}

Result<OpenedVolume> open_dicom(const std::string& path, const OpenOptions& options) {
  const std::string where = file_name(path);
  Result<DicomFolder> scan_result = scan_dicom(path, options.progress);
  if (!scan_result) return scan_result.error();
  const DicomFolder& folder = scan_result.value();
  if (folder.series.empty()) return no_series_error(folder, path);
  const auto chosen = choose(folder, options, where);
  if (!chosen) return chosen.error();
  const auto [s, k] = chosen.value();
  const DicomStack& stack = folder.series[s].stacks[k];
  if (Status error = check_whole(folder, stack, where)) return *error;
  if (options.volume == 0)
    if (Status error = check_strays(folder, s, k, where)) return *error;

  Result<OpenedVolume> opened = load_dicom_stack(folder, stack, options, where);
  if (!opened) return opened;
  std::vector<std::string>& notices = opened.value().notices;
  notices.insert(notices.begin(), folder.notices.begin(), folder.notices.end());
  std::size_t volumes = 0;
  for (const DicomSeries& series : folder.series) volumes += series.stacks.size();
  if (volumes > 1) {
    opened.value().series = all_series_facts(folder);
    const SeriesFacts selected = series_facts(folder, s, k);
    notices.insert(
        notices.begin(),
        "series " + std::to_string(selected.series) +
            (selected.volumes > 1 ? ", volume " + std::to_string(selected.volume) : "") + " was selected (" +
            summary(selected) + ") from " + counted(volumes, "volume") +
            ": 'trephine info FOLDER --list' lists them; select another (option series, option volume)");
  }
  std::vector<std::string> skipped = folder.passed_over;
  for (const auto& [name, reason] : folder.refused) skipped.push_back(name + " (" + reason + ")");
  for (const auto& [name, reason] : folder.no_dicom) skipped.push_back(name);
  if (!skipped.empty()) notices.push_back(counted(skipped.size(), "file") + " skipped: " + list_of(skipped));
  return opened;
}

Result<std::vector<SeriesFacts>> list_series(const std::string& path, const Progress& progress) {
  Result<DicomFolder> scan_result = scan_dicom(path, progress);
  if (!scan_result) return scan_result.error();
  if (scan_result.value().series.empty()) return no_series_error(scan_result.value(), path);
  return all_series_facts(scan_result.value());
}

}  // namespace trephine::data_tools
