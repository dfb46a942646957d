#include "data-tools/cases/label_file.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <glm/common.hpp>
#include <map>
#include <optional>
#include <utility>

#include "data-tools/cases/case_folder.h"
#include "data-tools/dicom/dicom_segmentation.h"
#include "data-tools/files/atomic_file.h"
#include "data-tools/files/words.h"
#include "data-tools/formats/reader_support.h"
#include "data-tools/formats/write_volume.h"
#include "volume/base/text.h"

namespace trephine::data_tools {

using volume::Volume;

namespace fs = std::filesystem;

namespace {

/// A label of the file or folder: its layer and value.
using Key = std::pair<int, int>;

/// Segments of a file or masks of a folder, read layer by layer.
struct LabelLayers {
  int count = 1;
  std::vector<SegmentFacts> segments;
  std::function<Result<OpenedVolume>(int layer)> open;
  std::optional<OpenedVolume> first;  ///< layer 0, if it was read to find the layers
};

/// Assigns temporary ids while layers are read: one id per label of the file, and one per combination of
/// overlapping labels.
class LabelIds {
 public:
  /// Returns the id of a label; creates it if necessary.
  int id_of(const Key& key) {
    const auto [at, is_new] = ids_.emplace(key, next_);
    if (is_new) sets_[next_++] = {key};
    return at->second;
  }
  /// Returns the id of voxels that belong to the labels of both ids; creates it if necessary.
  int overlap_of(int id, int other) {
    const auto [at, is_new] = overlaps_.emplace(std::pair(id, other), next_);
    if (!is_new) return at->second;
    std::vector<Key> keys = sets_[id];
    for (const Key& key : sets_[other])
      if (std::find(keys.begin(), keys.end(), key) == keys.end()) keys.push_back(key);
    std::sort(keys.begin(), keys.end());
    for (const auto& [known, set] : sets_)
      if (set == keys) return at->second = known;
    sets_[next_] = keys;
    return at->second = next_++;
  }
  /// Returns the labels of each id: one, or several for overlaps.
  const std::map<int, std::vector<Key>>& sets() const { return sets_; }

 private:
  std::map<Key, int> ids_;
  std::map<std::pair<int, int>, int> overlaps_;
  std::map<int, std::vector<Key>> sets_;
  int next_ = 1;
};

/// Numbers of the labels in the result, by temporary id, with the names and colours of all numbers.
struct Numbering {
  std::map<int, int> number_of;
  std::vector<std::string> names{"background"};
  std::vector<glm::u8vec3> colours;  ///< of all numbers; empty if no segment has a colour
};

/// Returns the extent of a volume, "from (-120, -80, 5) to (10, 90, 140) mm".
std::string extent_text(const Volume& v) {
  glm::dvec3 low(1e300), high(-1e300);
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec3 p = v.frame.world_from_volume(glm::dvec3(corner & 1, corner >> 1 & 1, corner >> 2) *
                                                   glm::dvec3(v.size - 1));
    low = glm::min(low, p);
    high = glm::max(high, p);
  }
  const auto text = [](const glm::dvec3& p) {
    std::string point_text = "(";
    return point_text.append(rounded_text(p.x))
        .append(", ")
        .append(rounded_text(p.y))
        .append(", ")
        .append(rounded_text(p.z))
        .append(")");
  };
  return "from " + text(low) + " to " + text(high) + " mm";
}

const SegmentFacts* segment_of(const std::vector<SegmentFacts>& segments, const Key& key) {
  for (const SegmentFacts& s : segments)
    if (s.layer == key.first && s.value == key.second) return &s;
  return nullptr;
}

/// Sets the colours of all numbers if a segment has a colour. Labels without a colour get the default colour
/// of their number.
void set_colours(Numbering& numbering, const LabelIds& ids, const std::vector<SegmentFacts>& segments) {
  if (std::none_of(segments.begin(), segments.end(), [](const SegmentFacts& s) { return s.colour; })) return;
  for (std::size_t label = 0; label < numbering.names.size(); ++label)
    numbering.colours.emplace_back(glm::floor(255.0 * label_colour(static_cast<int>(label), {}) + 0.5));
  numbering.colours[0] = glm::u8vec3(0);
  for (const auto& [id, keys] : ids.sets()) {
    const SegmentFacts* segment = keys.size() == 1 ? segment_of(segments, keys[0]) : nullptr;
    if (segment && segment->colour)
      numbering.colours[static_cast<std::size_t>(numbering.number_of.at(id))] = *segment->colour;
  }
}

/// Assigns the numbers of the result. If there is one layer, without values above 255, the values of the file
/// are kept. Otherwise labels are numbered from 1 up, overlaps last. An overlap is named "first+second".
Result<Numbering> number_labels(const LabelIds& ids, const LabelLayers& layers, const std::string& where,
                                std::vector<std::string>& notices) {
  Numbering numbering;
  if (ids.sets().size() > 255)
    return Error{.what = "there are too many labels",
                 .where = where,
                 .found = std::to_string(ids.sets().size()),
                 .expected = "at most 255",
                 .remedy = "export fewer labels"};
  std::vector<std::pair<std::vector<Key>, int>> order;  // labels with their ids, then overlaps
  int largest_value = 0;
  std::size_t overlaps = 0;
  for (const auto& [id, keys] : ids.sets()) {
    order.emplace_back(keys, id);
    overlaps += keys.size() > 1;
    for (const Key& key : keys) largest_value = std::max(largest_value, key.second);
  }
  std::sort(order.begin(), order.end(), [](const auto& a, const auto& b) {
    return a.first.size() != b.first.size() ? a.first.size() < b.first.size() : a.first < b.first;
  });
  const bool keeps_values = layers.count == 1 && overlaps == 0 && largest_value <= 255;
  if (layers.count == 1 && !keeps_values)
    notices.push_back("labels were renumbered from 1 up: values up to " + std::to_string(largest_value) +
                      " occur");
  else if (!keeps_values)
    notices.push_back("labels of " + std::to_string(layers.count) + " layers were renumbered from 1 up");
  if (overlaps > 0)
    notices.push_back("segments overlap: " + counted(overlaps, "label") +
                      " for voxels that belong to several, named \"first+second\"");
  int next = 1;
  for (const auto& [keys, id] : order) {
    const int number = keeps_values ? keys[0].second : next++;
    numbering.number_of[id] = number;
    while (static_cast<int>(numbering.names.size()) <= number)
      numbering.names.push_back("label-" + std::to_string(numbering.names.size()));
    std::string name;
    for (const Key& key : keys) {
      const SegmentFacts* segment = segment_of(layers.segments, key);
      name.append(name.empty() ? "" : "+");
      name.append(segment && !segment->name.empty() ? segment->name : "label-" + std::to_string(key.second));
    }
    // Segments with equal names get different names.
    std::string unique = name;
    const auto is_used = [&](const std::string& text) {
      const auto at = std::find(numbering.names.begin(), numbering.names.end(), text);
      return at != numbering.names.end() && at - numbering.names.begin() != number;
    };
    for (int k = 2; is_used(unique); ++k) unique = name + "-" + std::to_string(k);
    numbering.names[static_cast<std::size_t>(number)] = unique;
  }
  set_colours(numbering, ids, layers.segments);
  return numbering;
}

/// Finds the masks of a folder, one structure per file, as written by TotalSegmentator.
Result<LabelLayers> find_masks(const std::string& path, const OpenOptions& options) {
  std::vector<std::string> files;
  std::error_code failure;
  for (fs::directory_iterator at(path, failure), end; !failure && at != end; at.increment(failure)) {
    const std::string file = at->path().string();
    for (const char* extension : {".nii.gz", ".nii", ".nrrd", ".mha"})
      if (has_extension(file, extension) && !has_extension(file, ".seg.nrrd")) files.push_back(file);
  }
  if (files.empty())
    return Error{.what = "the folder contains no masks",
                 .where = file_name(path),
                 .expected = "files .nii.gz, .nii, .nrrd or .mha, one per structure",
                 .remedy = "pass the folder of the masks, or one label map"};
  std::sort(files.begin(), files.end());
  LabelLayers layers;
  layers.count = static_cast<int>(files.size());
  for (std::size_t i = 0; i < files.size(); ++i) {
    const std::string name = fs::path(files[i]).filename().string();
    layers.segments.push_back({utf8_text(name.substr(0, name.find('.'))), 1, static_cast<int>(i)});
  }
  layers.open = [files, options](int layer) {
    Result<OpenedVolume> opened = open_volume(files[static_cast<std::size_t>(layer)], options);
    if (opened)
      for (std::int16_t& v : opened.value().volume.voxels.span()) v = v > 0 ? 1 : v;
    return opened;
  };
  return layers;
}

/// Opens a file and finds its layers.
Result<LabelLayers> open_layers(const std::string& path, const OpenOptions& options) {
  const bool is_segmentation = is_dicom_segmentation(path);
  Result<OpenedVolume> first = is_segmentation ? open_dicom_segmentation(path) : open_volume(path, options);
  if (!first) return first.error();
  LabelLayers layers;
  layers.segments = first.value().segments;
  // If the caller requests one volume of the file, this volume is the only layer.
  if (options.volume == 0)
    for (const SegmentFacts& segment : layers.segments)
      layers.count = std::max(layers.count, segment.layer + 1);
  layers.first = std::move(first).value();
  layers.open = [path, options, is_segmentation, segments = layers.segments](int layer) {
    if (is_segmentation)
      return open_dicom_segmentation(path, segments[static_cast<std::size_t>(layer)].value);
    OpenOptions layer_options = options;
    layer_options.volume = layer + 1;
    return open_volume(path, layer_options);
  };
  return layers;
}

/// Maps layers onto the grid of the scan, one by one.
class LabelMapper {
 public:
  LabelMapper(const Volume& scan, std::string where)
      : scan_(&scan), where_(std::move(where)), voxel_ids_(scan.voxels.size()) {
    std::fill_n(voxel_ids_.data(), voxel_ids_.size(), std::uint16_t{0});
  }

  Status add(const Volume& grid, int layer) {
    std::map<int, int> ids_by_value;
    for (const std::int16_t v : grid.voxels.span()) {
      if (v < 0)
        return Error{.what = "a label is negative",
                     .where = where_,
                     .found = std::to_string(v),
                     .expected = "0 for the background, labels above",
                     .remedy = "check that the file is a label map and not a scan"};
      if (v == 0) continue;
      labelled_mm3 += grid.frame.voxel_mm3();
      if (!ids_by_value.contains(v)) ids_by_value[v] = ids.id_of({layer, v});
    }
    if (ids.sets().size() > 4096)
      return Error{.what = "there are too many labels",
                   .where = where_,
                   .found = std::to_string(ids.sets().size()),
                   .expected = "at most 255",
                   .remedy = "export fewer labels"};
    if (ids_by_value.empty()) return std::nullopt;
    const bool is_same = grid.size == scan_->size &&
                         max_corner_distance(grid.frame, scan_->frame, scan_->size) <= k_same_position_mm;
    is_same_grid = is_same_grid && is_same;
    last_extent = extent_text(grid);
    int last_value = 0, last_id = 0;
    std::size_t i = 0;
    for (int z = 0; z < scan_->size.z; ++z)
      for (int y = 0; y < scan_->size.y; ++y)
        for (int x = 0; x < scan_->size.x; ++x, ++i) {
          std::size_t source_index = i;
          if (!is_same) {
            const glm::ivec3 v(
                glm::floor(grid.frame.volume_from_world(scan_->frame.world_from_volume({x, y, z})) + 0.5));
            if (!grid.contains(v)) continue;
            source_index = grid.index(v.x, v.y, v.z);
          }
          const int value = grid.voxels[source_index];
          if (value == 0) continue;
          if (value != last_value) last_id = ids_by_value.at(value), last_value = value;
          std::uint16_t& voxel_id = voxel_ids_[i];
          voxel_id = static_cast<std::uint16_t>(voxel_id == 0 ? last_id : ids.overlap_of(voxel_id, last_id));
        }
    return std::nullopt;
  }

  /// Returns the labelled volume within the scan, mm3.
  double inside_mm3() const {
    const auto voxel_ids = voxel_ids_.span();
    return scan_->frame.voxel_mm3() * static_cast<double>(std::count_if(voxel_ids.begin(), voxel_ids.end(),
                                                                        [](auto id) { return id != 0; }));
  }
  /// Returns the labels of the scan's voxels.
  Buffer<std::uint8_t> apply(const Numbering& numbering) const {
    std::vector<std::uint8_t> number_of(
        ids.sets().empty() ? 1 : static_cast<std::size_t>(ids.sets().rbegin()->first) + 1, 0);
    for (const auto& [id, number] : numbering.number_of)
      number_of[static_cast<std::size_t>(id)] = static_cast<std::uint8_t>(number);
    Buffer<std::uint8_t> labels(voxel_ids_.size());
    for (std::size_t i = 0; i < labels.size(); ++i) labels[i] = number_of[voxel_ids_[i]];
    return labels;
  }

  LabelIds ids;
  double labelled_mm3 = 0;   ///< of all layers, within and outside the scan
  bool is_same_grid = true;  ///< all layers with labels have the grid of the scan
  std::string last_extent;   ///< extent of the last layer with labels, as text

 private:
  const Volume* scan_;
  std::string where_;
  Buffer<std::uint16_t> voxel_ids_;  ///< of each voxel of the scan; 0: background
};

}  // namespace

Result<ReadLabels> read_labels(const std::string& path, const Volume& scan, const OpenOptions& options) {
  const std::string where = file_name(path);
  if (std::error_code error; !fs::exists(path, error))
    return Error{.what = "the file does not exist",
                 .where = where,
                 .expected = "labels: .seg.nrrd, DICOM SEG, or any label map",
                 .remedy = "check the spelling"};
  OpenOptions label_options;
  label_options.progress = options.progress;
  label_options.spacing = options.spacing;
  label_options.axes = options.axes;
  label_options.nifti_frame = options.nifti_frame;
  label_options.volume = options.volume;
  Result<LabelLayers> layers_result =
      fs::is_directory(path) ? find_masks(path, label_options) : open_layers(path, label_options);
  if (!layers_result && layers_result.error().remedy.find("(option scale") != std::string::npos)
    return Error{.what = "the labels' numbers are too large",
                 .where = where,
                 .found = layers_result.error().found,
                 .expected = "0 to 32767",
                 .remedy = "renumber the labels"};
  if (!layers_result) return layers_result.error();
  LabelLayers layers = std::move(layers_result).value();
  ReadLabels result;
  LabelMapper mapper(scan, where);
  for (int layer = 0; layer < layers.count; ++layer) {
    Result<OpenedVolume> opened = layer == 0 && layers.first
                                      ? Result<OpenedVolume>(*std::exchange(layers.first, {}))
                                      : layers.open(layer);
    if (!opened) return opened.error();
    if (opened.value().is_rounded)
      return Error{.what = "the labels are not whole numbers",
                   .where = where,
                   .found = opened.value().notices.front(),
                   .expected = "0, 1, 2, ...",
                   .remedy = "check that the file is a label map and not a probability map or a scan"};
    for (const std::string& notice : opened.value().notices)
      if (std::find(result.notices.begin(), result.notices.end(), notice) == result.notices.end())
        result.notices.push_back(notice);
    if (Status error = mapper.add(opened.value().volume, layer)) return *error;
  }
  if (mapper.ids.sets().empty())
    return Error{.what = "the file contains no label",
                 .where = where,
                 .found = "0 everywhere",
                 .expected = "labels from 1 up",
                 .remedy = "check that it is the right file"};
  auto numbering = number_labels(mapper.ids, layers, where, result.notices);
  if (!numbering) return numbering.error();
  result.labels = mapper.apply(numbering.value());
  result.names = std::move(numbering.value().names);
  result.colours = std::move(numbering.value().colours);
  const double inside = mapper.inside_mm3(), total = mapper.labelled_mm3;
  if (inside == 0)
    return Error{.what = "the labels do not overlap the scan",
                 .where = where,
                 .found = "their grid is " + mapper.last_extent + ", the scan " + extent_text(scan),
                 .expected = "labels within the scan",
                 .remedy = "check that it is the segmentation of this scan"};
  if (!mapper.is_same_grid) {
    result.notices.push_back("the labels have another grid: resampled to the scan (nearest neighbour); " +
                             rounded_text(1e-3 * inside) + " cm3 of " + rounded_text(1e-3 * total) +
                             " are in the scan");
    if (inside < 0.8 * total)
      result.notices.emplace_back(
          "warning: a large part of the labels is outside the scan: check that they belong to it");
  }
  return result;
}

}  // namespace trephine::data_tools
