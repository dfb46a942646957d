#include "data-tools/dicom_segmentation.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>

#include "data-tools/atomic_file.h"
#include "data-tools/dicom_file.h"
#include "data-tools/opening.h"
#include "data-tools/words.h"

namespace trephine::data_tools {

using namespace dicom_tag;
using volume::Error;
using volume::Result;

namespace {

constexpr std::string_view k_segmentation_class = "1.2.840.10008.5.1.4.1.1.66.4";
constexpr double k_same_place = 0.01;  // of a step between slices

std::optional<DicomFile> read_head(const std::string& path) {
  auto source = ByteSource::open(path);
  if (!source) return std::nullopt;
  auto read = read_dicom_file(std::move(source));
  auto* file = std::get_if<DicomFile>(&read);
  return file ? std::optional(std::move(*file)) : std::nullopt;
}

/// A colour that DICOM gives as CIELab under D50 light (PS3.3 C.10.7.1.1), in sRGB.
std::optional<glm::u8vec3> colour_of(const DicomDataSet& segment) {
  glm::dvec3 stored;
  for (std::size_t a = 0; a < 3; ++a) {
    const auto number = segment.number(k_cielab, a);
    if (!number || !(*number >= 0 && *number <= 65535)) return std::nullopt;
    stored[static_cast<int>(a)] = *number / 65535;
  }
  const double light = 100 * stored.x, a = 255 * stored.y - 128, b = 255 * stored.z - 128;
  const auto linear = [](double f) { return f > 6.0 / 29 ? f * f * f : (f - 4.0 / 29) * 108 / 841; };
  const double fy = (light + 16) / 116;
  const glm::dvec3 xyz(0.9642 * linear(fy + a / 500), linear(fy), 0.8249 * linear(fy - b / 200));
  // To sRGB's primaries, with D50 brought to its D65 (Bradford).
  const glm::dvec3 rgb(glm::dot(xyz, {3.1338561, -1.6168667, -0.4906146}),
                       glm::dot(xyz, {-0.9787684, 1.9161415, 0.0334540}),
                       glm::dot(xyz, {0.0719453, -0.2289914, 1.4052427}));
  glm::u8vec3 colour;
  for (int c = 0; c < 3; ++c) {
    const double v = std::clamp(rgb[c], 0.0, 1.0);
    const double encoded = v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1 / 2.4) - 0.055;
    colour[c] = static_cast<std::uint8_t>(std::floor(255 * encoded + 0.5));
  }
  return colour;
}

/// An item of functional groups that a frame has, or all share.
const DicomDataSet* group_of(const DicomDataSet& data, std::size_t frame, DicomTag group) {
  const auto& frames = data.items(k_frame_groups);
  if (frame < frames.size() && !frames[frame].items(group).empty()) return &frames[frame].items(group)[0];
  const auto& shared = data.items(k_shared_groups);
  return !shared.empty() && !shared[0].items(group).empty() ? &shared[0].items(group)[0] : nullptr;
}

std::optional<glm::dvec3> vector_of(const DicomDataSet* set, DicomTag tag, std::size_t first = 0) {
  glm::dvec3 v;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto number = set ? set->number(tag, first + i) : std::nullopt;
    if (!number || !std::isfinite(*number)) return std::nullopt;
    v[static_cast<int>(i)] = *number;
  }
  return v;
}

/// Position of the frames: a slice of the grid, and a segment.
struct Layout {
  volume::Frame frame;
  glm::ivec3 size{0};
  std::vector<std::pair<int, int>> slice_and_segment;
};

Result<Layout> layout_of(const DicomDataSet& data, const std::string& where) {
  const auto broken = [&](const std::string& found) {
    return Error{"the DICOM segmentation cannot be read", where, found,
                 "frames that lie parallel on one grid, each of one segment",
                 "export it again, or as .seg.nrrd"};
  };
  const auto count = static_cast<std::size_t>(data.number(k_frames).value_or(0));
  if (count == 0 || count > 1'000'000 || data.items(k_frame_groups).size() != count)
    return broken("frames without their places");
  const DicomDataSet* plane = group_of(data, 0, k_plane_orientation);
  const auto row = vector_of(plane, k_orientation), column = vector_of(plane, k_orientation, 3);
  const DicomDataSet* measures = group_of(data, 0, k_pixel_measures);
  const double row_spacing = measures ? measures->number(k_pixel_spacing, 0).value_or(0) : 0,
               column_spacing = measures ? measures->number(k_pixel_spacing, 1).value_or(0) : 0;
  if (!row || !column || !(row_spacing > 0) || !(column_spacing > 0) ||
      std::abs(glm::dot(*row, *column)) > 1e-3 || glm::length(*row) < 0.9 || glm::length(*column) < 0.9)
    return broken("no orientation or spacing that makes sense");
  const glm::dvec3 normal = glm::normalize(glm::cross(*row, *column));
  std::vector<glm::dvec3> places;
  Layout layout;
  for (std::size_t f = 0; f < count; ++f) {
    const DicomDataSet* orientation = group_of(data, f, k_plane_orientation);
    const auto its_row = vector_of(orientation, k_orientation),
               its_column = vector_of(orientation, k_orientation, 3);
    const auto place = vector_of(group_of(data, f, k_plane_position), k_position);
    const DicomDataSet* segment = group_of(data, f, k_segment_identification);
    const auto number = segment ? segment->number(k_referenced_segment) : std::nullopt;
    if (!place || !number || !its_row || !its_column || glm::length(*its_row - *row) > 1e-4 ||
        glm::length(*its_column - *column) > 1e-4)
      return broken("frame " + std::to_string(f + 1) + " without a place or a segment");
    places.push_back(*place);
    layout.slice_and_segment.emplace_back(0, static_cast<int>(*number));
  }
  // Slices without a segment have no frame: the smallest step is the grid's, unless it is said.
  std::vector<double> heights;
  for (const glm::dvec3& place : places) heights.push_back(glm::dot(place, normal));
  std::sort(heights.begin(), heights.end());
  double step = 0;
  for (std::size_t i = 1; i < heights.size(); ++i)
    if (const double gap = heights[i] - heights[i - 1]; gap > 1e-3 && (step == 0 || gap < step)) step = gap;
  const double said = measures->number(k_slice_gap).value_or(measures->number(k_slice_thickness).value_or(0));
  if (step == 0) step = said > 0 ? said : 1;
  if (said > 0 && std::abs(step / said - std::floor(step / said + 0.5)) < k_same_place) step = said;
  const auto lowest = std::min_element(places.begin(), places.end(), [&](const auto& a, const auto& b) {
    return glm::dot(a, normal) < glm::dot(b, normal);
  });
  const glm::dvec3 origin = *lowest;
  // A stack may lean: its own direction, not the normal.
  const auto highest = std::max_element(places.begin(), places.end(), [&](const auto& a, const auto& b) {
    return glm::dot(a, normal) < glm::dot(b, normal);
  });
  const double height = heights.back() - heights.front();
  const glm::dvec3 along = height > 0 ? (*highest - origin) / height : normal;
  layout.size = {static_cast<int>(data.number(k_columns).value_or(0)),
                 static_cast<int>(data.number(k_rows).value_or(0)),
                 static_cast<int>(std::floor(height / step + 0.5)) + 1};
  for (std::size_t f = 0; f < count; ++f) {
    const double z = glm::dot(places[f] - origin, normal) / step;
    const int slice = static_cast<int>(std::floor(z + 0.5));
    if (std::abs(z - slice) > k_same_place ||
        glm::length(places[f] - origin - slice * step * along) > k_same_place * step)
      return broken("frame " + std::to_string(f + 1) + " between the slices of the others");
    layout.slice_and_segment[f].first = slice;
  }
  const auto frame = volume::Frame::from_axes(
      origin,
      glm::dmat3(column_spacing * glm::normalize(*row), row_spacing * glm::normalize(*column), step * along));
  if (!frame) return broken("axes that span no volume");
  layout.frame = frame.value();
  return layout;
}

}  // namespace

bool is_dicom_segmentation(const std::string& path) {
  const auto file = read_head(path);
  return file && file->data.text(k_sop_class) == k_segmentation_class;
}

Result<OpenedVolume> open_dicom_segmentation(const std::string& path, int only_segment) {
  const std::string where = file_name(path);
  const auto file = read_head(path);
  if (!file) return Error{"the DICOM segmentation cannot be read", where, "", "a whole file", ""};
  const DicomDataSet& data = file->data;
  const Result<Layout> layout = layout_of(data, where);
  if (!layout) return layout.error();
  const int bits = static_cast<int>(data.number(k_bits_allocated).value_or(0));
  if (file->is_encapsulated || (bits != 1 && bits != 8))
    return Error{"the segmentation's pixels are packed in a way that is not read", where,
                 file->is_encapsulated ? "compressed frames" : std::to_string(bits) + " bits",
                 "plain frames of 1 or 8 bits", "write it without compression, or as .seg.nrrd"};
  const glm::ivec3& size = layout.value().size;
  Result<volume::Volume> made = make_room(size, layout.value().frame, where);
  if (!made) return made.error();
  OpenedVolume opened;
  opened.volume = std::move(made).value();
  opened.format = "DICOM segmentation";
  std::fill_n(opened.volume.voxels.data(), opened.volume.voxels.size(), std::int16_t{0});
  for (const DicomDataSet& segment : data.items(k_segments)) {
    const int number = static_cast<int>(segment.number(k_segment_number).value_or(0));
    if (number > 32767)
      return Error{"a segment's number is too large", where, std::to_string(number), "1 to 32767",
                   "renumber the segments"};
    if (number > 0)
      opened.segments.push_back(
          {utf8_text(std::string(segment.text(k_segment_label))), number, 0, colour_of(segment)});
  }
  const std::size_t area = static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y),
                    frames = layout.value().slice_and_segment.size();
  const std::size_t bytes = bits == 1 ? (area * frames + 7) / 8 : area * frames;
  std::string pixels(bytes, '\0');
  if (!file->has_pixels || file->pixel_bytes < bytes ||
      !read_pixel_bytes(*file, *file->source, 0, pixels.data(), bytes))
    return Error{"the DICOM segmentation cannot be read", where,
                 "only " + std::to_string(file->has_pixels ? file->pixel_bytes : 0) + " of " +
                     std::to_string(bytes) + " bytes of its pixels",
                 "a whole file", "copy or export it again"};
  const double most = data.number(k_most_fractional).value_or(255);
  std::int64_t overlaps = 0, parts = 0;
  for (std::size_t f = 0; f < frames; ++f) {
    const auto [slice, segment] = layout.value().slice_and_segment[f];
    if (only_segment > 0 && segment != only_segment) continue;
    std::int16_t* to = opened.volume.voxels.data() + static_cast<std::size_t>(slice) * area;
    for (std::size_t i = 0; i < area; ++i) {
      const std::size_t at = f * area + i;
      bool is_in = false;
      if (bits == 1) {
        is_in = (static_cast<unsigned char>(pixels[at / 8]) >> (at % 8) & 1) != 0;
      } else {
        const double share = static_cast<unsigned char>(pixels[at]) / most;
        is_in = share >= 0.5;
        parts += share > 0 && share < 1;
      }
      if (!is_in) continue;
      overlaps += to[i] != 0 && to[i] != segment;
      to[i] = static_cast<std::int16_t>(segment);
    }
  }
  if (overlaps > 0) {
    if (opened.segments.empty())
      return Error{"segments overlap, and the file names none of them", where,
                   std::to_string(overlaps) + " voxels belong to several", "a list of segments",
                   "export the segments again"};
    // Each segment is a layer of its own then, to be read one by one.
    std::vector<SegmentFacts> segments = std::move(opened.segments);
    for (std::size_t i = 0; i < segments.size(); ++i) segments[i].layer = static_cast<int>(i);
    Result<OpenedVolume> first = open_dicom_segmentation(path, segments[0].value);
    if (first) first.value().segments = std::move(segments);
    return first;
  }
  if (parts > 0)
    opened.notices.push_back(std::to_string(parts) +
                             " voxels belong to their segment in part: those from a half up were taken");
  return opened;
}

}  // namespace trephine::data_tools
