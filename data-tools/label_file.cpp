#include "data-tools/label_file.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <glm/common.hpp>
#include <map>
#include <optional>
#include <utility>

#include "data-tools/atomic_file.h"
#include "data-tools/case_folder.h"
#include "data-tools/dicom_segmentation.h"
#include "data-tools/opening.h"
#include "data-tools/words.h"
#include "data-tools/writing.h"

namespace trephine::data_tools {

using volume::Error;
using volume::Result;
using volume::Volume;

namespace fs = std::filesystem;

namespace {

/// A label of the file: a layer and a value in it.
using Key = std::pair<int, int>;

/// Segments of a file or masks of a folder, read one layer after another.
struct LabelLayers {
  int count = 1;
  std::vector<SegmentFacts> segments;
  std::function<Result<OpenedVolume>(int layer)> open;
  std::optional<OpenedVolume> first;  ///< layer 0, where finding the layers read it
};

/// Ids while layers are read: of each label of the file, and of each overlap of two ids.
class LabelIds {
 public:
  int id_of(const Key& key) {
    const auto [at, is_new] = ids_.emplace(key, next_);
    if (is_new) sets_[next_++] = {key};
    return at->second;
  }
  /// Returns the id of the voxels that belong to both.
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
  /// The labels of each id: one, or several where segments overlap.
  const std::map<int, std::vector<Key>>& sets() const { return sets_; }

 private:
  std::map<Key, int> ids_;
  std::map<std::pair<int, int>, int> overlaps_;
  std::map<int, std::vector<Key>> sets_;
  int next_ = 1;
};

/// The numbers of ids in the result, with names and colours by number.
struct Numbering {
  std::map<int, int> number_of;
  std::vector<std::string> names{"background"};
  std::vector<glm::u8vec3> colours;  ///< of all numbers, or none
};

/// "from (-120, -80, 5) to (10, 90, 140) mm"
std::string place_of(const Volume& v) {
  glm::dvec3 low(1e300), high(-1e300);
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec3 p = v.frame.world_from_volume(glm::dvec3(corner & 1, corner >> 1 & 1, corner >> 2) *
                                                   glm::dvec3(v.size - 1));
    low = glm::min(low, p);
    high = glm::max(high, p);
  }
  const auto text = [](const glm::dvec3& p) {
    std::string one = "(";
    return one.append(short_number(p.x))
        .append(", ")
        .append(short_number(p.y))
        .append(", ")
        .append(short_number(p.z))
        .append(")");
  };
  return "from " + text(low) + " to " + text(high) + " mm";
}

const SegmentFacts* segment_of(const std::vector<SegmentFacts>& segments, const Key& key) {
  for (const SegmentFacts& s : segments)
    if (s.layer == key.first && s.value == key.second) return &s;
  return nullptr;
}

/// Sets the colours of the segments; segments without one get the usual colour of their number.
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

/// Values as they are where one layer holds them all and none exceeds 255; else numbers from 1 up, overlaps
/// last. An overlap is named "first+second".
Result<Numbering> number_labels(const LabelIds& ids, const LabelLayers& layers, const std::string& where,
                                std::vector<std::string>& notices) {
  Numbering numbering;
  if (ids.sets().size() > 255)
    return Error{"there are too many labels", where, std::to_string(ids.sets().size()), "at most 255",
                 "export fewer of them"};
  std::vector<std::pair<std::vector<Key>, int>> order;  // labels, then overlaps
  int most = 0;
  std::size_t overlaps = 0;
  for (const auto& [id, keys] : ids.sets()) {
    order.emplace_back(keys, id);
    overlaps += keys.size() > 1;
    for (const Key& key : keys) most = std::max(most, key.second);
  }
  std::sort(order.begin(), order.end(), [](const auto& a, const auto& b) {
    return a.first.size() != b.first.size() ? a.first.size() < b.first.size() : a.first < b.first;
  });
  const bool keeps_values = layers.count == 1 && overlaps == 0 && most <= 255;
  if (layers.count == 1 && !keeps_values)
    notices.push_back("labels were renumbered from 1 up: values to " + std::to_string(most) + " occur");
  else if (!keeps_values)
    notices.push_back("labels of " + std::to_string(layers.count) + " layers were renumbered from 1 up");
  if (overlaps > 0)
    notices.push_back("segments overlap: " + counted(overlaps, "label") +
                      " of the voxels that belong to several, named \"first+second\"");
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
    // Two segments of one name stay apart.
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

/// The masks of a folder, one structure a file, as TotalSegmentator writes them.
Result<LabelLayers> masks_of(const std::string& path, const OpenOptions& options) {
  std::vector<std::string> files;
  std::error_code failed;
  for (fs::directory_iterator at(path, failed), end; !failed && at != end; at.increment(failed)) {
    const std::string file = at->path().string();
    for (const char* extension : {".nii.gz", ".nii", ".nrrd", ".mha"})
      if (has_extension(file, extension) && !has_extension(file, ".seg.nrrd")) files.push_back(file);
  }
  if (files.empty())
    return Error{"the folder holds no masks", file_name(path), "",
                 "files .nii.gz, .nrrd or .mha, one a structure",
                 "name the folder of the masks, or one label map"};
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

/// The layers of one file.
Result<LabelLayers> layers_of(const std::string& path, const OpenOptions& options) {
  const bool is_segmentation = is_dicom_segmentation(path);
  Result<OpenedVolume> first = is_segmentation ? open_dicom_segmentation(path) : open_volume(path, options);
  if (!first) return first.error();
  LabelLayers layers;
  layers.segments = first.value().segments;
  // A chosen volume of the file is the only one to read.
  if (options.volume == 0)
    for (const SegmentFacts& segment : layers.segments)
      layers.count = std::max(layers.count, segment.layer + 1);
  layers.first = std::move(first).value();
  layers.open = [path, options, is_segmentation, segments = layers.segments](int layer) {
    if (is_segmentation)
      return open_dicom_segmentation(path, segments[static_cast<std::size_t>(layer)].value);
    OpenOptions one = options;
    one.volume = layer + 1;
    return open_volume(path, one);
  };
  return layers;
}

/// Puts one layer after another onto the grid of the scan.
class LabelMapper {
 public:
  LabelMapper(const Volume& scan, std::string where)
      : scan_(&scan), where_(std::move(where)), ids_of_(scan.voxels.size()) {
    std::fill_n(ids_of_.data(), ids_of_.size(), std::uint16_t{0});
  }

  volume::Status add(const Volume& grid, int layer) {
    std::map<int, int> id_of;
    for (const std::int16_t v : grid.voxels.span()) {
      if (v < 0)
        return Error{"a label is negative", where_, std::to_string(v), "0 for the background, labels above",
                     "is it a label map, and no scan?"};
      if (v == 0) continue;
      labelled_mm3 += grid.frame.voxel_mm3();
      if (!id_of.contains(v)) id_of[v] = ids.id_of({layer, v});
    }
    if (ids.sets().size() > 4096)
      return Error{"there are too many labels", where_, std::to_string(ids.sets().size()), "at most 255",
                   "export fewer of them"};
    if (id_of.empty()) return std::nullopt;
    const bool is_same =
        grid.size == scan_->size && farthest_corner(grid.frame, scan_->frame, scan_->size) <= k_same_place_mm;
    is_same_grid = is_same_grid && is_same;
    place = place_of(grid);
    int last_value = 0, last_id = 0;
    std::size_t i = 0;
    for (int z = 0; z < scan_->size.z; ++z)
      for (int y = 0; y < scan_->size.y; ++y)
        for (int x = 0; x < scan_->size.x; ++x, ++i) {
          std::size_t from = i;
          if (!is_same) {
            const glm::ivec3 v(
                glm::floor(grid.frame.volume_from_world(scan_->frame.world_from_volume({x, y, z})) + 0.5));
            if (!grid.contains(v)) continue;
            from = grid.index(v.x, v.y, v.z);
          }
          const int value = grid.voxels[from];
          if (value == 0) continue;
          if (value != last_value) last_id = id_of.at(value), last_value = value;
          std::uint16_t& to = ids_of_[i];
          to = static_cast<std::uint16_t>(to == 0 ? last_id : ids.overlap_of(to, last_id));
        }
    return std::nullopt;
  }

  /// mm3 that lie in the scan.
  double kept_mm3() const {
    const auto all = ids_of_.span();
    return scan_->frame.voxel_mm3() *
           static_cast<double>(std::count_if(all.begin(), all.end(), [](auto id) { return id != 0; }));
  }
  volume::Buffer<std::uint8_t> numbered(const Numbering& numbering) const {
    std::vector<std::uint8_t> number_of(ids.sets().empty() ? 1 : ids.sets().rbegin()->first + 1u, 0);
    for (const auto& [id, number] : numbering.number_of)
      number_of[static_cast<std::size_t>(id)] = static_cast<std::uint8_t>(number);
    volume::Buffer<std::uint8_t> labels(ids_of_.size());
    for (std::size_t i = 0; i < labels.size(); ++i) labels[i] = number_of[ids_of_[i]];
    return labels;
  }

  LabelIds ids;
  double labelled_mm3 = 0;  ///< of all layers, within the scan or not
  bool is_same_grid = true;
  std::string place;  ///< of the last grid, in words

 private:
  const Volume* scan_;
  std::string where_;
  volume::Buffer<std::uint16_t> ids_of_;  ///< of each voxel of the scan; 0: none
};

}  // namespace

Result<ReadLabels> read_labels(const std::string& path, const Volume& scan, const OpenOptions& options) {
  const std::string where = file_name(path);
  if (std::error_code error; !fs::exists(path, error))
    return Error{"there is no such file", where, "", "labels: .seg.nrrd, DICOM SEG, or any label map",
                 "check the spelling"};
  OpenOptions plain;
  plain.progress = options.progress;
  plain.spacing = options.spacing;
  plain.axes = options.axes;
  plain.nifti_frame = options.nifti_frame;
  plain.volume = options.volume;
  Result<LabelLayers> found = fs::is_directory(path) ? masks_of(path, plain) : layers_of(path, plain);
  if (!found && found.error().remedy.find("--scale") != std::string::npos)
    return Error{"the labels' numbers are too large", where, found.error().found, "0 to 32767",
                 "renumber the labels"};
  if (!found) return found.error();
  LabelLayers layers = std::move(found).value();
  ReadLabels result;
  LabelMapper mapper(scan, where);
  for (int layer = 0; layer < layers.count; ++layer) {
    Result<OpenedVolume> opened = layer == 0 && layers.first
                                      ? Result<OpenedVolume>(*std::exchange(layers.first, {}))
                                      : layers.open(layer);
    if (!opened) return opened.error();
    if (opened.value().is_rounded)
      return Error{"the labels are no whole numbers", where, opened.value().notices.front(), "0, 1, 2, ...",
                   "is it a label map, and no probability or scan?"};
    for (const std::string& notice : opened.value().notices)
      if (std::find(result.notices.begin(), result.notices.end(), notice) == result.notices.end())
        result.notices.push_back(notice);
    if (volume::Status error = mapper.add(opened.value().volume, layer)) return *error;
  }
  if (mapper.ids.sets().empty())
    return Error{"there is no label in it", where, "0 everywhere", "labels from 1 up",
                 "is it the right file?"};
  auto numbering = number_labels(mapper.ids, layers, where, result.notices);
  if (!numbering) return numbering.error();
  result.labels = mapper.numbered(numbering.value());
  result.names = std::move(numbering.value().names);
  result.colours = std::move(numbering.value().colours);
  const double kept = mapper.kept_mm3(), labelled = mapper.labelled_mm3;
  if (kept == 0)
    return Error{"the labels lie elsewhere than the scan", where,
                 "their grid is " + mapper.place + ", the scan " + place_of(scan), "labels within the scan",
                 "is it the segmentation of this scan?"};
  if (!mapper.is_same_grid) {
    result.notices.push_back("the labels lie on a grid of their own: brought to the scan's, nearest; " +
                             short_number(1e-3 * kept) + " cm3 of " + short_number(1e-3 * labelled) +
                             " lie in the scan");
    if (kept < 0.8 * labelled)
      result.notices.emplace_back(
          "warning: a good part of the labels lies outside of the scan: are they of it?");
  }
  return result;
}

}  // namespace trephine::data_tools
