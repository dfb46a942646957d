#include "data-tools/label_file.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <glm/common.hpp>
#include <map>

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

namespace {

/// What a voxel of the scan may be: a layer and a value in it.
using Key = std::pair<int, int>;

/// Values as they are, or from 1 up without gaps when they are too large; names by key.
struct Numbering {
  std::map<Key, int> number_of;
  std::vector<std::string> names{"background"};
  std::vector<glm::u8vec3> colours;  // of none, or of all
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

/// Colours of the segments; those that say none get one of their own beside the others.
void take_colours(Numbering& numbering, const std::vector<SegmentFacts>& segments) {
  if (std::none_of(segments.begin(), segments.end(), [](const SegmentFacts& s) { return s.colour; })) return;
  for (std::size_t label = 0; label < numbering.names.size(); ++label)
    numbering.colours.emplace_back(glm::floor(255.0 * label_colour(static_cast<int>(label), {}) + 0.5));
  numbering.colours[0] = glm::u8vec3(0);
  for (const SegmentFacts& s : segments)
    if (const auto it = numbering.number_of.find({s.layer, s.value});
        s.colour && it != numbering.number_of.end())
      numbering.colours[static_cast<std::size_t>(it->second)] = *s.colour;
}

Result<Numbering> number_labels(const std::map<Key, std::int64_t>& found,
                                const std::vector<SegmentFacts>& segments, int layers,
                                const std::string& where, std::vector<std::string>& notices) {
  Numbering numbering;
  if (found.size() > 255)
    return Error{"there are too many labels", where, std::to_string(found.size()), "at most 255",
                 "export fewer of them"};
  const bool fits = layers == 1 && (found.empty() || found.rbegin()->first.second <= 255);
  if (!fits)
    notices.push_back(layers > 1 ? "labels of " + std::to_string(layers) + " layers were renumbered from 1 up"
                                 : "labels were renumbered from 1 up: values to " +
                                       std::to_string(found.rbegin()->first.second) + " occur");
  int next = 1;
  for (const auto& [key, count] : found) {
    const int number = fits ? key.second : next++;
    numbering.number_of[key] = number;
    while (static_cast<int>(numbering.names.size()) <= number) {
      std::string name = "label-";
      numbering.names.push_back(name.append(std::to_string(numbering.names.size())));
    }
    std::string name = "label-";
    name.append(std::to_string(key.second));
    for (const SegmentFacts& segment : segments)
      if (segment.layer == key.first && segment.value == key.second && !segment.name.empty())
        name = segment.name;
    // Two segments of one name stay apart.
    std::string unique = name;
    for (int k = 2;
         std::find(numbering.names.begin(), numbering.names.end(), unique) != numbering.names.end() &&
         numbering.names[static_cast<std::size_t>(number)] != unique;
         ++k)
      unique = name + "-" + std::to_string(k);
    numbering.names[static_cast<std::size_t>(number)] = unique;
  }
  take_colours(numbering, segments);
  return numbering;
}

}  // namespace

Result<ReadLabels> read_labels(const std::string& path, const Volume& scan, const OpenOptions& options) {
  const std::string where = file_name(path);
  if (std::error_code error; !std::filesystem::exists(path, error))
    return Error{"there is no such file", where, "", "labels: .seg.nrrd, DICOM SEG, or any label map",
                 "check the spelling"};
  OpenOptions plain;
  plain.progress = options.progress;
  plain.spacing = options.spacing;
  plain.axes = options.axes;
  plain.nifti_frame = options.nifti_frame;
  plain.volume = options.volume;
  Result<OpenedVolume> first =
      is_dicom_segmentation(path) ? open_dicom_segmentation(path) : open_volume(path, plain);
  if (!first && first.error().remedy.find("--scale") != std::string::npos)
    return Error{"the labels' numbers are too large", where, first.error().found, "0 to 32767",
                 "renumber the labels"};
  if (!first) return first.error();
  if (first.value().is_rounded)
    return Error{"the labels are no whole numbers", where, first.value().notices.front(), "0, 1, 2, ...",
                 "is it a label map, and no probability or scan?"};
  const std::vector<SegmentFacts> segments = first.value().segments;
  std::vector<Volume> layers;
  layers.push_back(std::move(first.value().volume));
  // Segments that overlap lie in layers; of other files the volume that was asked for is meant.
  int most_layer = 0;
  for (const SegmentFacts& segment : segments) most_layer = std::max(most_layer, segment.layer);
  for (int layer = 1; layer <= most_layer && options.volume == 0; ++layer) {
    plain.volume = layer + 1;
    Result<OpenedVolume> next = open_volume(path, plain);
    if (!next) return next.error();
    layers.push_back(std::move(next.value().volume));
  }

  ReadLabels result;
  result.notices = first.value().notices;
  const Volume& grid = layers[0];
  std::map<Key, std::int64_t> found;
  double labelled = 0;
  for (std::size_t layer = 0; layer < layers.size(); ++layer)
    for (const std::int16_t v : layers[layer].voxels.span()) {
      if (v < 0)
        return Error{"a label is negative", where, std::to_string(v), "0 for the background, labels above",
                     "is it a label map, and no scan?"};
      if (v == 0) continue;
      ++found[{static_cast<int>(layer), v}];
      labelled += grid.frame.voxel_mm3();
    }
  if (found.empty())
    return Error{"there is no label in it", where, "0 everywhere", "labels from 1 up",
                 "is it the right file?"};
  auto numbering = number_labels(found, segments, static_cast<int>(layers.size()), where, result.notices);
  if (!numbering) return numbering.error();
  result.names = std::move(numbering.value().names);
  result.colours = std::move(numbering.value().colours);

  const bool is_same_grid =
      grid.size == scan.size && farthest_corner(grid.frame, scan.frame, scan.size) <= k_same_place_mm;
  result.labels = volume::Buffer<std::uint8_t>(scan.voxels.size());
  std::int64_t overlaps = 0;
  double kept = 0;
  std::size_t i = 0;
  for (int z = 0; z < scan.size.z; ++z)
    for (int y = 0; y < scan.size.y; ++y)
      for (int x = 0; x < scan.size.x; ++x, ++i) {
        std::size_t from = i;
        if (!is_same_grid) {
          const glm::ivec3 v(
              glm::floor(grid.frame.volume_from_world(scan.frame.world_from_volume({x, y, z})) + 0.5));
          if (!grid.contains(v)) {
            result.labels[i] = 0;
            continue;
          }
          from = grid.index(v.x, v.y, v.z);
        }
        int label = 0;
        for (std::size_t layer = 0; layer < layers.size(); ++layer)
          if (const int value = layers[layer].voxels[from]; value != 0) {
            overlaps += label != 0;
            label = numbering.value().number_of.at({static_cast<int>(layer), value});
          }
        result.labels[i] = static_cast<std::uint8_t>(label);
        kept += label != 0;
      }
  kept *= scan.frame.voxel_mm3();
  if (kept == 0)
    return Error{"the labels lie elsewhere than the scan", where,
                 "their grid is " + place_of(grid) + ", the scan " + place_of(scan), "labels within the scan",
                 "is it the segmentation of this scan?"};
  if (overlaps > 0)
    return Error{"segments overlap", where, std::to_string(overlaps) + " voxels belong to several",
                 "one label a voxel",
                 "export the segments that are needed as one label map, the more important last"};
  if (!is_same_grid) {
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
