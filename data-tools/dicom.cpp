#include "data-tools/dicom.h"

#include <algorithm>
#include <filesystem>

#include "data-tools/atomic_file.h"
#include "data-tools/dicom_series.h"
#include "data-tools/dicom_volume.h"
#include "data-tools/words.h"
#include "volume/text.h"

namespace trephine::data_tools {

namespace fs = std::filesystem;
using namespace dicom_tag;
using volume::Error;
using volume::Result;
using volume::Status;
using volume::Volume;

namespace {

SeriesFacts facts_of(const DicomFolder& folder, std::size_t s, std::size_t k) {
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
  std::vector<SlicePlace> places;
  for (const DicomSlice& slice : stack.slices) places.push_back(slice.place);
  const Result<SliceStack> stacked = stack_slices(places);
  if (stacked)
    facts.spacing = stacked.value().frame.spacing();
  else
    facts.spacing = {first.place.column_spacing, first.place.row_spacing, 0},
    facts.problem = stacked.error().what;
  return facts;
}

std::vector<SeriesFacts> all_facts(const DicomFolder& folder) {
  std::vector<SeriesFacts> all;
  for (std::size_t s = 0; s < folder.series.size(); ++s)
    for (std::size_t k = 0; k < folder.series[s].stacks.size(); ++k) all.push_back(facts_of(folder, s, k));
  return all;
}

/// Files that might be slices of this stack and could not be used: without them it could be short at an end,
/// where no gap shows it.
Status check_whole(const DicomFolder& folder, const DicomStack& stack, const std::string& where) {
  const std::string& like = folder.entries[stack.slices[0].entry].name;
  std::vector<std::string> lost;
  std::string why;
  const auto look = [&](const auto& files) {
    for (const auto& [name, reason] : files) {
      if (!are_names_alike(name, like) || fs::path(name).parent_path() != fs::path(like).parent_path())
        continue;
      lost.push_back(name);
      if (why.empty()) why = reason;
    }
  };
  look(folder.refused);
  look(folder.no_dicom);
  if (lost.empty()) return std::nullopt;
  return Error{lost.size() == 1 ? "another file in the folder cannot be used, and may be a slice"
                                : "other files in the folder cannot be used, and may be slices",
               where, list_of(lost) + ": " + why, "every slice of the stack, whole", k_copy_again};
}

/// A few images of the series that lie in another plane or on another grid: slices that were turned, or do
/// not belong to it. Without them the stack may be short.
Status check_strays(const DicomFolder& folder, std::size_t s, std::size_t k, const std::string& where) {
  const std::vector<DicomStack>& stacks = folder.series[s].stacks;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < stacks.size(); ++i) {
    if (i == k || stacks[i].is_localizer || !stacks[i].mark.empty()) continue;
    if (4 * stacks[i].slices.size() > stacks[k].slices.size()) continue;
    for (const DicomSlice& slice : stacks[i].slices) names.push_back(slice.place.name);
  }
  if (names.empty()) return std::nullopt;
  return Error{"slices of the series lie in another plane, or on another grid, than the others", where,
               list_of(names) + " next to " + counted(stacks[k].slices.size(), "other"),
               "parallel slices of one size",
               "take them away if they do not belong to it, or take the others alone: --volume " +
                   std::to_string(k + 1) + " (info --list shows all)"};
}

std::string words_of(const SeriesFacts& f) {
  std::string text = f.modality;  // descriptions are people's words: in info's list alone
  if (!f.mark.empty()) text += ", " + f.mark;
  return text + ", " + std::to_string(f.size.x) + " x " + std::to_string(f.size.y) + " x " +
         std::to_string(f.size.z);
}

/// Chooses one of the stacks.
Result<std::pair<std::size_t, std::size_t>> choose(const DicomFolder& folder, const OpenOptions& options,
                                                   const std::string& where) {
  const auto count = static_cast<int>(folder.series.size());
  std::pair<std::size_t, std::size_t> chosen = best_stack(folder);
  if (options.series < 0 || options.series > count)
    return Error{"there is no such series", where, std::to_string(options.series),
                 "1 to " + std::to_string(count), "see them: trephine info --list"};
  if (options.series > 0) {
    chosen = {static_cast<std::size_t>(options.series - 1), 0};
    const auto& stacks = folder.series[chosen.first].stacks;
    for (std::size_t k = 1; k < stacks.size(); ++k)
      if (stacks[k].slices.size() > stacks[chosen.second].slices.size()) chosen.second = k;
  }
  const auto volumes = static_cast<int>(folder.series[chosen.first].stacks.size());
  if (options.volume < 0 || options.volume > volumes)
    return Error{"there is no such volume in the series", where, std::to_string(options.volume),
                 volumes == 1 ? "1: it has no other" : "1 to " + std::to_string(volumes),
                 "see them: trephine info --list"};
  if (options.volume > 0) chosen.second = static_cast<std::size_t>(options.volume - 1);
  return chosen;
}

Error nothing_found(const DicomFolder& folder, const std::string& path) {
  const std::string where = file_name(path);
  if (!folder.refused.empty()) {
    std::vector<std::string> names;
    for (const auto& [name, why] : folder.refused) names.push_back(name);
    const bool is_mosaic = folder.refused[0].second.find("mosaic") != std::string::npos;
    return {"none of the DICOM files here can be used", where,
            list_of(names) + ": " + folder.refused[0].second, "images of one CT or MR series",
            is_mosaic ? "convert it first, for example with dcm2niix"
                      : "export the images of one CT or MR series"};
  }
  if (!folder.passed_over.empty())
    return {"there are no images here that lie in a patient", where, list_of(folder.passed_over),
            "the slices of a CT or MR series", "point at the folder with the slices"};
  return {k_no_dicom, where,
          !folder.notices.empty()                             ? list_of(folder.notices)
          : fs::is_directory(path) || folder.no_dicom.empty() ? counted(folder.no_dicom.size(), "other file")
                                                              : folder.no_dicom[0].second,
          "a folder that holds the slices of one series",
          "point at the folder with the scanner's files; a stack of pictures is a folder that holds two or "
          "more of "
          "one kind, and nothing else"};
}

}  // namespace

bool is_dicom_file(const std::string& path) {
  const auto read = read_dicom_file(ByteSource::open(path));
  const auto* refusal = std::get_if<DicomRefusal>(&read);
  return !refusal || refusal->fault == DicomFault::broken;
}

Result<OpenedVolume> open_dicom(const std::string& path, const OpenOptions& options) {
  const std::string where = file_name(path);
  Result<DicomFolder> scanned = scan_dicom(path, options.progress);
  if (!scanned) return scanned.error();
  const DicomFolder& folder = scanned.value();
  if (folder.series.empty()) return nothing_found(folder, path);
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
    opened.value().series = all_facts(folder);
    const SeriesFacts taken = facts_of(folder, s, k);
    notices.insert(notices.begin(),
                   "series " + std::to_string(taken.series) +
                       (taken.volumes > 1 ? ", volume " + std::to_string(taken.volume) : "") +
                       " was taken (" + words_of(taken) + "), of " + counted(volumes, "volume") +
                       ": info --list shows them, --series and --volume choose");
  }
  std::vector<std::string> others = folder.passed_over;
  for (const auto& [name, why] : folder.refused) others.push_back(name + " (" + why + ")");
  for (const auto& [name, why] : folder.no_dicom) others.push_back(name);
  if (!others.empty()) notices.push_back(counted(others.size(), "file") + " passed over: " + list_of(others));
  return opened;
}

Result<std::vector<SeriesFacts>> list_series(const std::string& path, const Progress& progress) {
  Result<DicomFolder> scanned = scan_dicom(path, progress);
  if (!scanned) return scanned.error();
  if (scanned.value().series.empty()) return nothing_found(scanned.value(), path);
  return all_facts(scanned.value());
}

}  // namespace trephine::data_tools
