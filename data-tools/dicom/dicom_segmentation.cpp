#include "data-tools/dicom/dicom_segmentation.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>

#include "data-tools/dicom/dicom_file.h"
#include "data-tools/files/atomic_file.h"
#include "data-tools/files/words.h"
#include "data-tools/formats/reader_support.h"

namespace trephine::data_tools {

using namespace dicom_tag;

namespace {

constexpr std::string_view k_segmentation_class = "1.2.840.10008.5.1.4.1.1.66.4";
constexpr double k_position_tolerance = 0.01;  // share of the step between slices

std::optional<DicomFile> read_header(const std::string& path) {
  auto source = ByteSource::open(path);
  if (!source) return std::nullopt;
  auto read = read_dicom_file(std::move(source));
  auto* file = std::get_if<DicomFile>(&read);
  return file ? std::optional(std::move(*file)) : std::nullopt;
}

/// Returns the sRGB colour of a segment; DICOM stores CIELab under D50 light (PS3.3 C.10.7.1.1).
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
  // To linear sRGB, adapted from D50 to D65, the white point of sRGB (Bradford).
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

/// Returns a functional group of a frame, or the shared one; null if absent.
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

/// Grid of the frames; for each frame, its slice in the grid and its segment.
struct Layout {
  volume::Frame frame;
  glm::ivec3 size{0};
  std::vector<std::pair<int, int>> slice_and_segment;
};

Result<Layout> layout_of(const DicomDataSet& data, const std::string& where) {
  const auto layout_error = [&](const std::string& found) {
    return Error{.what = "the DICOM segmentation cannot be read",
                 .where = where,
                 .found = found,
                 .expected = "parallel frames on one grid, each of one segment",
                 .remedy = "export it again, or as .seg.nrrd"};
  };
  const auto count = static_cast<std::size_t>(data.number(k_frames).value_or(0));
  if (count == 0 || count > 1'000'000 || data.items(k_frame_groups).size() != count)
    return layout_error("frames without positions");
  const DicomDataSet* plane = group_of(data, 0, k_plane_orientation);
  const auto row = vector_of(plane, k_orientation), column = vector_of(plane, k_orientation, 3);
  const DicomDataSet* measures = group_of(data, 0, k_pixel_measures);
  const double row_spacing = measures ? measures->number(k_pixel_spacing, 0).value_or(0) : 0,
               column_spacing = measures ? measures->number(k_pixel_spacing, 1).value_or(0) : 0;
  if (!row || !column || !(row_spacing > 0) || !(column_spacing > 0) ||
      std::abs(glm::dot(*row, *column)) > 1e-3 || glm::length(*row) < 0.9 || glm::length(*column) < 0.9)
    return layout_error("an invalid orientation or spacing");
  const glm::dvec3 normal = glm::normalize(glm::cross(*row, *column));
  std::vector<glm::dvec3> positions;
  Layout layout;
  for (std::size_t f = 0; f < count; ++f) {
    const DicomDataSet* orientation = group_of(data, f, k_plane_orientation);
    const auto frame_row = vector_of(orientation, k_orientation),
               frame_column = vector_of(orientation, k_orientation, 3);
    const auto position = vector_of(group_of(data, f, k_plane_position), k_position);
    const DicomDataSet* segment = group_of(data, f, k_segment_identification);
    const auto number = segment ? segment->number(k_referenced_segment) : std::nullopt;
    if (!position || !number || !frame_row || !frame_column || glm::length(*frame_row - *row) > 1e-4 ||
        glm::length(*frame_column - *column) > 1e-4)
      return layout_error("frame " + std::to_string(f + 1) +
                          " has no position, no segment, or another orientation");
    positions.push_back(*position);
    layout.slice_and_segment.emplace_back(0, static_cast<int>(*number));
  }
  // A slice without any segment has no frame, so that two frames may be several slices apart. The grid
  // therefore has the smallest step between frames, or the step that the file states if the smallest step is
  // a multiple of it.
  std::vector<double> heights;
  for (const glm::dvec3& position : positions) heights.push_back(glm::dot(position, normal));
  std::sort(heights.begin(), heights.end());
  double step = 0;
  for (std::size_t i = 1; i < heights.size(); ++i)
    if (const double gap = heights[i] - heights[i - 1]; gap > 1e-3 && (step == 0 || gap < step)) step = gap;
  const double stated_step =
      measures->number(k_slice_gap).value_or(measures->number(k_slice_thickness).value_or(0));
  if (step == 0) step = stated_step > 0 ? stated_step : 1;
  if (stated_step > 0 &&
      std::abs(step / stated_step - std::floor(step / stated_step + 0.5)) < k_position_tolerance)
    step = stated_step;
  const auto lowest = std::min_element(positions.begin(), positions.end(), [&](const auto& a, const auto& b) {
    return glm::dot(a, normal) < glm::dot(b, normal);
  });
  const glm::dvec3 origin = *lowest;
  // The stack may be tilted: the positions determine its direction, which may differ from the normal.
  const auto highest = std::max_element(
      positions.begin(), positions.end(),
      [&](const auto& a, const auto& b) { return glm::dot(a, normal) < glm::dot(b, normal); });
  const double height = heights.back() - heights.front();
  const glm::dvec3 along = height > 0 ? (*highest - origin) / height : normal;
  layout.size = {static_cast<int>(data.number(k_columns).value_or(0)),
                 static_cast<int>(data.number(k_rows).value_or(0)),
                 static_cast<int>(std::floor(height / step + 0.5)) + 1};
  for (std::size_t f = 0; f < count; ++f) {
    const double z = glm::dot(positions[f] - origin, normal) / step;
    const int slice = static_cast<int>(std::floor(z + 0.5));
    if (std::abs(z - slice) > k_position_tolerance ||
        glm::length(positions[f] - origin - slice * step * along) > k_position_tolerance * step)
      return layout_error("frame " + std::to_string(f + 1) + " is between the slices of the grid");
    layout.slice_and_segment[f].first = slice;
  }
  const auto frame = volume::Frame::from_axes(
      origin,
      glm::dmat3(column_spacing * glm::normalize(*row), row_spacing * glm::normalize(*column), step * along));
  if (!frame) return layout_error("linearly dependent axes");
  layout.frame = frame.value();
  return layout;
}

}  // namespace

bool is_dicom_segmentation(const std::string& path) {
  const auto file = read_header(path);
  return file && file->data.text(k_sop_class) == k_segmentation_class;
}

Result<OpenedVolume> open_dicom_segmentation(const std::string& path, int only_segment) {
  const std::string where = file_name(path);
  const auto file = read_header(path);
  if (!file)
    return Error{.what = "the DICOM segmentation cannot be read",
                 .where = where,
                 .expected = "a complete file",
                 .remedy = "copy or export it again"};
  const DicomDataSet& data = file->data;
  const Result<Layout> layout = layout_of(data, where);
  if (!layout) return layout.error();
  const int bits = static_cast<int>(data.number(k_bits_allocated).value_or(0));
  if (file->is_encapsulated || (bits != 1 && bits != 8))
    return Error{.what = "unsupported pixel format of the segmentation",
                 .where = where,
                 .found = file->is_encapsulated ? "compressed frames" : std::to_string(bits) + " bits",
                 .expected = "plain frames of 1 or 8 bits",
                 .remedy = "write it without compression, or as .seg.nrrd"};
  const glm::ivec3& size = layout.value().size;
  Result<volume::Volume> result = allocate_volume(size, layout.value().frame, where);
  if (!result) return result.error();
  OpenedVolume opened;
  opened.volume = std::move(result).value();
  opened.format = "DICOM segmentation";
  std::fill_n(opened.volume.voxels.data(), opened.volume.voxels.size(), std::int16_t{0});
  for (const DicomDataSet& segment : data.items(k_segments)) {
    const int number = static_cast<int>(segment.number(k_segment_number).value_or(0));
    if (number > 32767)
      return Error{.what = "a segment's number is too large",
                   .where = where,
                   .found = std::to_string(number),
                   .expected = "1 to 32767",
                   .remedy = "renumber the segments"};
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
    return Error{.what = "the DICOM segmentation cannot be read",
                 .where = where,
                 .found = "only " + std::to_string(file->has_pixels ? file->pixel_bytes : 0) + " of " +
                          std::to_string(bytes) + " bytes of its pixels",
                 .expected = "a complete file",
                 .remedy = "copy or export it again"};
  const double full_value = data.number(k_max_fractional).value_or(255);
  std::int64_t overlaps = 0, partial_count = 0;
  for (std::size_t f = 0; f < frames; ++f) {
    const auto [slice, segment] = layout.value().slice_and_segment[f];
    if (only_segment > 0 && segment != only_segment) continue;
    std::int16_t* slice_voxels = opened.volume.voxels.data() + static_cast<std::size_t>(slice) * area;
    for (std::size_t i = 0; i < area; ++i) {
      const std::size_t at = f * area + i;
      bool is_in = false;
      if (bits == 1) {
        is_in = (static_cast<unsigned char>(pixels[at / 8]) >> (at % 8) & 1) != 0;
      } else {
        const double share = static_cast<unsigned char>(pixels[at]) / full_value;
        is_in = share >= 0.5;
        partial_count += share > 0 && share < 1;
      }
      if (!is_in) continue;
      overlaps += slice_voxels[i] != 0 && slice_voxels[i] != segment;
      slice_voxels[i] = static_cast<std::int16_t>(segment);
    }
  }
  if (overlaps > 0) {
    if (opened.segments.empty())
      return Error{.what = "segments overlap and have no names",
                   .where = where,
                   .found = std::to_string(overlaps) + " voxels belong to several segments",
                   .expected = "a list of segments",
                   .remedy = "export the segments again"};
    // Each segment becomes a separate layer; one call reads one layer.
    std::vector<SegmentFacts> segments = std::move(opened.segments);
    for (std::size_t i = 0; i < segments.size(); ++i) segments[i].layer = static_cast<int>(i);
    Result<OpenedVolume> first = open_dicom_segmentation(path, segments[0].value);
    if (first) first.value().segments = std::move(segments);
    return first;
  }
  if (partial_count > 0)
    opened.notices.push_back(std::to_string(partial_count) +
                             " voxels belong partly to a segment: those with a share of at least one half "
                             "were kept");
  return opened;
}

}  // namespace trephine::data_tools
