#include "data-tools/dicom/dicom_series.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <glm/geometric.hpp>
#include <iterator>
#include <map>
#include <numeric>
#include <set>
#include <tuple>

#include "data-tools/dicom/dicom_headers.h"
#include "data-tools/dicom/dicom_repeats.h"
#include "data-tools/files/sensitive_names.h"
#include "data-tools/files/words.h"
#include "volume/base/parallel.h"

namespace trephine::data_tools {

namespace fs = std::filesystem;
using namespace dicom_tag;

namespace {

constexpr const char* k_index = "index of the disk";

/// Attributes of a frame: its own, those shared by all frames, or those of the file.
class FrameView {
 public:
  FrameView(const DicomDataSet& data, std::size_t frame) : data_(&data) {
    if (const auto& frames = data.items(k_frame_groups); frame < frames.size()) frame_ = &frames[frame];
    if (const auto& shared = data.items(k_shared_groups); !shared.empty()) shared_ = &shared[0];
  }
  /// Returns the data set that contains a tag; `group`: its functional group in enhanced files.
  const DicomDataSet& holder(DicomTag tag, DicomTag group) const {
    for (const DicomDataSet* set : {frame_, shared_})
      if (set)
        for (const DicomDataSet& item : set->items(group))
          if (item.has(tag)) return item;
    return *data_;
  }
  std::optional<double> number(DicomTag tag, DicomTag group, std::size_t i = 0) const {
    return holder(tag, group).number(tag, i);
  }
  std::string text(DicomTag tag, DicomTag group) const { return std::string(holder(tag, group).text(tag)); }

 private:
  const DicomDataSet *data_, *frame_ = nullptr, *shared_ = nullptr;
};

bool vector_of(const FrameView& view, DicomTag tag, DicomTag group, std::size_t first, glm::dvec3& v) {
  for (std::size_t i = 0; i < 3; ++i) {
    const auto number = view.number(tag, group, first + i);
    if (!number) return false;
    v[static_cast<int>(i)] = *number;
  }
  return true;
}

/// Returns attributes that may distinguish images at the same position, in the order in which split_repeats()
/// tries them.
std::vector<std::pair<std::string, std::string>> marks_of(const FrameView& view, const DicomDataSet& data) {
  std::vector<std::pair<std::string, std::string>> marks;
  marks.emplace_back("kind", data.text(k_image_type));
  marks.emplace_back("echo time", data.text(k_echo_time));
  marks.emplace_back("echo", data.text(k_echo_number));
  marks.emplace_back("kernel", data.text(k_kernel));
  marks.emplace_back("b value", data.text(k_b_value));
  std::string phase = view.text(k_temporal_index, k_frame_content);
  if (phase.empty()) phase = data.text(k_temporal_position);
  marks.emplace_back("phase", phase);
  marks.emplace_back("trigger time", data.text(k_trigger_time));
  marks.emplace_back("acquisition", view.text(k_acquisition_number, k_frame_content));
  return marks;
}

int int_or(const std::optional<double>& v, int fallback) {
  return v && std::isfinite(*v) && std::abs(*v) < 1e9 ? static_cast<int>(*v) : fallback;
}

/// Returns the reason why a file contains no image of a volume, or "".
std::string skip_reason(const DicomDataSet& data) {
  const std::string_view kind = data.text(k_sop_class);
  if (kind == k_dicom_index_class) return k_index;
  if (kind.starts_with("1.2.840.10008.5.1.4.1.1.88.")) return "report";
  if (kind.starts_with("1.2.840.10008.5.1.4.1.1.481.")) return "radiotherapy";
  if (kind.starts_with("1.2.840.10008.5.1.4.1.1.11.")) return "presentation state";
  if (kind == "1.2.840.10008.5.1.4.1.1.7" || kind.starts_with("1.2.840.10008.5.1.4.1.1.7."))
    return "screen capture";
  if (kind.starts_with("1.2.840.10008.5.1.4.1.1.77.")) return "photograph";
  if (kind == "1.2.840.10008.5.1.4.1.1.66.4") return "segmentation";
  if (kind == "1.2.840.10008.5.1.4.1.1.104.1") return "document";
  return "";
}

/// Returns the part of a name that a disk and its index have in common: lower case, without ";1" and
/// extensions added by copying.
std::string normalized_name(std::string name) {
  for (char& c : name) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  name.resize(std::min(name.size(), name.find(';')));
  for (const char* extension : {".gz", ".dcm"})
    if (name.ends_with(extension)) name.resize(name.size() - std::strlen(extension));
  return name;
}

/// Returns a name up to its last slash or space. The space separates the archive from the member in the name
/// of an archive member, "archive.zip: member".
std::string folder_of(const std::string& name) { return name.substr(0, name.find_last_of("/ ") + 1); }

/// Returns a name in the style (case, extension) of a file in the same folder.
std::string styled_name(const std::string& sibling, const std::string& name) {
  const std::string normalized = normalized_name(sibling);
  const bool is_lower = sibling.starts_with(normalized);
  return (is_lower ? normalized_name(name) : name) + sibling.substr(normalized.size());
}

/// Adds the missing files of a disk's index to folder.refused, because they may be the end of a stack. A
/// folder without any file is assumed to be omitted on purpose: its files are listed in a notice instead.
void compare_with_index(const DicomHeader& index, const std::vector<DicomHeader>& headers,
                        DicomFolder& folder) {
  std::set<std::string> known;
  std::map<std::string, std::string> sibling_in;
  for (const DicomHeader& head : headers) {
    known.insert(normalized_name(head.name));
    if (&head != &index) sibling_in.emplace(folder_of(normalized_name(head.name)), head.name);
  }
  const std::string base = folder_of(index.name);
  std::vector<std::string> missing;
  for (const DicomDataSet& record : std::get<DicomFile>(index.read).data.items(k_records)) {
    std::string name(record.text(k_referenced_file));
    if (name.empty() || record.number(k_record_in_use) == 0) continue;
    std::replace(name.begin(), name.end(), '\\', '/');
    name.insert(0, base);
    record_sensitive_name(name);
    const std::string normalized = normalized_name(name);
    if (known.count(normalized) > 0) continue;
    if (const auto at = sibling_in.find(folder_of(normalized)); at != sibling_in.end()) {
      folder.refused.emplace_back(styled_name(at->second, name),
                                  "it is missing, although the disk's index lists it");
      record_sensitive_name(folder.refused.back().first);
    } else {
      missing.push_back(name);
    }
  }
  if (!missing.empty())
    folder.notices.push_back("the disk's index lists " + counted(missing.size(), "file") +
                             " in folders that are missing: " + list_of(missing));
}

/// Appends the images of one file; returns an error text if they cannot be used, or "".
std::string add_slices(const DicomEntry& entry, std::size_t index, std::vector<DicomSlice>& slices) {
  const DicomDataSet& data = entry.file.data;
  if (!data.items(k_modality_lut).empty()) return "its values require a table (Modality LUT)";
  const std::string_view photometric = data.text(k_photometric);
  if (photometric == "PALETTE COLOR" || int_or(data.number(k_samples), 1) != 1) return "a colour picture";
  if (data.text(k_image_type).find("MOSAIC") != std::string_view::npos) {
    const std::string_view tiles = data.text(k_tile_count);
    return "a mosaic of " + (tiles.empty() ? std::string("many") : std::string(tiles)) +
           " slices in one image";
  }
  if (photometric == "MONOCHROME1") return "inverted grey values (MONOCHROME1)";
  const int frames = std::max(1, int_or(data.number(k_frames), 1));
  if (frames > 100'000) return "an impossible number of frames";
  if (frames > 1 && data.items(k_frame_groups).empty())
    return "it states one position for all of its " + std::to_string(frames) + " frames";
  for (int f = 0; f < frames; ++f) {
    const FrameView view(data, static_cast<std::size_t>(f));
    DicomSlice slice;
    slice.entry = index;
    slice.frame = static_cast<std::size_t>(f);
    if (!vector_of(view, k_position, k_plane_position, 0, slice.plane.position) ||
        !vector_of(view, k_orientation, k_plane_orientation, 0, slice.plane.row_axis) ||
        !vector_of(view, k_orientation, k_plane_orientation, 3, slice.plane.column_axis))
      return "it has no position in the patient";
    slice.plane.row_spacing = view.number(k_pixel_spacing, k_pixel_measures, 0).value_or(0);
    slice.plane.column_spacing = view.number(k_pixel_spacing, k_pixel_measures, 1).value_or(0);
    slice.plane.thickness = view.number(k_slice_thickness, k_pixel_measures).value_or(0);
    slice.plane.name = entry.name + (frames > 1 ? " frame " + std::to_string(f + 1) : "");
    const DicomDataSet& rescale = view.holder(k_slope, k_value_transformation);
    slice.has_rescale = rescale.has(k_slope) && rescale.has(k_intercept);
    for (const DicomTag tag : {k_slope, k_intercept})
      if (rescale.has(tag) && (!rescale.number(tag) || rescale.count(tag) != 1))
        return "a rescale slope or intercept that is not a number: \"" +
               std::string(rescale.text(tag).substr(0, 40)) + "\"";
    slice.slope = rescale.number(k_slope).value_or(1);
    slice.intercept = rescale.number(k_intercept).value_or(0);
    slice.rescale_type = rescale.text(k_rescale_type);
    if (slice.slope == 0 || !std::isfinite(slice.slope) || !std::isfinite(slice.intercept))
      return "a rescale slope or intercept that is not usable";
    slice.rows = int_or(data.number(k_rows), 0);
    slice.columns = int_or(data.number(k_columns), 0);
    slice.bits_allocated = int_or(data.number(k_bits_allocated), 0);
    slice.bits_stored = int_or(data.number(k_bits_stored), slice.bits_allocated);
    slice.high_bit = int_or(data.number(k_high_bit), slice.bits_stored - 1);
    slice.is_signed = int_or(data.number(k_pixel_representation), 0) != 0;
    if (slice.rows <= 0 || slice.columns <= 0) return "an image without a size";
    if ((slice.bits_allocated != 8 && slice.bits_allocated != 16 && slice.bits_allocated != 32) ||
        slice.bits_stored <= 0 || slice.bits_stored > slice.bits_allocated ||
        slice.high_bit != slice.bits_stored - 1)
      return "pixels of " + std::to_string(slice.bits_stored) + " of " +
             std::to_string(slice.bits_allocated) + " bits, which is not supported";
    if (const auto low = data.number(k_padding)) {
      const auto stored = [&slice](double v) {  // implicit files do not state whether the value is signed
        const int raw = static_cast<int>(v) & 0xffff;
        return slice.is_signed ? static_cast<int>(static_cast<std::int16_t>(raw)) : raw;
      };
      const double high = data.number(k_padding_limit).value_or(*low);
      if (std::isfinite(*low) && std::isfinite(high) && std::abs(*low) < 1e6 && std::abs(high) < 1e6)
        slice.padding = std::minmax(stored(*low), stored(high));
    }
    slice.number = frames > 1 ? f + 1 : int_or(data.number(k_instance_number), 0);
    slice.marks = marks_of(view, data);
    slices.push_back(std::move(slice));
  }
  return "";
}

bool is_localizer(const DicomDataSet& data) {
  const std::string_view kind = data.text(k_image_type);
  return kind.find("LOCALIZER") != std::string_view::npos || kind.find("SCOUT") != std::string_view::npos;
}

}  // namespace

bool are_names_alike(const std::string& a, const std::string& b) {
  const auto shape = [](const std::string& path) {
    std::string out;
    for (const char c : fs::path(path).filename().string()) {
      const bool is_digit = c >= '0' && c <= '9';
      if (!is_digit)
        out += c;
      else if (out.empty() || out.back() != '#')
        out += '#';
    }
    return out;
  };
  return shape(a) == shape(b);
}

std::pair<std::size_t, std::size_t> best_stack(const DicomFolder& folder) {
  std::pair<std::size_t, std::size_t> best{0, 0};
  std::tuple<bool, bool, std::size_t> best_rank{false, false, 0};
  for (std::size_t s = 0; s < folder.series.size(); ++s)
    for (std::size_t k = 0; k < folder.series[s].stacks.size(); ++k) {
      const DicomStack& stack = folder.series[s].stacks[k];
      const std::tuple rank{!stack.is_localizer, folder.series[s].modality == "CT", stack.slices.size()};
      if (rank > best_rank) best = {s, k}, best_rank = rank;
    }
  return best;
}

Result<DicomFolder> scan_dicom(const std::string& path, const Progress& progress) {
  Result<std::vector<DicomHeader>> headers = read_dicom_headers(path, progress);
  if (!headers) return headers.error();
  DicomFolder folder;
  for (const DicomHeader& head : headers.value())
    if (const auto* file = std::get_if<DicomFile>(&head.read);
        file && file->data.text(k_sop_class) == k_dicom_index_class)
      compare_with_index(head, headers.value(), folder);
  for (DicomHeader& head : headers.value()) {
    const std::string& name = head.name;
    if (const auto* refusal = std::get_if<DicomFailure>(&head.read)) {
      (refusal->fault == DicomFault::broken ? folder.refused : folder.no_dicom)
          .emplace_back(name, refusal->found);
      continue;
    }
    auto& file = std::get<DicomFile>(head.read);
    if (const std::string reason = skip_reason(file.data); !reason.empty()) {
      if (reason != k_index) folder.passed_over.push_back(name + " (" + reason + ")");
      continue;
    }
    if (!file.has_pixels) {
      // A file that states a number of rows should have pixels.
      if (file.data.has(k_rows))
        folder.refused.emplace_back(name, "it ends before its pixels");
      else
        folder.passed_over.push_back(name + " (no image)");
      continue;
    }
    folder.entries.push_back({std::move(head.path), std::move(head.name), std::move(file)});
  }
  // The attributes of images are evaluated in parallel; errors are collected in the order of the files.
  std::vector<std::vector<DicomSlice>> slices_of(folder.entries.size());
  std::vector<std::string> errors(folder.entries.size());
  parallel_for(static_cast<int>(folder.entries.size()), 0, [&](int i) {
    const auto n = static_cast<std::size_t>(i);
    errors[n] = add_slices(folder.entries[n], n, slices_of[n]);
  });
  std::vector<DicomSlice> slices;
  for (std::size_t n = 0; n < slices_of.size(); ++n)
    if (errors[n].empty())
      std::move(slices_of[n].begin(), slices_of[n].end(), std::back_inserter(slices));
    else
      folder.refused.emplace_back(folder.entries[n].name, errors[n]);

  // Assign slices to series, and in each series to stacks of one grid.
  std::map<std::string, std::size_t> series_of;
  for (DicomSlice& slice : slices) {
    const DicomDataSet& data = folder.entries[slice.entry].file.data;
    // Slices with different frames of reference or modalities belong to different series.
    std::string uid;
    for (const DicomTag tag : {k_series, k_study, k_frame_of_reference, k_modality})
      uid.append(data.text(tag)).append("|");
    const auto [at, is_new] = series_of.emplace(uid, folder.series.size());
    if (is_new) {
      DicomSeries& result = folder.series.emplace_back();
      result.uid = uid;
      result.number = data.text(k_series_number);
      result.modality = data.text(k_modality);
      result.description = data.text(k_series_description);
      result.kernel = data.text(k_kernel);
      result.date = data.text(data.has(k_series_date) ? k_series_date : k_study_date);
    }
    DicomSeries& series = folder.series[at->second];
    const bool is_scout = is_localizer(data);
    const auto stack =
        std::find_if(series.stacks.begin(), series.stacks.end(), [&](const DicomStack& candidate) {
          return candidate.is_localizer == is_scout && have_same_grid(candidate.slices[0], slice);
        });
    if (stack != series.stacks.end()) {
      stack->slices.push_back(std::move(slice));
    } else {
      DicomStack& result = series.stacks.emplace_back();
      result.is_localizer = is_scout;
      result.slices.push_back(std::move(slice));
    }
  }
  for (DicomSeries& series : folder.series) {
    std::vector<DicomStack> split;
    for (DicomStack& stack : series.stacks) {
      if (has_repeated_positions(stack.slices)) {
        const std::vector<std::string> copies = drop_copies(folder, stack.slices);
        if (!copies.empty())
          folder.notices.push_back(std::to_string(copies.size()) +
                                   (copies.size() == 1 ? " slice is" : " slices are") +
                                   " duplicated and used once: " + list_of(copies));
      }
      split_repeats(std::move(stack), 0, split);
    }
    series.stacks = std::move(split);
  }
  join_lone_slices(folder);
  const auto number = [](const std::string& text) { return text.empty() ? 1e9 : std::atof(text.c_str()); };
  std::stable_sort(
      folder.series.begin(), folder.series.end(),
      [&](const DicomSeries& a, const DicomSeries& b) { return number(a.number) < number(b.number); });
  return folder;
}

}  // namespace trephine::data_tools
