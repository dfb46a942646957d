// Rays of DirectImage: visible ranges of a ray, and the matter along them.
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>

#include "volume/base/parallel.h"
#include "volume/cuts/operated_volume.h"
#include "volume/imaging/direct_image.h"

namespace trephine::volume {

using glm::dvec3;
using glm::ivec3;
using glm::vec3;

namespace {

constexpr float k_full = 0.995F;  // opacity at which a ray ends
constexpr int k_task_rows = 16;   // rows of pixels per task of a thread

}  // namespace

std::size_t DirectImage::entry_of(float value) noexcept {
  return static_cast<std::size_t>(static_cast<int>(value + (0.5F - k_lowest)));
}

DirectImage::Layer DirectImage::layer_of(float first, float second) const noexcept {
  const std::size_t i = entry_of(first), k = entry_of(second);
  // Values so near to each other need no integral.
  constexpr std::size_t k_near = 3;
  if (i - k + k_near <= 2 * k_near) return {table_[(i + k) / 2], 0.5F};
  if (!is_visible(static_cast<int>(std::min(i, k)) + k_lowest, static_cast<int>(std::max(i, k)) + k_lowest))
    return {};
  // Integrals from the lowest value: attenuation times colour, attenuation, and attenuation times value.
  const double low = static_cast<double>(first) + 0.5 - k_lowest,
               high = static_cast<double>(second) + 0.5 - k_lowest;
  const auto integral = [this](std::size_t n, double value) {
    const double share = value - static_cast<double>(n);
    std::array<double, 5> result = sums_[n];
    const double attenuation = share * static_cast<double>(table_[n][3]);
    for (std::size_t c = 0; c < 4; ++c)
      result[c] += attenuation * (c < 3 ? static_cast<double>(table_[n][c]) : 1.0);
    result[4] += attenuation * (static_cast<double>(n) + 0.5 * share);
    return result;
  };
  const std::array<double, 5> from = integral(i, low), to = integral(k, high);
  const double matter = to[3] - from[3];
  if (matter == 0) return {};
  const double change = high - low, middle = (to[4] - from[4]) / matter;
  return {{static_cast<float>((to[0] - from[0]) / matter), static_cast<float>((to[1] - from[1]) / matter),
           static_cast<float>((to[2] - from[2]) / matter), static_cast<float>(matter / change)},
          static_cast<float>(std::clamp((middle - low) / change, 0.0, 1.0))};
}

float DirectImage::opacity_of(float depth) const noexcept {
  const float scaled = depth * k_exp_per_unit;
  const auto n = static_cast<std::size_t>(scaled);
  if (n + 1 >= transmissions_.size()) return 1;
  const float rest = (scaled - static_cast<float>(n)) / k_exp_per_unit;
  return 1 - transmissions_[n] * (1 - rest * (1 - 0.5F * rest));
}

/// Data common to the rays of one image.
struct DirectImage::Cast {
  const DirectImage& image;
  const Volume& scan;
  const Version& version;
  const RaycastRequest& request;
  double step;                // mm
  double edge_mm;             // half width of the soft edge of a cut
  glm::dmat3 gradient_world;  // converts a gradient from per voxel to per mm
  bool has_labels;
  double face_depth;  // mm along the ray; matter up to this depth behind an opening is shaded as its face
  double fade_mm;     // length along a ray over which the weight of a gradient decays to about 1 / e
  const std::int16_t* voxels;
  ivec3 last_cell;                        // highest first voxel of a cell
  std::ptrdiff_t row, slice;              // strides along y and z
  std::ptrdiff_t next_x, next_y, next_z;  // strides inside a cell; 0 along an axis with one voxel

  /// Trilinear value of the scan; p is clamped to the outermost voxels.
  float scan_value(const vec3& p) const noexcept {
    const int x = std::clamp(static_cast<int>(p.x), 0, last_cell.x),
              y = std::clamp(static_cast<int>(p.y), 0, last_cell.y),
              z = std::clamp(static_cast<int>(p.z), 0, last_cell.z);
    const float fx = std::clamp(p.x - static_cast<float>(x), 0.0F, 1.0F),
                fy = std::clamp(p.y - static_cast<float>(y), 0.0F, 1.0F),
                fz = std::clamp(p.z - static_cast<float>(z), 0.0F, 1.0F);
    const std::int16_t* c = voxels + x + row * y + slice * z;
    const auto along_x = [fx, next = next_x](const std::int16_t* from) {
      const auto a = static_cast<float>(from[0]), b = static_cast<float>(from[next]);
      return a + fx * (b - a);
    };
    const float a = along_x(c), b = along_x(c + next_y), d = along_x(c + next_z),
                e = along_x(c + next_y + next_z);
    const float low = a + fy * (b - a), high = d + fy * (e - d);
    return low + fz * (high - low);
  }
  float value(const vec3& p, bool is_cut) const noexcept {
    const float uncut = scan_value(p);
    if (!is_cut || !version.is_near_cut(dvec3(p))) return uncut;
    const auto kept =
        static_cast<float>(std::clamp(0.5 + 0.5 * version.distance(dvec3(p)) / edge_mm, 0.0, 1.0));
    return image.air_ + kept * (uncut - image.air_);
  }
  /// Gradient of the values, per mm, world.
  vec3 gradient(const vec3& p, bool is_cut) const noexcept {
    constexpr float h = 0.6F;  // voxels
    const vec3 by_voxels(value(p + vec3(h, 0, 0), is_cut) - value(p - vec3(h, 0, 0), is_cut),
                         value(p + vec3(0, h, 0), is_cut) - value(p - vec3(0, h, 0), is_cut),
                         value(p + vec3(0, 0, h), is_cut) - value(p - vec3(0, 0, h), is_cut));
    return vec3(gradient_world * dvec3(by_voxels));
  }
  /// Brightness of a surface with normal n: constant, diffuse, viewer-facing and specular terms.
  static float shade(const vec3& n, const vec3& toward_camera, const vec3& toward_lamp) noexcept {
    const float front = std::max(0.0F, glm::dot(n, toward_lamp)), facing = glm::dot(n, toward_camera);
    const float half = std::max(0.0F, glm::dot(n, glm::normalize(toward_camera + toward_lamp)));
    float shine = half * half;
    shine *= shine, shine *= shine, shine *= shine;  // ^16
    return 0.22F + 0.5F * front + 0.28F * facing + 0.18F * shine;
  }

  /// Range of a ray, mm from its origin; empty if from >= to.
  struct Range {
    double from, to;
  };
  /// Face at which an opening cuts matter. Layers before `end` are shaded with its normal.
  struct Face {
    double end = -1;  // mm along the ray; below 0: no face
    vec3 normal{0};
  };
  /// Ray, and its image so far.
  struct Progress {
    Camera::Ray ray;
    dvec3 from, along;  // volume frame
    vec3 toward_camera, toward_lamp;
    DirectPixel pixel;
    Counters* count;
    vec3 gradient{0};        // sum of the gradients so far, whose weights decay over fade_mm
    double measured_at = 0;  // position of the last gradient, mm along the ray
    bool is_opaque() const noexcept { return pixel.opacity > k_full; }
  };

  /// Returns the range of a ray inside a tube with round ends. The tube is convex, so this is the hull of the
  /// ranges in its two balls and its cylinder.
  static Range range_in(const Openings::Tube& tube, const Camera::Ray& ray) noexcept {
    Range hull{1e300, -1e300};
    const auto add = [&](double from, double to) {
      if (from < to) hull = {std::min(hull.from, from), std::max(hull.to, to)};
    };
    for (const dvec3& centre : {tube.from, tube.to}) {
      const dvec3 offset = ray.from - centre;
      const double b = glm::dot(offset, ray.along),
                   square = b * b - glm::dot(offset, offset) + tube.radius * tube.radius;
      if (square > 0) add(-b - std::sqrt(square), -b + std::sqrt(square));
    }
    const dvec3 axis = tube.to - tube.from, offset = ray.from - tube.from;
    const double length = glm::length(axis);
    if (!(length > 0)) return hull;
    const dvec3 unit = axis / length;
    const double rise = glm::dot(ray.along, unit), start = glm::dot(offset, unit);
    const dvec3 radial = offset - start * unit, across = ray.along - rise * unit;
    double from = -1e300, to = 1e300;
    const double a = glm::dot(across, across), b = glm::dot(radial, across),
                 c = glm::dot(radial, radial) - tube.radius * tube.radius;
    if (a > 1e-18) {
      const double square = b * b - a * c;
      if (!(square > 0)) return hull;
      from = (-b - std::sqrt(square)) / a, to = (-b + std::sqrt(square)) / a;
    } else if (c > 0) {
      return hull;
    }
    if (std::abs(rise) > 1e-12) {
      const double t0 = -start / rise, t1 = (length - start) / rise;
      from = std::max(from, std::min(t0, t1)), to = std::min(to, std::max(t0, t1));
    } else if (start < 0 || start > length) {
      return hull;
    }
    add(from, to);
    return hull;
  }
  /// Normal of a tube's surface at `world`, toward its axis.
  static vec3 normal_of(const Openings::Tube& tube, const dvec3& world) noexcept {
    const dvec3 axis = tube.to - tube.from, offset = world - tube.from;
    const double size = glm::dot(axis, axis);
    const double share = size > 0 ? std::clamp(glm::dot(offset, axis) / size, 0.0, 1.0) : 0.0;
    return vec3(glm::normalize(share * axis - offset));
  }

  /// Index of the block of voxel v.
  std::size_t block_of(const ivec3& v) const noexcept {
    const ivec3 block = v >> 3;
    return static_cast<std::size_t>(block.x + image.blocks_.x * block.y) +
           static_cast<std::size_t>(image.blocks_.x * image.blocks_.y) * static_cast<std::size_t>(block.z);
  }
  /// Lowest voxel of the cell that contains p, clamped to the scan. Truncation rounds toward 0, which maps
  /// positions between -1 and 0 to voxel 0.
  ivec3 cell_of(const dvec3& p) const noexcept { return glm::clamp(ivec3(p), ivec3(0), scan.size - 1); }
  vec3 clamped(const dvec3& p) const noexcept { return glm::clamp(vec3(p), vec3(0), vec3(scan.size - 1)); }
  float value_at(const dvec3& p) const noexcept {
    return value(clamped(p), image.is_cut_[block_of(cell_of(p))] != 0);
  }

  /// Brightness of the layer at p, `at` mm along the ray, 0.22 to 1.2, from the gradients at p and before it
  /// on the ray. The gradient at p alone vanishes inside uniform bone, and the depth at which it vanishes
  /// would be visible as rings.
  float brightness(const dvec3& p, double at, Progress& progress) const noexcept;
  /// Renders pixel (i, j). `obstacle`: distance along the ray to the first opaque object, mm.
  DirectPixel cast(int i, int j, double obstacle, Counters& count) const noexcept;
  /// Adds the matter of a visible range. `face`: face at the start of the range, if an opening begins there.
  void march(const Range& range, Face face, Progress& progress) const noexcept;
  /// Adds the layer in `range`, between two samples with the values `first` and `second`.
  void add_layer(const Range& range, float first, float second, const Face& face,
                 Progress& progress) const noexcept;
};

float DirectImage::Cast::brightness(const dvec3& p, double at, Progress& progress) const noexcept {
  vec3 g = gradient(clamped(p), image.is_cut_[block_of(cell_of(p))] != 0);
  if (glm::dot(g, progress.gradient) < 0) g = -g;  // gradients on both sides of a wall must not cancel
  const auto passed = static_cast<float>((at - progress.measured_at) / fade_mm);
  progress.measured_at = at;
  progress.gradient = g + progress.gradient / (1 + passed + 0.5F * passed * passed);  // about e^-passed
  const float size = std::sqrt(glm::dot(progress.gradient, progress.gradient));
  if (!(size > 1)) return 0.7F;
  const vec3 n = progress.gradient / -size;  // points out of the denser matter
  return shade(glm::dot(n, progress.toward_camera) < 0 ? -n : n, progress.toward_camera,
               progress.toward_lamp);
}

DirectPixel DirectImage::Cast::cast(int i, int j, double obstacle, Counters& count) const noexcept {
  Progress progress{.ray = request.camera.ray(i, j),
                    .from = {},
                    .along = {},
                    .toward_camera = {},
                    .toward_lamp = vec3(glm::normalize(-request.camera.forward + 0.45 * request.camera.up -
                                                       0.35 * request.camera.right())),
                    .pixel = {},
                    .count = &count};
  const Camera::Ray& ray = progress.ray;
  progress.from = scan.frame.volume_from_world(ray.from);
  progress.along = scan.frame.vector_volume_from_world(ray.along);
  progress.toward_camera = vec3(-ray.along);
  // Clips the ray to the scan, to half a voxel beyond the outermost voxel centres.
  double enter = 0, leave = obstacle;
  for (int a = 0; a < 3; ++a) {
    const double low = -0.5, high = scan.size[a] - 0.5, start = progress.from[a], slope = progress.along[a];
    if (std::abs(slope) < 1e-12) {
      if (start < low || start > high) return {};
      continue;
    }
    const double t0 = (low - start) / slope, t1 = (high - start) / slope;
    enter = std::max(enter, std::min(t0, t1)), leave = std::min(leave, std::max(t0, t1));
  }
  Face face;
  // Clips the ray at the plane of the openings.
  if (request.openings.plane) {
    const Openings::Plane& plane = *request.openings.plane;
    const double height = glm::dot(ray.from - plane.at, plane.normal),
                 rise = glm::dot(ray.along, plane.normal);
    if (std::abs(rise) > 1e-12) {
      const double crossing = -height / rise;
      if (rise < 0 && crossing > enter) face = {crossing + face_depth, vec3(plane.normal)};
      rise < 0 ? enter = std::max(enter, crossing) : leave = std::min(leave, crossing);
    } else if (height > 0) {
      return {};
    }
  }
  ++count.rays;
  // Adds the visible ranges between the tubes.
  while (enter < leave && !progress.is_opaque()) {
    double end = leave;
    bool is_hidden = false;
    for (const Openings::Tube& tube : request.openings.tubes) {
      const Range hidden = range_in(tube, ray);
      if (hidden.from <= enter && enter < hidden.to) {
        enter = hidden.to;
        face = {enter + face_depth, normal_of(tube, ray.from + enter * ray.along)};
        is_hidden = true;
      } else if (hidden.from > enter && hidden.from < hidden.to) {
        end = std::min(end, hidden.from);
      }
    }
    if (is_hidden) continue;
    march({enter, end}, face, progress);
    enter = end, face = {};
  }
  return progress.pixel;
}

void DirectImage::Cast::march(const Range& range, Face face, Progress& progress) const noexcept {
  // Samples are counted from the start of the range, so that a face is sampled at the same depth everywhere.
  // The last sample is at the end of the range. The layer between two samples counts if one of them is in a
  // cell with visible values.
  const dvec3 start = progress.from + range.from * progress.along, per_step = step * progress.along;
  const double steps = (range.to - range.from) / step;
  dvec3 inverse(0.0);
  for (int a = 0; a < 3; ++a)
    if (std::abs(per_step[a]) > 1e-12) inverse[a] = 1 / per_step[a];
  double before = 0;  // in steps, as k
  float value_before = 0;
  bool has_value = image.leaps_[block_of(cell_of(start))] == 0;
  std::uint64_t samples = 0;
  if (has_value) value_before = value_at(start), ++samples;
  if (!has_value || !(image.table_[entry_of(value_before)][3] > 0)) face = {};
  for (double k = std::min(1.0, steps); before < steps; k = std::min(k + 1, steps)) {
    const dvec3 p = start + k * per_step;
    const ivec3 v = cell_of(p);
    const std::size_t at = block_of(v);
    const int leap = image.leaps_[at];
    if (leap > 0 && !has_value) {
      // Leaps to the last sample in the surrounding blocks that are known to be invisible.
      ++progress.count->leaps;
      const ivec3 block = v >> 3;
      double next = steps;
      for (int a = 0; a < 3; ++a) {
        if (inverse[a] == 0) continue;
        const int end = per_step[a] > 0 ? block[a] + leap : block[a] - leap + 1;
        next = std::min(next, (k_edge * end - start[a]) * inverse[a]);
      }
      const auto last = static_cast<double>(static_cast<std::int64_t>(next));
      if (last > k) k = last;
      before = k;
      continue;
    }
    const int cell = (v.x >> 1 & 3) | (v.y >> 1 & 3) << 2 | (v.z >> 1 & 3) << 4;
    const bool is_cut = image.is_cut_[at] != 0,
               is_visible = leap == 0 && (is_cut || (image.cells_[at] >> cell & 1) != 0);
    if (is_visible || has_value) {
      if (!has_value) value_before = value_at(start + before * per_step), ++samples;
      const float value_now = value(clamped(p), is_cut);
      ++samples;
      add_layer({range.from + before * step, range.from + k * step}, value_before, value_now, face, progress);
      if (progress.is_opaque()) break;
      value_before = value_now, has_value = is_visible;
    }
    before = k;
  }
  progress.count->samples += samples;
}

void DirectImage::Cast::add_layer(const Range& range, float first, float second, const Face& face,
                                  Progress& progress) const noexcept {
  const auto [matter, position] = image.layer_of(first, second);
  float attenuation = matter[3];
  if (!(attenuation > 0)) return;
  const double at = range.from + static_cast<double>(position) * (range.to - range.from);
  const dvec3 p = progress.from + at * progress.along;
  vec3 colour(matter[0], matter[1], matter[2]);
  if (has_labels) {
    const ivec3 v = glm::clamp(ivec3(glm::floor(p + 0.5)), ivec3(0), scan.size - 1);
    const std::size_t label = image.near_labels_[scan.index(v.x, v.y, v.z)];
    if (label < image.labels_.size()) {
      attenuation *= static_cast<float>(image.labels_[label].opacity);
      if (image.labels_[label].colour) colour = vec3(*image.labels_[label].colour);
    }
  }
  const float opacity = image.opacity_of(attenuation * static_cast<float>(range.to - range.from));
  DirectPixel& pixel = progress.pixel;
  const float share = (1 - pixel.opacity) * opacity;
  if (!(share > 0)) return;
  // Faint layers get constant brightness.
  if (!request.is_shaded || share < 0.003F) {
    colour *= request.is_shaded ? 0.7F : 1.0F;
  } else {
    ++progress.count->shaded;
    colour *= at < face.end ? shade(face.normal, progress.toward_camera, progress.toward_lamp)
                            : brightness(p, at, progress);
  }
  pixel.red += share * std::min(1.0F, colour.x);
  pixel.green += share * std::min(1.0F, colour.y);
  pixel.blue += share * std::min(1.0F, colour.z);
  pixel.opacity += share;
  if (pixel.depth == 0 && pixel.opacity >= 0.5F) pixel.depth = static_cast<float>(at);
}

void DirectImage::draw(const RaycastRequest& request, const Version& version,
                       std::span<const float> obstacles, int threads, std::span<DirectPixel> pixels) {
  find_cut_blocks(version);
  const Frame& frame = scan_->frame;
  const dvec3 mm = frame.spacing();
  // Transposed inverse of the axes, which converts gradients to the world.
  glm::dmat3 gradient_world(0.0);
  for (int a = 0; a < 3; ++a) {
    dvec3 unit(0.0);
    unit[a] = 1;
    const dvec3 v = frame.vector_volume_from_world(unit);
    for (int b = 0; b < 3; ++b) gradient_world[b][a] = v[b];
  }
  const double edge_mm = std::min(0.5 * std::max({mm.x, mm.y, mm.z}), 0.9 * version.band_mm());
  const double step = request.step > 0 ? request.step : default_step_mm();
  const std::ptrdiff_t row = scan_->size.x, slice = row * scan_->size.y;
  const Cast cast{*this,
                  *scan_,
                  version,
                  request,
                  step,
                  edge_mm,
                  gradient_world,
                  !near_labels_.empty(),
                  1.5 * std::min({mm.x, mm.y, mm.z}),
                  std::min({mm.x, mm.y, mm.z}),
                  scan_->window_voxels().data(),
                  glm::max(scan_->size - 2, ivec3(0)),
                  row,
                  slice,
                  scan_->size.x > 1 ? 1 : 0,
                  scan_->size.y > 1 ? row : 0,
                  scan_->size.z > 1 ? slice : 0};
  std::atomic<std::uint64_t> rays{0}, samples{0}, shaded{0}, leaps{0};
  const int columns = request.camera.columns, rows = request.camera.rows;
  parallel_for((rows + k_task_rows - 1) / k_task_rows, threads, [&](int tile) {
    Counters count;
    if (request.is_cancelled != nullptr && *request.is_cancelled) return;
    for (int j = k_task_rows * tile; j < std::min(rows, k_task_rows * (tile + 1)); ++j)
      for (int i = 0; i < columns; ++i) {
        const auto n =
            static_cast<std::size_t>(i) + static_cast<std::size_t>(columns) * static_cast<std::size_t>(j);
        pixels[n] = cast.cast(i, j, obstacles.empty() ? 1e9 : static_cast<double>(obstacles[n]), count);
      }
    rays += count.rays, samples += count.samples, shaded += count.shaded, leaps += count.leaps;
  });
  counters_ = {rays, samples, shaded, leaps};
}

}  // namespace trephine::volume
