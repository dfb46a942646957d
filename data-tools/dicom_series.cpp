#include "data-tools/dicom_series.h"

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

#include "data-tools/dicom_heads.h"
#include "data-tools/dicom_repeats.h"
#include "data-tools/names_met.h"
#include "data-tools/words.h"
#include "volume/parallel.h"

namespace trephine::data_tools {

namespace fs = std::filesystem;
using namespace dicom_tag;
using volume::Result;

namespace {

constexpr const char* k_index = "index of the disk";

/// Value of an attribute that a frame has, all frames share, or the file has.
class FrameView {
 public:
  FrameView(const DicomDataSet& data, std::size_t frame) : data_(&data) {
    if (const auto& frames = data.items(k_frame_groups); frame < frames.size()) frame_ = &frames[frame];
    if (const auto& shared = data.items(k_shared_groups); !shared.empty()) shared_ = &shared[0];
  }
  /// `group`: the functional group in which enhanced files keep it.
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

bool vector_of(const FrameView& view, DicomTag tag, DicomTag group, std::size_t from, glm::dvec3& v) {
  for (std::size_t i = 0; i < 3; ++i) {
    const auto number = view.number(tag, group, from + i);
    if (!number) return false;
    v[static_cast<int>(i)] = *number;
  }
  return true;
}

/// Attributes that may distinguish images in one place, the strongest first.
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

int whole(const std::optional<double>& v, int otherwise) {
  return v && std::isfinite(*v) && std::abs(*v) < 1e9 ? static_cast<int>(*v) : otherwise;
}

/// Why it is no image of a volume, or "".
std::string why_passed_over(const DicomDataSet& data) {
  const std::string_view kind = data.text(k_sop_class);
  if (kind == k_dicom_index_class) return k_index;
  if (kind.starts_with("1.2.840.10008.5.1.4.1.1.88.")) return "report";
  if (kind.starts_with("1.2.840.10008.5.1.4.1.1.481.")) return "radiotherapy";
  if (kind.starts_with("1.2.840.10008.5.1.4.1.1.11.")) return "presentation state";
  if (kind.starts_with("1.2.840.10008.5.1.4.1.1.7")) return "screen capture";
  if (kind == "1.2.840.10008.5.1.4.1.1.66.4") return "segmentation";
  if (kind == "1.2.840.10008.5.1.4.1.1.104.1") return "document";
  return "";
}

/// A name as disks and their indexes have it in common: without case, ";1" and what was added when it was
/// copied.
std::string plain_name(std::string name) {
  for (char& c : name) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  name.resize(std::min(name.size(), name.find(';')));
  for (const char* added : {".gz", ".dcm"})
    if (name.ends_with(added)) name.resize(name.size() - std::strlen(added));
  return name;
}

std::string folder_of(const std::string& name) { return name.substr(0, name.find_last_of("/ ") + 1); }

/// In the style of the neighbouring files' names.
std::string named_like(const std::string& sibling, const std::string& name) {
  const std::string plain = plain_name(sibling);
  const bool is_lower = sibling.starts_with(plain);
  return (is_lower ? plain_name(name) : name) + sibling.substr(plain.size());
}

/// A disk's index says what lies on it: what is not there may be the end of a stack. Folders of which nothing
/// is there were left out on purpose.
void compare_with_index(const DicomHead& index, const std::vector<DicomHead>& heads, DicomFolder& folder) {
  std::set<std::string> known;
  std::map<std::string, std::string> sibling_in;
  for (const DicomHead& head : heads) {
    known.insert(plain_name(head.name));
    if (&head != &index) sibling_in.emplace(folder_of(plain_name(head.name)), head.name);
  }
  const std::string base = folder_of(index.name);
  std::vector<std::string> missing;
  for (const DicomDataSet& record : std::get<DicomFile>(index.read).data.items(k_records)) {
    std::string name(record.text(k_referenced_file));
    if (name.empty() || record.number(k_record_in_use) == 0) continue;
    std::replace(name.begin(), name.end(), '\\', '/');
    name.insert(0, base);
    meet_name(name);
    const std::string plain = plain_name(name);
    if (known.count(plain) > 0) continue;
    if (const auto at = sibling_in.find(folder_of(plain)); at != sibling_in.end()) {
      folder.refused.emplace_back(named_like(at->second, name),
                                  "it is not there, though the disk's index names it");
      meet_name(folder.refused.back().first);
    } else {
      missing.push_back(name);
    }
  }
  if (!missing.empty())
    folder.notices.push_back("the disk's index names " + counted(missing.size(), "file") +
                             " in folders that are not here: " + list_of(missing));
}

/// The images of one file. Error text when they cannot be used.
std::string add_slices(const DicomEntry& entry, std::size_t index, std::vector<DicomSlice>& to) {
  const DicomDataSet& data = entry.file.data;
  if (!data.items(k_modality_lut).empty()) return "its values go through a table (Modality LUT)";
  const std::string_view photometric = data.text(k_photometric);
  if (photometric == "PALETTE COLOR" || whole(data.number(k_samples), 1) != 1) return "a colour picture";
  if (data.text(k_image_type).find("MOSAIC") != std::string_view::npos) {
    const std::string_view tiles = data.text(k_tile_count);
    return "a mosaic of " + (tiles.empty() ? std::string("many") : std::string(tiles)) +
           " slices in one image";
  }
  if (photometric == "MONOCHROME1") return "inverted grey values (MONOCHROME1)";
  const int frames = std::max(1, whole(data.number(k_frames), 1));
  if (frames > 100'000) return "a number of frames that cannot be";
  if (frames > 1 && data.items(k_frame_groups).empty())
    return "it states one place for all of its " + std::to_string(frames) + " frames";
  for (int f = 0; f < frames; ++f) {
    const FrameView view(data, static_cast<std::size_t>(f));
    DicomSlice slice;
    slice.entry = index;
    slice.frame = static_cast<std::size_t>(f);
    if (!vector_of(view, k_position, k_plane_position, 0, slice.place.position) ||
        !vector_of(view, k_orientation, k_plane_orientation, 0, slice.place.row_axis) ||
        !vector_of(view, k_orientation, k_plane_orientation, 3, slice.place.column_axis))
      return "it does not say where in the patient it lies";
    slice.place.row_spacing = view.number(k_pixel_spacing, k_pixel_measures, 0).value_or(0);
    slice.place.column_spacing = view.number(k_pixel_spacing, k_pixel_measures, 1).value_or(0);
    slice.place.thickness = view.number(k_slice_thickness, k_pixel_measures).value_or(0);
    slice.place.name = entry.name + (frames > 1 ? " frame " + std::to_string(f + 1) : "");
    const DicomDataSet& rescale = view.holder(k_slope, k_value_transformation);
    slice.has_rescale = rescale.has(k_slope) && rescale.has(k_intercept);
    for (const DicomTag tag : {k_slope, k_intercept})
      if (rescale.has(tag) && (!rescale.number(tag) || rescale.count(tag) != 1))
        return "a rescale slope or intercept that is no number: \"" +
               std::string(rescale.text(tag).substr(0, 40)) + "\"";
    slice.slope = rescale.number(k_slope).value_or(1);
    slice.intercept = rescale.number(k_intercept).value_or(0);
    slice.rescale_type = rescale.text(k_rescale_type);
    if (slice.slope == 0 || !std::isfinite(slice.slope) || !std::isfinite(slice.intercept))
      return "a rescale slope or intercept that is no usable number";
    slice.rows = whole(data.number(k_rows), 0);
    slice.columns = whole(data.number(k_columns), 0);
    slice.bits_allocated = whole(data.number(k_bits_allocated), 0);
    slice.bits_stored = whole(data.number(k_bits_stored), slice.bits_allocated);
    slice.high_bit = whole(data.number(k_high_bit), slice.bits_stored - 1);
    slice.is_signed = whole(data.number(k_pixel_representation), 0) != 0;
    if (slice.rows <= 0 || slice.columns <= 0) return "no size of its image";
    if ((slice.bits_allocated != 8 && slice.bits_allocated != 16 && slice.bits_allocated != 32) ||
        slice.bits_stored <= 0 || slice.bits_stored > slice.bits_allocated ||
        slice.high_bit != slice.bits_stored - 1)
      return "pixels of " + std::to_string(slice.bits_stored) + " of " +
             std::to_string(slice.bits_allocated) + " bits, which is not read";
    if (const auto low = data.number(k_padding)) {
      const auto stored = [&slice](double v) {  // implicit files do not say whether it is signed
        const int raw = static_cast<int>(v) & 0xffff;
        return slice.is_signed ? static_cast<int>(static_cast<std::int16_t>(raw)) : raw;
      };
      const double high = data.number(k_padding_limit).value_or(*low);
      if (std::isfinite(*low) && std::isfinite(high) && std::abs(*low) < 1e6 && std::abs(high) < 1e6)
        slice.padding = std::minmax(stored(*low), stored(high));
    }
    slice.number = frames > 1 ? f + 1 : whole(data.number(k_instance_number), 0);
    slice.marks = marks_of(view, data);
    to.push_back(std::move(slice));
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
  std::tuple<bool, bool, std::size_t> best_worth{false, false, 0};
  for (std::size_t s = 0; s < folder.series.size(); ++s)
    for (std::size_t k = 0; k < folder.series[s].stacks.size(); ++k) {
      const DicomStack& stack = folder.series[s].stacks[k];
      const std::tuple worth{!stack.is_localizer, folder.series[s].modality == "CT", stack.slices.size()};
      if (worth > best_worth) best = {s, k}, best_worth = worth;
    }
  return best;
}

Result<DicomFolder> scan_dicom(const std::string& path, const Progress& progress) {
  Result<std::vector<DicomHead>> heads = read_dicom_heads(path, progress);
  if (!heads) return heads.error();
  DicomFolder folder;
  for (const DicomHead& head : heads.value())
    if (const auto* file = std::get_if<DicomFile>(&head.read);
        file && file->data.text(k_sop_class) == k_dicom_index_class)
      compare_with_index(head, heads.value(), folder);
  for (DicomHead& head : heads.value()) {
    const std::string& name = head.name;
    if (const auto* refusal = std::get_if<DicomRefusal>(&head.read)) {
      (refusal->fault == DicomFault::broken ? folder.refused : folder.no_dicom)
          .emplace_back(name, refusal->found);
      continue;
    }
    auto& file = std::get<DicomFile>(head.read);
    if (const std::string why = why_passed_over(file.data); !why.empty()) {
      if (why != k_index) folder.passed_over.push_back(name + " (" + why + ")");
      continue;
    }
    if (!file.has_pixels) {
      // With a size it should have had them.
      if (file.data.has(k_rows))
        folder.refused.emplace_back(name, "it ends before its pixels");
      else
        folder.passed_over.push_back(name + " (no image)");
      continue;
    }
    folder.entries.push_back({std::move(head.path), std::move(head.name), std::move(file)});
  }
  // Each file's images side by side; what is said of them in order.
  std::vector<std::vector<DicomSlice>> slices_of(folder.entries.size());
  std::vector<std::string> why_not(folder.entries.size());
  volume::parallel_for(static_cast<int>(folder.entries.size()), 0, [&](int i) {
    const auto n = static_cast<std::size_t>(i);
    why_not[n] = add_slices(folder.entries[n], n, slices_of[n]);
  });
  std::vector<DicomSlice> slices;
  for (std::size_t n = 0; n < slices_of.size(); ++n)
    if (why_not[n].empty())
      std::move(slices_of[n].begin(), slices_of[n].end(), std::back_inserter(slices));
    else
      folder.refused.emplace_back(folder.entries[n].name, why_not[n]);

  // Series, and in them grids.
  std::map<std::string, std::size_t> series_of;
  for (DicomSlice& slice : slices) {
    const DicomDataSet& data = folder.entries[slice.entry].file.data;
    // One series lies in one frame of reference and is of one kind, or it is several.
    std::string uid;
    for (const DicomTag tag : {k_series, k_study, k_frame_of_reference, k_modality})
      uid.append(data.text(tag)).append("|");
    const auto [at, is_new] = series_of.emplace(uid, folder.series.size());
    if (is_new) {
      DicomSeries& made = folder.series.emplace_back();
      made.uid = uid;
      made.number = data.text(k_series_number);
      made.modality = data.text(k_modality);
      made.description = data.text(k_series_description);
      made.kernel = data.text(k_kernel);
      made.date = data.text(data.has(k_series_date) ? k_series_date : k_study_date);
    }
    DicomSeries& series = folder.series[at->second];
    const bool is_scout = is_localizer(data);
    const auto stack = std::find_if(series.stacks.begin(), series.stacks.end(), [&](const DicomStack& one) {
      return one.is_localizer == is_scout && are_of_one_grid(one.slices[0], slice);
    });
    if (stack != series.stacks.end()) {
      stack->slices.push_back(std::move(slice));
    } else {
      DicomStack& made = series.stacks.emplace_back();
      made.is_localizer = is_scout;
      made.slices.push_back(std::move(slice));
    }
  }
  for (DicomSeries& series : folder.series) {
    std::vector<DicomStack> split;
    for (DicomStack& stack : series.stacks) {
      if (has_doubles(stack.slices)) {
        const std::vector<std::string> copies = drop_copies(folder, stack.slices);
        if (!copies.empty())
          folder.notices.push_back(std::to_string(copies.size()) +
                                   (copies.size() == 1 ? " slice is" : " slices are") +
                                   " there twice, and taken once: " + list_of(copies));
      }
      split_doubles(std::move(stack), 0, split);
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
