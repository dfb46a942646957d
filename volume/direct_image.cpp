#include "volume/direct_image.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <limits>

#include "volume/deterministic_math.h"
#include "volume/operated_volume.h"
#include "volume/parallel.h"

namespace trephine::volume {

using glm::dvec3;
using glm::ivec3;
using glm::vec3;

namespace {

constexpr int k_edge = 8;         // voxels of a block
constexpr float k_full = 0.995F;  // opacity at which a ray ends
constexpr int k_values = 65536;
constexpr int k_lowest = -32768;
constexpr int k_tile = 16;  // rows of pixels that a thread takes

/// Colour and opacity of a millimetre for a value.
std::pair<dvec3, double> look_of(const Ramp& ramp, double value) {
  if (ramp.empty() || value < ramp.front().value) return {dvec3(0), 0};
  for (std::size_t i = 1; i < ramp.size(); ++i) {
    if (value > ramp[i].value) continue;
    const double share = (value - ramp[i - 1].value) / (ramp[i].value - ramp[i - 1].value);
    return {glm::mix(ramp[i - 1].colour, ramp[i].colour, share),
            glm::mix(ramp[i - 1].opacity, ramp[i].opacity, share)};
  }
  return {ramp.back().colour, ramp.back().opacity};
}

/// Opacity of a step through matter of so much a millimetre.
float opacity_of(float weakens, double step) {
  return static_cast<float>(1 - deterministic_exp(-static_cast<double>(weakens) * step));
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
        // With the next voxels: samples lie between them.
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

double DirectImage::own_step() const noexcept {
  const dvec3 mm = scan_->frame.spacing();
  return 0.5 * std::min({mm.x, mm.y, mm.z});
}

std::optional<std::array<ivec3, 2>> DirectImage::seen_box() const {
  ivec3 low = blocks_, high(-1);
  std::size_t at = 0;
  for (int z = 0; z < blocks_.z; ++z)
    for (int y = 0; y < blocks_.y; ++y)
      for (int x = 0; x < blocks_.x; ++x, ++at)
        if (leaps_[at] == 0) low = glm::min(low, ivec3(x, y, z)), high = glm::max(high, ivec3(x, y, z));
  if (high.x < 0) return std::nullopt;
  return std::array{k_edge * low, glm::min(k_edge * (high + 1), scan_->size) - 1};
}

bool DirectImage::is_seen(int low, int high) const noexcept {
  return seen_up_to_[static_cast<std::size_t>(high - k_lowest) + 1] >
         seen_up_to_[static_cast<std::size_t>(low - k_lowest)];
}

void DirectImage::set_ramp(const Ramp& ramp, int threads) {
  step_of_opacities_ = 0;
  table_.resize(k_values), seen_up_to_.assign(k_values + 1, 0);
  for (int i = 0; i < k_values; ++i) {
    const auto [colour, opacity] = look_of(ramp, k_lowest + i);
    const double passes = std::max(1e-6, 1 - opacity);
    table_[static_cast<std::size_t>(i)] = {static_cast<float>(colour.x), static_cast<float>(colour.y),
                                           static_cast<float>(colour.z),
                                           static_cast<float>(-deterministic_log(passes))};
    seen_up_to_[static_cast<std::size_t>(i) + 1] = seen_up_to_[static_cast<std::size_t>(i)] + (opacity > 0);
  }
  cells_.assign(low_.size(), 0);
  parallel_for(blocks_.z, threads, [&](int bz) {
    const Volume& v = *scan_;
    for (int by = 0; by < blocks_.y; ++by)
      for (int bx = 0; bx < blocks_.x; ++bx) {
        const auto at = static_cast<std::size_t>(bx + blocks_.x * by) +
                        static_cast<std::size_t>(blocks_.x * blocks_.y) * static_cast<std::size_t>(bz);
        if (!is_seen(low_[at], high_[at])) continue;
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
          if (is_seen(low, high)) cells_[at] |= std::uint64_t{1} << cell;
        }
      }
  });
  measure_leaps();
}

void DirectImage::set_labels(std::vector<LabelLook> looks, int threads) {
  labels_ = std::move(looks);
  const Volume& v = *scan_;
  if (labels_.empty() || v.labels.size() != v.voxels.size()) {
    near_labels_.clear();
    return;
  }
  near_labels_.assign(v.labels.data(), v.labels.data() + v.labels.size());
  // A voxel farther each time, from the labels as they were.
  for (int pass = 0; pass < k_blur; ++pass) {
    const std::vector<std::uint8_t> before = near_labels_;
    parallel_for(v.size.z, threads, [&](int z) {
      for (int y = 0; y < v.size.y; ++y)
        for (int x = 0; x < v.size.x; ++x) {
          const std::size_t at = v.index(x, y, z);
          if (before[at] != 0) continue;
          const ivec3 p(x, y, z);
          for (int way = 0; way < 6 && near_labels_[at] == 0; ++way) {
            ivec3 q = p;
            q[way / 2] += way % 2 ? 1 : -1;
            if (q[way / 2] >= 0 && q[way / 2] < v.size[way / 2])
              near_labels_[at] = before[v.index(q.x, q.y, q.z)];
          }
        }
    });
  }
}

/// Blocks in which values are not the scan's.
void DirectImage::look_at_cuts(const Version& version) {
  std::vector<std::uint8_t> before = std::move(is_cut_);
  is_cut_.assign(before.size(), 0);
  const CutLattice& lattice = version.lattice();
  version.for_bricks_in(ivec3(0), lattice.size() - 1, [&](const ivec3& low, const Brick&) {
    // A sample as far as a lattice cell from the brick may be nearer to its cut than the edge is soft.
    const dvec3 from = lattice.volume_from_lattice(dvec3(low - 1)) - 0.5,
                to = lattice.volume_from_lattice(dvec3(low + k_brick)) + 0.5;
    const ivec3 first = glm::clamp(ivec3(glm::floor(from)), ivec3(0), scan_->size - 1) / k_edge,
                last = glm::clamp(ivec3(glm::ceil(to)), ivec3(0), scan_->size - 1) / k_edge;
    for (int z = first.z; z <= last.z; ++z)
      for (int y = first.y; y <= last.y; ++y)
        for (int x = first.x; x <= last.x; ++x)
          is_cut_[static_cast<std::size_t>(x + blocks_.x * (y + blocks_.y * z))] = 1;
  });
  if (is_cut_ != before) measure_leaps();
}

/// The greatest of the three distances in blocks, by two passes over neighbours that were visited before.
void DirectImage::measure_leaps() {
  if (seen_up_to_.empty()) return;
  for (std::size_t i = 0; i < leaps_.size(); ++i) {
    // Air that was cut in may be part of any mixture.
    const int low = is_cut_[i] ? std::min(low_[i], air_) : low_[i],
              high = is_cut_[i] ? std::max(high_[i], air_) : high_[i];
    leaps_[i] = is_seen(low, high) ? 0 : 255;
  }
  const auto at = [&](int x, int y, int z) -> std::uint8_t& {
    return leaps_[static_cast<std::size_t>(x) +
                  static_cast<std::size_t>(blocks_.x) *
                      (static_cast<std::size_t>(y) +
                       static_cast<std::size_t>(blocks_.y) * static_cast<std::size_t>(z))];
  };
  for (const int way : {1, -1}) {
    const auto visit = [&](int x, int y, int z) {
      int least = at(x, y, z);
      for (int dz = -1; dz <= 0; ++dz)
        for (int dy = -1; dy <= 1; ++dy)
          for (int dx = -1; dx <= 1; ++dx) {
            if (dz == 0 && (dy > 0 || (dy == 0 && dx >= 0))) continue;
            const int nx = x + way * dx, ny = y + way * dy, nz = z + way * dz;
            if (nx < 0 || ny < 0 || nz < 0 || nx >= blocks_.x || ny >= blocks_.y || nz >= blocks_.z) continue;
            least = std::min(least, at(nx, ny, nz) + 1);
          }
      at(x, y, z) = static_cast<std::uint8_t>(std::min(least, 255));
    };
    for (int k = 0; k < blocks_.z; ++k)
      for (int j = 0; j < blocks_.y; ++j)
        for (int i = 0; i < blocks_.x; ++i)
          way > 0 ? visit(i, j, k) : visit(blocks_.x - 1 - i, blocks_.y - 1 - j, blocks_.z - 1 - k);
  }
}

/// One image: what its rays share, and how one is cast.
struct DirectImage::Cast {
  const DirectImage& image;
  const Volume& scan;
  const Version& version;
  const RaycastRequest& request;
  double step;
  double soft;                // mm, of the edge of a cut
  glm::dmat3 gradient_world;  // from a gradient by voxels
  bool has_labels;
  double face_depth;  // mm
  const std::int16_t* voxels;
  ivec3 most;                            // of a voxel that has a next one
  std::ptrdiff_t row, slice;             // to the next voxel, of any voxel,
  std::ptrdiff_t beside, below, behind;  // and of one that has none: itself

  /// Between voxels; p clamped to the outermost ones.
  float scan_value(const vec3& p) const noexcept {
    const int x = std::clamp(static_cast<int>(p.x), 0, most.x),
              y = std::clamp(static_cast<int>(p.y), 0, most.y),
              z = std::clamp(static_cast<int>(p.z), 0, most.z);
    const float fx = std::clamp(p.x - static_cast<float>(x), 0.0F, 1.0F),
                fy = std::clamp(p.y - static_cast<float>(y), 0.0F, 1.0F),
                fz = std::clamp(p.z - static_cast<float>(z), 0.0F, 1.0F);
    const std::int16_t* c = voxels + x + row * y + slice * z;
    const auto along = [fx, next = beside](const std::int16_t* from) {
      const auto a = static_cast<float>(from[0]), b = static_cast<float>(from[next]);
      return a + fx * (b - a);
    };
    const float a = along(c), b = along(c + below), d = along(c + behind), e = along(c + below + behind);
    const float low = a + fy * (b - a), high = d + fy * (e - d);
    return low + fz * (high - low);
  }
  float value(const vec3& p, bool is_cut) const noexcept {
    const float whole = scan_value(p);
    if (!is_cut || !version.is_near_cut(dvec3(p))) return whole;
    const auto kept = static_cast<float>(std::clamp(0.5 + 0.5 * version.distance(dvec3(p)) / soft, 0.0, 1.0));
    return image.air_ + kept * (whole - image.air_);
  }
  /// 0.22 to 1.2: how bright a place is in light from the eye.
  float light(const vec3& p, bool is_cut, const vec3& toward_eye, const vec3& toward_lamp) const noexcept {
    constexpr float h = 0.6F;  // voxels
    const vec3 by_voxels(value(p + vec3(h, 0, 0), is_cut) - value(p - vec3(h, 0, 0), is_cut),
                         value(p + vec3(0, h, 0), is_cut) - value(p - vec3(0, h, 0), is_cut),
                         value(p + vec3(0, 0, h), is_cut) - value(p - vec3(0, 0, h), is_cut));
    const vec3 g = vec3(gradient_world * dvec3(by_voxels));
    const float size = std::sqrt(glm::dot(g, g));
    if (!(size > 1)) return 0.7F;
    const vec3 n = g / -size;  // out of what is denser
    return lit(glm::dot(n, toward_eye) < 0 ? -n : n, toward_eye, toward_lamp);
  }
  static float lit(const vec3& n, const vec3& toward_eye, const vec3& toward_lamp) noexcept {
    const float front = std::max(0.0F, glm::dot(n, toward_lamp)), facing = glm::dot(n, toward_eye);
    const float half = std::max(0.0F, glm::dot(n, glm::normalize(toward_eye + toward_lamp)));
    float shine = half * half;
    shine *= shine, shine *= shine, shine *= shine;  // ^16
    return 0.22F + 0.5F * front + 0.28F * facing + 0.18F * shine;
  }

  bool is_in_tube(const dvec3& world) const noexcept {
    for (const Openings::Tube& tube : request.openings.tubes) {
      const dvec3 along = tube.to - tube.from, off = world - tube.from;
      const double size = glm::dot(along, along);
      const double share = size > 0 ? std::clamp(glm::dot(off, along) / size, 0.0, 1.0) : 0.0;
      const dvec3 beside = off - share * along;
      if (glm::dot(beside, beside) < tube.radius * tube.radius) return true;
    }
    return false;
  }

  DirectPixel cast(int i, int j, double wall, Counters& count) const noexcept;
};

DirectPixel DirectImage::Cast::cast(int i, int j, double wall, Counters& count) const noexcept {
  const Eye::Ray ray = request.eye.ray(i, j);
  const Frame& frame = scan.frame;
  const dvec3 from = frame.volume_from_world(ray.from), along = frame.vector_volume_from_world(ray.along);
  // Part of the ray in the scan: to half a voxel beyond its outermost ones.
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
  double face_until = -1;  // matter that the plane cuts through is lit as that plane
  // Nothing before the plane: a ray begins, or ends, there.
  if (request.openings.plane) {
    const Openings::Plane& plane = *request.openings.plane;
    const double height = glm::dot(ray.from - plane.at, plane.normal),
                 falls = glm::dot(ray.along, plane.normal);
    if (std::abs(falls) > 1e-12) {
      const double at = -height / falls;
      if (falls < 0 && at > enter) face_until = at + 1.5 * face_depth;
      falls < 0 ? enter = std::max(enter, at) : leave = std::min(leave, at);
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
    // Truncation is towards 0, and so belongs to the first voxel.
    const ivec3 v = glm::clamp(ivec3(p), ivec3(0), scan.size - 1), block = v >> 3;
    const auto at =
        static_cast<std::size_t>(block.x + image.blocks_.x * block.y) +
        static_cast<std::size_t>(image.blocks_.x * image.blocks_.y) * static_cast<std::size_t>(block.z);
    if (const int leap = image.leaps_[at]; leap > 0) {
      // To the end of all blocks that are as near as this one is far from anything.
      ++count.leaps;
      double next = last + 1;
      for (int a = 0; a < 3; ++a) {
        if (std::abs(per_step[a]) < 1e-12) continue;
        const double end = per_step[a] > 0 ? k_edge * static_cast<double>(block[a] + leap)
                                           : k_edge * static_cast<double>(block[a] - leap + 1);
        next = std::min(next, (end - from[a]) / per_step[a]);
      }
      // The first sample that is not before it: what is cut off is towards 0.
      const double whole = static_cast<double>(static_cast<std::int64_t>(next));
      k = std::max(whole + (next - whole > 1e-9 ? 1 : 0), k + 1);
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
    const std::array<float, 4>& look = image.table_[entry];
    float weakens = look[3];
    if (weakens > 0) {
      vec3 colour(look[0], look[1], look[2]);
      if (has_labels) {
        const ivec3 v = glm::clamp(ivec3(glm::floor(p + 0.5)), ivec3(0), scan.size - 1);
        const std::size_t label = image.near_labels_[scan.index(v.x, v.y, v.z)];
        if (label < image.labels_.size()) {
          weakens *= static_cast<float>(image.labels_[label].opacity);
          if (image.labels_[label].colour) colour = vec3(*image.labels_[label].colour);
        }
      }
      if (weakens > 0 && !request.openings.tubes.empty() && is_in_tube(ray.from + k * step * ray.along))
        weakens = 0;
      if (weakens > 0) {
        const float opacity = weakens == look[3] ? image.opacities_[entry] : opacity_of(weakens, step);
        const float share = (1 - pixel.opacity) * opacity;
        // Faint samples have no light of their own.
        if (!request.is_shaded || share < 0.003F) {
          colour *= request.is_shaded ? 0.7F : 1.0F;
        } else {
          ++count.shaded;
          colour *= k * step < face_until ? lit(vec3(request.openings.plane->normal), toward_eye, toward_lamp)
                                          : light(q, is_cut, toward_eye, toward_lamp);
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

void DirectImage::draw(const RaycastRequest& request, const Version& version, std::span<const float> walls,
                       int threads, std::span<DirectPixel> pixels) {
  look_at_cuts(version);
  const Frame& frame = scan_->frame;
  const dvec3 mm = frame.spacing();
  // Rows of the inverse: what a step along an axis of the volume is in the world, for gradients.
  glm::dmat3 back(0.0);
  for (int a = 0; a < 3; ++a) {
    dvec3 unit(0.0);
    unit[a] = 1;
    const dvec3 v = frame.vector_volume_from_world(unit);
    for (int b = 0; b < 3; ++b) back[b][a] = v[b];
  }
  const double soft = std::min(0.5 * std::max({mm.x, mm.y, mm.z}), 0.9 * version.band_mm());
  const double step = request.step > 0 ? request.step : own_step();
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
                  soft,
                  back,
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
    if (request.is_given_up != nullptr && *request.is_given_up) return;
    for (int j = k_tile * tile; j < std::min(rows, k_tile * (tile + 1)); ++j)
      for (int i = 0; i < columns; ++i) {
        const auto n =
            static_cast<std::size_t>(i) + static_cast<std::size_t>(columns) * static_cast<std::size_t>(j);
        pixels[n] = cast.cast(i, j, walls.empty() ? 1e9 : static_cast<double>(walls[n]), count);
      }
    rays += count.rays, samples += count.samples, shaded += count.shaded, leaps += count.leaps;
  });
  counters_ = {rays, samples, shaded, leaps};
}

}  // namespace trephine::volume
