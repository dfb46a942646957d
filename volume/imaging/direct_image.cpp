#include "volume/imaging/direct_image.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <limits>

#include "volume/base/deterministic_math.h"
#include "volume/base/parallel.h"
#include "volume/cuts/operated_volume.h"

namespace trephine::volume {

using glm::dvec3;
using glm::ivec3;
using glm::vec3;

namespace {

constexpr int k_edge = 8;         // voxels along a block's edge
constexpr float k_full = 0.995F;  // opacity at which a ray ends
constexpr int k_values = 65536;
constexpr int k_lowest = -32768;
constexpr int k_tile = 16;  // rows of pixels per task of a thread

/// Evaluates a transfer function: colour, and opacity per mm.
std::pair<dvec3, double> evaluate(const TransferFunction& function, double value) {
  if (function.empty() || value < function.front().value) return {dvec3(0), 0};
  for (std::size_t i = 1; i < function.size(); ++i) {
    if (value > function[i].value) continue;
    const double share = (value - function[i - 1].value) / (function[i].value - function[i - 1].value);
    return {glm::mix(function[i - 1].colour, function[i].colour, share),
            glm::mix(function[i - 1].opacity, function[i].opacity, share)};
  }
  return {function.back().colour, function.back().opacity};
}

/// Opacity of a step (mm) through matter of the given attenuation (1/mm).
float opacity_of(float attenuation, double step) {
  return static_cast<float>(1 - deterministic_exp(-static_cast<double>(attenuation) * step));
}

}  // namespace

DirectImage::DirectImage(std::shared_ptr<const Volume> scan, int threads)
    : scan_(std::move(scan)), air_(static_cast<std::int16_t>(air_of(*scan_))) {
  const Volume& v = *scan_;
  blocks_ = (v.size + k_edge - 1) / k_edge;
  const auto count = static_cast<std::size_t>(blocks_.x) * static_cast<std::size_t>(blocks_.y) *
                     static_cast<std::size_t>(blocks_.z);
  low_.resize(count), high_.resize(count), is_cut_.assign(count, 0), leaps_.assign(count, 255);
  parallel_for(blocks_.z, threads, [&](int bz) {
    std::size_t at = static_cast<std::size_t>(bz) * static_cast<std::size_t>(blocks_.x) *
                     static_cast<std::size_t>(blocks_.y);
    for (int by = 0; by < blocks_.y; ++by)
      for (int bx = 0; bx < blocks_.x; ++bx, ++at) {
        // Includes the first voxels of the next blocks, since samples interpolate to them.
        const ivec3 first = k_edge * ivec3(bx, by, bz), last = glm::min(first + k_edge, v.size - 1);
        std::int16_t low = std::numeric_limits<std::int16_t>::max(),
                     high = std::numeric_limits<std::int16_t>::min();
        for (int z = first.z; z <= last.z; ++z)
          for (int y = first.y; y <= last.y; ++y) {
            const std::int16_t* row = v.window_voxels().data() + v.index(0, y, z);
            for (int x = first.x; x <= last.x; ++x)
              low = std::min(low, row[x]), high = std::max(high, row[x]);
          }
        low_[at] = low, high_[at] = high;
      }
  });
}

double DirectImage::default_step_mm() const noexcept {
  const dvec3 mm = scan_->frame.spacing();
  return 0.5 * std::min({mm.x, mm.y, mm.z});
}

std::optional<std::array<ivec3, 2>> DirectImage::visible_box() const {
  ivec3 low = blocks_, high(-1);
  std::size_t at = 0;
  for (int z = 0; z < blocks_.z; ++z)
    for (int y = 0; y < blocks_.y; ++y)
      for (int x = 0; x < blocks_.x; ++x, ++at)
        if (leaps_[at] == 0) low = glm::min(low, ivec3(x, y, z)), high = glm::max(high, ivec3(x, y, z));
  if (high.x < 0) return std::nullopt;
  return std::array{k_edge * low, glm::min(k_edge * (high + 1), scan_->size) - 1};
}

bool DirectImage::is_visible(int low, int high) const noexcept {
  return visible_below_[static_cast<std::size_t>(high - k_lowest) + 1] >
         visible_below_[static_cast<std::size_t>(low - k_lowest)];
}

void DirectImage::set_transfer_function(const TransferFunction& function, int threads) {
  step_of_opacities_ = 0;
  table_.resize(k_values), visible_below_.assign(k_values + 1, 0);
  for (int i = 0; i < k_values; ++i) {
    const auto [colour, opacity] = evaluate(function, k_lowest + i);
    const double transmission = std::max(1e-6, 1 - opacity);
    table_[static_cast<std::size_t>(i)] = {static_cast<float>(colour.x), static_cast<float>(colour.y),
                                           static_cast<float>(colour.z),
                                           static_cast<float>(-deterministic_log(transmission))};
    visible_below_[static_cast<std::size_t>(i) + 1] =
        visible_below_[static_cast<std::size_t>(i)] + (opacity > 0);
  }
  cells_.assign(low_.size(), 0);
  parallel_for(blocks_.z, threads, [&](int bz) {
    const Volume& v = *scan_;
    for (int by = 0; by < blocks_.y; ++by)
      for (int bx = 0; bx < blocks_.x; ++bx) {
        const auto at = static_cast<std::size_t>(bx + blocks_.x * by) +
                        static_cast<std::size_t>(blocks_.x * blocks_.y) * static_cast<std::size_t>(bz);
        if (!is_visible(low_[at], high_[at])) continue;
        const ivec3 corner = k_edge * ivec3(bx, by, bz);
        for (int cell = 0; cell < 64; ++cell) {
          const ivec3 first = glm::min(corner + 2 * ivec3(cell & 3, cell >> 2 & 3, cell >> 4), v.size - 1),
                      last = glm::min(first + 2, v.size - 1);
          std::int16_t low = std::numeric_limits<std::int16_t>::max(),
                       high = std::numeric_limits<std::int16_t>::min();
          for (int z = first.z; z <= last.z; ++z)
            for (int y = first.y; y <= last.y; ++y)
              for (int x = first.x; x <= last.x; ++x) {
                const std::int16_t value = v.window_voxels()[v.index(x, y, z)];
                low = std::min(low, value), high = std::max(high, value);
              }
          if (is_visible(low, high)) cells_[at] |= std::uint64_t{1} << cell;
        }
      }
  });
  measure_leaps();
}

void DirectImage::set_labels(std::vector<LabelAppearance> looks, int threads) {
  labels_ = std::move(looks);
  const Volume& v = *scan_;
  if (labels_.empty() || v.labels.size() != v.voxels.size()) {
    near_labels_.clear();
    return;
  }
  near_labels_.assign(v.labels.data(), v.labels.data() + v.labels.size());
  // Dilates the labels by one voxel per pass.
  for (int pass = 0; pass < k_blur; ++pass) {
    const std::vector<std::uint8_t> previous = near_labels_;
    parallel_for(v.size.z, threads, [&](int z) {
      for (int y = 0; y < v.size.y; ++y)
        for (int x = 0; x < v.size.x; ++x) {
          const std::size_t at = v.index(x, y, z);
          if (previous[at] != 0) continue;
          const ivec3 p(x, y, z);
          for (int n = 0; n < 6 && near_labels_[at] == 0; ++n) {
            ivec3 q = p;
            q[n / 2] += n % 2 ? 1 : -1;
            if (q[n / 2] >= 0 && q[n / 2] < v.size[n / 2])
              near_labels_[at] = previous[v.index(q.x, q.y, q.z)];
          }
        }
    });
  }
}

/// Marks the blocks in which cuts affect values.
void DirectImage::find_cut_blocks(const Version& version) {
  std::vector<std::uint8_t> previous = std::move(is_cut_);
  is_cut_.assign(previous.size(), 0);
  const CutLattice& lattice = version.lattice();
  version.for_bricks_in(ivec3(0), lattice.size() - 1, [&](const ivec3& low, const Brick&) {
    // The soft edge of a cut can affect samples up to a lattice cell from the brick.
    const dvec3 from = lattice.volume_from_lattice(dvec3(low - 1)) - 0.5,
                to = lattice.volume_from_lattice(dvec3(low + k_brick)) + 0.5;
    const ivec3 first = glm::clamp(ivec3(glm::floor(from)), ivec3(0), scan_->size - 1) / k_edge,
                last = glm::clamp(ivec3(glm::ceil(to)), ivec3(0), scan_->size - 1) / k_edge;
    for (int z = first.z; z <= last.z; ++z)
      for (int y = first.y; y <= last.y; ++y)
        for (int x = first.x; x <= last.x; ++x)
          is_cut_[static_cast<std::size_t>(x + blocks_.x * (y + blocks_.y * z))] = 1;
  });
  if (is_cut_ != previous) measure_leaps();
}

/// Computes the chessboard distances in blocks, by two passes over already visited neighbours (Rosenfeld and
/// Pfaltz 1968).
void DirectImage::measure_leaps() {
  if (visible_below_.empty()) return;
  for (std::size_t i = 0; i < leaps_.size(); ++i) {
    // In cut blocks the values are mixed with air.
    const int low = is_cut_[i] ? std::min(low_[i], air_) : low_[i],
              high = is_cut_[i] ? std::max(high_[i], air_) : high_[i];
    leaps_[i] = is_visible(low, high) ? 0 : 255;
  }
  const auto at = [&](int x, int y, int z) -> std::uint8_t& {
    return leaps_[static_cast<std::size_t>(x) +
                  static_cast<std::size_t>(blocks_.x) *
                      (static_cast<std::size_t>(y) +
                       static_cast<std::size_t>(blocks_.y) * static_cast<std::size_t>(z))];
  };
  for (const int direction : {1, -1}) {
    const auto visit = [&](int x, int y, int z) {
      int least = at(x, y, z);
      for (int dz = -1; dz <= 0; ++dz)
        for (int dy = -1; dy <= 1; ++dy)
          for (int dx = -1; dx <= 1; ++dx) {
            if (dz == 0 && (dy > 0 || (dy == 0 && dx >= 0))) continue;
            const int nx = x + direction * dx, ny = y + direction * dy, nz = z + direction * dz;
            if (nx < 0 || ny < 0 || nz < 0 || nx >= blocks_.x || ny >= blocks_.y || nz >= blocks_.z) continue;
            least = std::min(least, at(nx, ny, nz) + 1);
          }
      at(x, y, z) = static_cast<std::uint8_t>(std::min(least, 255));
    };
    for (int k = 0; k < blocks_.z; ++k)
      for (int j = 0; j < blocks_.y; ++j)
        for (int i = 0; i < blocks_.x; ++i)
          direction > 0 ? visit(i, j, k) : visit(blocks_.x - 1 - i, blocks_.y - 1 - j, blocks_.z - 1 - k);
  }
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
  double face_depth;  // mm; matter to this depth behind the plane is shaded as the plane
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
  /// Brightness of a point, 0.22 to 1.2, by the gradient of the values.
  float brightness(const vec3& p, bool is_cut, const vec3& toward_eye,
                   const vec3& toward_lamp) const noexcept {
    constexpr float h = 0.6F;  // voxels
    const vec3 by_voxels(value(p + vec3(h, 0, 0), is_cut) - value(p - vec3(h, 0, 0), is_cut),
                         value(p + vec3(0, h, 0), is_cut) - value(p - vec3(0, h, 0), is_cut),
                         value(p + vec3(0, 0, h), is_cut) - value(p - vec3(0, 0, h), is_cut));
    const vec3 g = vec3(gradient_world * dvec3(by_voxels));
    const float size = std::sqrt(glm::dot(g, g));
    if (!(size > 1)) return 0.7F;
    const vec3 n = g / -size;  // points out of the denser matter
    return shade(glm::dot(n, toward_eye) < 0 ? -n : n, toward_eye, toward_lamp);
  }
  /// Brightness of a surface with normal n: constant, diffuse, viewer-facing and specular terms.
  static float shade(const vec3& n, const vec3& toward_eye, const vec3& toward_lamp) noexcept {
    const float front = std::max(0.0F, glm::dot(n, toward_lamp)), facing = glm::dot(n, toward_eye);
    const float half = std::max(0.0F, glm::dot(n, glm::normalize(toward_eye + toward_lamp)));
    float shine = half * half;
    shine *= shine, shine *= shine, shine *= shine;  // ^16
    return 0.22F + 0.5F * front + 0.28F * facing + 0.18F * shine;
  }

  bool is_in_tube(const dvec3& world) const noexcept {
    for (const Openings::Tube& tube : request.openings.tubes) {
      const dvec3 along = tube.to - tube.from, offset = world - tube.from;
      const double size = glm::dot(along, along);
      const double share = size > 0 ? std::clamp(glm::dot(offset, along) / size, 0.0, 1.0) : 0.0;
      const dvec3 radial = offset - share * along;
      if (glm::dot(radial, radial) < tube.radius * tube.radius) return true;
    }
    return false;
  }

  DirectPixel cast(int i, int j, double wall, Counters& count) const noexcept;
};

DirectPixel DirectImage::Cast::cast(int i, int j, double wall, Counters& count) const noexcept {
  const Camera::Ray ray = request.eye.ray(i, j);
  const Frame& frame = scan.frame;
  const dvec3 from = frame.volume_from_world(ray.from), along = frame.vector_volume_from_world(ray.along);
  // Clips the ray to the scan, to half a voxel beyond the outermost voxel centres.
  double enter = 0, leave = wall;
  for (int a = 0; a < 3; ++a) {
    const double low = -0.5, high = scan.size[a] - 0.5;
    if (std::abs(along[a]) < 1e-12) {
      if (from[a] < low || from[a] > high) return {};
      continue;
    }
    const double t0 = (low - from[a]) / along[a], t1 = (high - from[a]) / along[a];
    enter = std::max(enter, std::min(t0, t1)), leave = std::min(leave, std::max(t0, t1));
  }
  double face_end = -1;  // mm; matter cut by the plane is shaded as the plane up to here
  // Clips the ray at the plane of the openings.
  if (request.openings.plane) {
    const Openings::Plane& plane = *request.openings.plane;
    const double height = glm::dot(ray.from - plane.at, plane.normal),
                 rise = glm::dot(ray.along, plane.normal);
    if (std::abs(rise) > 1e-12) {
      const double crossing = -height / rise;
      if (rise < 0 && crossing > enter) face_end = crossing + 1.5 * face_depth;
      rise < 0 ? enter = std::max(enter, crossing) : leave = std::min(leave, crossing);
    } else if (height > 0) {
      return {};
    }
  }
  ++count.rays;
  DirectPixel pixel;
  const vec3 toward_eye = vec3(-ray.along);
  const vec3 toward_lamp =
      vec3(glm::normalize(-request.eye.forward + 0.45 * request.eye.up - 0.35 * request.eye.right()));
  double k = std::ceil(enter / step);
  const double last = std::floor(leave / step);
  const dvec3 per_step = step * along;
  while (k <= last) {
    const dvec3 p = from + k * per_step;
    // Truncation rounds toward 0, which maps positions between -1 and 0 to the first voxel.
    const ivec3 v = glm::clamp(ivec3(p), ivec3(0), scan.size - 1), block = v >> 3;
    const auto at =
        static_cast<std::size_t>(block.x + image.blocks_.x * block.y) +
        static_cast<std::size_t>(image.blocks_.x * image.blocks_.y) * static_cast<std::size_t>(block.z);
    if (const int leap = image.leaps_[at]; leap > 0) {
      // Leaps to the end of the surrounding blocks that are known to be invisible.
      ++count.leaps;
      double next = last + 1;
      for (int a = 0; a < 3; ++a) {
        if (std::abs(per_step[a]) < 1e-12) continue;
        const double end = per_step[a] > 0 ? k_edge * static_cast<double>(block[a] + leap)
                                           : k_edge * static_cast<double>(block[a] - leap + 1);
        next = std::min(next, (end - from[a]) / per_step[a]);
      }
      // Continues at the first sample that is not before that end (a ceiling, by truncation).
      const double truncated = static_cast<double>(static_cast<std::int64_t>(next));
      k = std::max(truncated + (next - truncated > 1e-9 ? 1 : 0), k + 1);
      continue;
    }
    const bool is_cut = image.is_cut_[at] != 0;
    const int cell = (v.x >> 1 & 3) | (v.y >> 1 & 3) << 2 | (v.z >> 1 & 3) << 4;
    if (!is_cut && (image.cells_[at] >> cell & 1) == 0) {
      k += 1;
      continue;
    }
    ++count.samples;
    const vec3 q = glm::clamp(vec3(p), vec3(0), vec3(scan.size - 1));
    const float value = this->value(q, is_cut);
    const auto entry = static_cast<std::size_t>(static_cast<int>(value + (0.5F - k_lowest)));
    const std::array<float, 4>& matter = image.table_[entry];
    float attenuation = matter[3];
    if (attenuation > 0) {
      vec3 colour(matter[0], matter[1], matter[2]);
      if (has_labels) {
        const ivec3 v = glm::clamp(ivec3(glm::floor(p + 0.5)), ivec3(0), scan.size - 1);
        const std::size_t label = image.near_labels_[scan.index(v.x, v.y, v.z)];
        if (label < image.labels_.size()) {
          attenuation *= static_cast<float>(image.labels_[label].opacity);
          if (image.labels_[label].colour) colour = vec3(*image.labels_[label].colour);
        }
      }
      if (attenuation > 0 && !request.openings.tubes.empty() && is_in_tube(ray.from + k * step * ray.along))
        attenuation = 0;
      if (attenuation > 0) {
        const float opacity =
            attenuation == matter[3] ? image.opacities_[entry] : opacity_of(attenuation, step);
        const float share = (1 - pixel.opacity) * opacity;
        // Faint samples get constant brightness.
        if (!request.is_shaded || share < 0.003F) {
          colour *= request.is_shaded ? 0.7F : 1.0F;
        } else {
          ++count.shaded;
          colour *= k * step < face_end ? shade(vec3(request.openings.plane->normal), toward_eye, toward_lamp)
                                        : brightness(q, is_cut, toward_eye, toward_lamp);
        }
        pixel.red += share * std::min(1.0F, colour.x);
        pixel.green += share * std::min(1.0F, colour.y);
        pixel.blue += share * std::min(1.0F, colour.z);
        pixel.opacity += share;
        if (pixel.depth == 0 && pixel.opacity >= 0.5F) pixel.depth = static_cast<float>(k * step);
        if (pixel.opacity > k_full) break;
      }
    }
    k += 1;
  }
  return pixel;
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
  if (step != step_of_opacities_) {
    opacities_.resize(k_values);
    for (std::size_t i = 0; i < opacities_.size(); ++i)
      opacities_[i] = table_[i][3] > 0 ? opacity_of(table_[i][3], step) : 0.0F;
    step_of_opacities_ = step;
  }
  const std::ptrdiff_t row = scan_->size.x, slice = row * scan_->size.y;
  const Cast cast{*this,
                  *scan_,
                  version,
                  request,
                  step,
                  edge_mm,
                  gradient_world,
                  !near_labels_.empty(),
                  std::min({mm.x, mm.y, mm.z}),
                  scan_->window_voxels().data(),
                  glm::max(scan_->size - 2, ivec3(0)),
                  row,
                  slice,
                  scan_->size.x > 1 ? 1 : 0,
                  scan_->size.y > 1 ? row : 0,
                  scan_->size.z > 1 ? slice : 0};
  std::atomic<std::uint64_t> rays{0}, samples{0}, shaded{0}, leaps{0};
  const int columns = request.eye.columns, rows = request.eye.rows;
  parallel_for((rows + k_tile - 1) / k_tile, threads, [&](int tile) {
    Counters count;
    if (request.is_cancelled != nullptr && *request.is_cancelled) return;
    for (int j = k_tile * tile; j < std::min(rows, k_tile * (tile + 1)); ++j)
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
