#include "volume/removal.h"

#include <emmintrin.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_access.hpp>
#include <glm/matrix.hpp>

namespace trephine::volume {

namespace {

constexpr int k_brick_voxels = k_brick * k_brick * k_brick;
constexpr std::uint64_t k_all = ~std::uint64_t{0};

/// Largest fineness a mask has; 4 where the ball spans many voxels, 8 where it is small.
int samples_per_edge(double radius_mm, const Frame& frame) {
  const glm::dvec3 s = frame.spacing();
  return radius_mm < 4 * std::max({s.x, s.y, s.z}) ? 8 : 4;
}


}  // namespace

/// Everything in mm relative to the start of the sweep, single precision: a sweep and its ball are tens of mm.
struct RemovalEditor::Shape {
  Sweep sweep;
  int n;                       // mask fineness
  float radius, band, length;  // mm
  glm::vec3 along;             // unit direction of the sweep, or 0
  glm::vec3 ax, ay, az;        // a voxel step
  float voxel_reach;           // half a voxel's diagonal, with a margin for rounding
  double brick_reach;          // half a brick's diagonal
  // Of each sample in a voxel: offset along `ax`, and the squared length of its whole offset.
  alignas(16) float offset[8];
  alignas(16) float offset_squared[512];

  Shape(const Sweep& s, const Version& version, int fineness) : sweep(s), n(fineness) {
    const Frame& frame = version.base().frame;
    radius = static_cast<float>(s.radius_mm);
    band = static_cast<float>(version.band_mm());
    const glm::dvec3 d = s.end_world - s.start_world;
    const double l = glm::length(d);
    length = static_cast<float>(l);
    along = l > 0 ? glm::vec3(d / l) : glm::vec3(0);
    ax = glm::vec3(frame.axes()[0]);
    ay = glm::vec3(frame.axes()[1]);
    az = glm::vec3(frame.axes()[2]);
    voxel_reach = static_cast<float>(0.5 * frame.diagonal_mm() * 1.0001 + 1e-5);
    brick_reach = 0.5 * k_brick * frame.diagonal_mm();
    for (int i = 0; i < n; ++i)
      offset[i] = (static_cast<float>(i) + 0.5f) / static_cast<float>(n) - 0.5f;
    for (int k = 0; k < n; ++k)
      for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
          const glm::vec3 o = offset[i] * ax + offset[j] * ay + offset[k] * az;
          offset_squared[(k * n + j) * n + i] = glm::dot(o, o);
        }
  }

  float distance(const glm::vec3& w) const {
    const float t = std::clamp(glm::dot(w, along), 0.0f, length);
    const glm::vec3 q = w - t * along;
    return std::sqrt(glm::dot(q, q)) - radius;
  }

  /// Which samples of the voxel centred at c lie in the swept ball; n^3 bits into `words`.
  /// Squared distances by the expansion |c + o|^2 = |c|^2 + 2 c.o + |o|^2.
  void sample(const glm::vec3& c, std::uint64_t* words) const {
    const float projection = glm::dot(c, along);
    const bool is_past_end = projection >= length + voxel_reach || length == 0;
    const glm::vec3 from = is_past_end ? c - length * along : c;
    if (is_past_end) sample_ball(from, words);
    else sample_capsule(from, words);
  }

 private:
  void sample_ball(const glm::vec3& c, std::uint64_t* words) const {
    const float cc = glm::dot(c, c) - radius * radius;
    const float x = 2 * glm::dot(c, ax), y = 2 * glm::dot(c, ay), z = 2 * glm::dot(c, az);
    const __m128 zero = _mm_setzero_ps();
    const float* squared = offset_squared;
    for (int k = 0; k < n; ++k) {
      std::uint64_t bits = 0;
      for (int j = 0; j < n; ++j) {
        const __m128 base = _mm_set1_ps(cc + (offset[j] * y + offset[k] * z));
        for (int i = 0; i < n; i += 4, squared += 4) {
          const __m128 ox = _mm_mul_ps(_mm_load_ps(offset + i), _mm_set1_ps(x));
          const __m128 d = _mm_add_ps(_mm_add_ps(base, ox), _mm_load_ps(squared));
          bits |= static_cast<std::uint64_t>(_mm_movemask_ps(_mm_cmple_ps(d, zero))) << (j * n + i);
        }
      }
      store(bits, k, words);
    }
  }
  void sample_capsule(const glm::vec3& c, std::uint64_t* words) const {
    const float cc = glm::dot(c, c) - radius * radius, ct = glm::dot(c, along);
    const float x = 2 * glm::dot(c, ax), y = 2 * glm::dot(c, ay), z = 2 * glm::dot(c, az);
    const float tx = glm::dot(ax, along), ty = glm::dot(ay, along), tz = glm::dot(az, along);
    const __m128 zero = _mm_setzero_ps(), end = _mm_set1_ps(length);
    const float* squared = offset_squared;
    for (int k = 0; k < n; ++k) {
      std::uint64_t bits = 0;
      for (int j = 0; j < n; ++j) {
        const __m128 base = _mm_set1_ps(cc + (offset[j] * y + offset[k] * z));
        const __m128 base_t = _mm_set1_ps(ct + (offset[j] * ty + offset[k] * tz));
        for (int i = 0; i < n; i += 4, squared += 4) {
          const __m128 o = _mm_load_ps(offset + i);
          const __m128 ww = _mm_add_ps(_mm_add_ps(base, _mm_mul_ps(o, _mm_set1_ps(x))), _mm_load_ps(squared));
          const __m128 wt = _mm_add_ps(base_t, _mm_mul_ps(o, _mm_set1_ps(tx)));
          const __m128 t = _mm_min_ps(_mm_max_ps(wt, zero), end);
          // |w - t u|^2 = |w|^2 + t (t - 2 w.u)
          const __m128 d = _mm_add_ps(ww, _mm_mul_ps(t, _mm_sub_ps(t, _mm_add_ps(wt, wt))));
          bits |= static_cast<std::uint64_t>(_mm_movemask_ps(_mm_cmple_ps(d, zero))) << (j * n + i);
        }
      }
      store(bits, k, words);
    }
  }
  void store(std::uint64_t slice, int k, std::uint64_t* words) const {
    if (n == 8) words[k] = slice;
    else if (k == 0) words[0] = slice;
    else words[0] |= slice << (16 * k);
  }
};

RemovalEditor::RemovalEditor(std::shared_ptr<const Version> start, std::vector<Field> solids)
    : solids_(std::move(solids)) {
  reset(std::move(start));
}

void RemovalEditor::reset(std::shared_ptr<const Version> start) {
  const std::uint64_t serial = next_ ? std::max(next_->serial_, start->serial_) : start->serial_;
  next_ = std::make_shared<Version>(*start);
  next_->serial_ = serial + 1;
  ++stroke_;
}

std::shared_ptr<const Version> RemovalEditor::publish() {
  std::shared_ptr<const Version> done = std::move(next_);
  next_ = std::make_shared<Version>(*done);
  ++next_->serial_;
  return done;
}

Page& RemovalEditor::editable_page(std::size_t index) {
  Ref<Page>& page = next_->pages_[index];
  if (!page || page->serial != next_->serial_) {
    auto* fresh = new Page;
    if (page) fresh->bricks = page->bricks;
    fresh->serial = next_->serial_;
    page = Ref<Page>(fresh);
  }
  return *page;
}

Brick& RemovalEditor::editable_brick(Page& page, std::size_t index) {
  Ref<Brick>& brick = page.bricks[index];
  if (brick && brick->serial == next_->serial_) return *brick;
  auto* fresh = new Brick;
  if (brick) {
    fresh->distance = brick->distance;
    fresh->kept = brick->kept;
    fresh->mask = brick->mask;
  } else {
    fresh->distance.fill(static_cast<float>(next_->band_mm_));
    fresh->kept.fill(k_all);
    ++next_->brick_count_;
  }
  fresh->serial = next_->serial_;
  brick = Ref<Brick>(fresh);
  return *brick;
}

RemovalMask& RemovalEditor::editable_mask(Brick& brick, int n) {
  RemovalMask* mask = brick.mask.get();
  if (mask->n < n) brick.mask = Ref<RemovalMask>(mask->refined());
  else if (mask->stroke != stroke_) brick.mask = Ref<RemovalMask>(mask->copy());
  brick.mask->stroke = stroke_;
  return *brick.mask;
}

void RemovalEditor::classify(RemovalMask& mask, const glm::ivec3& low) const {
  // A voxel's cube lies in cells whose corners are its 27 neighbours; a trilinear value lies between its corners'.
  constexpr int k_edge = k_brick + 2;
  for (const Field& field : solids_) {
    bool solid[k_edge][k_edge][k_edge];
    for (int z = 0; z < k_edge; ++z)
      for (int y = 0; y < k_edge; ++y)
        for (int x = 0; x < k_edge; ++x)
          solid[z][y][x] = field.at(low.x + x - 1, low.y + y - 1, low.z + z - 1) >= 0;
    for (int z = 0; z < k_brick; ++z)
      for (int y = 0; y < k_brick; ++y)
        for (int x = 0; x < k_brick; ++x) {
          int count = 0;
          for (int n = 0; n < 27; ++n) count += solid[z + n / 9][y + n / 3 % 3][x + n % 3];
          const std::uint64_t bit = std::uint64_t{1} << (8 * y + x);
          const auto slice = static_cast<std::size_t>(z);
          if (count == 27) mask.base_solid[slice] |= bit;
          if (count > 0) mask.base_air[slice] |= bit;  // not air; turned round below
        }
  }
  for (std::uint64_t& slice : mask.base_air) slice = ~slice;
}

std::int64_t RemovalEditor::count_solid(const RemovalMask& mask, const glm::ivec3& voxel, std::size_t in_brick,
                                        const std::uint64_t* fresh) const {
  const std::uint64_t bit = std::uint64_t{1} << (in_brick % 64);
  const std::size_t slice = in_brick / 64;
  if (mask.base_air[slice] & bit) return 0;
  const int words = mask.words_per_voxel(), n = mask.n;
  std::int64_t count = 0;
  if (mask.base_solid[slice] & bit) {
    for (int w = 0; w < words; ++w) count += std::popcount(fresh[w]);
  } else {
    for (int w = 0; w < words; ++w)
      for (std::uint64_t left = fresh[w]; left != 0; left &= left - 1) {
        const int s = 64 * w + std::countr_zero(left);
        const glm::dvec3 offset(s % n, s / n % n, s / (n * n));
        const glm::dvec3 p = glm::dvec3(voxel) + (offset + 0.5) / static_cast<double>(n) - 0.5;
        for (const Field& field : solids_)
          if (field.value(p) >= 0) {
            ++count;
            break;
          }
      }
  }
  return count * (RemovalLedger::k_units_per_voxel / (n * n * n));
}

RemovalReport RemovalEditor::remove(const Sweep& sweep) {
  RemovalReport report;
  const Volume& base = next_->base();
  const Shape shape(sweep, *next_, samples_per_edge(sweep.radius_mm, base.frame));

  // The box of voxels within radius + band of the sweep: a ball spans |row of the inverse| voxels along an axis.
  const double reach = sweep.radius_mm + next_->band_mm_;
  const glm::dvec3 a = base.frame.volume_from_world(sweep.start_world);
  const glm::dvec3 b = base.frame.volume_from_world(sweep.end_world);
  const glm::dmat3 inverse = glm::inverse(base.frame.axes());
  glm::ivec3 low, high;
  for (int i = 0; i < 3; ++i) {
    const double extent = reach * glm::length(glm::row(inverse, i));
    const double limit = base.size[i] - 1;
    low[i] = static_cast<int>(std::clamp(std::ceil(std::min(a[i], b[i]) - extent), 0.0, limit + 1));
    high[i] = static_cast<int>(std::clamp(std::floor(std::max(a[i], b[i]) + extent), -1.0, limit));
    if (low[i] > high[i]) return report;
  }
  report.box = {low, high};

  const glm::ivec3 first = low / k_brick, last = high / k_brick;
  for (int z = first.z; z <= last.z; ++z)
    for (int y = first.y; y <= last.y; ++y)
      for (int x = first.x; x <= last.x; ++x) {
        const glm::ivec3 corner = k_brick * glm::ivec3(x, y, z);
        const glm::dvec3 middle = base.frame.world_from_volume(glm::dvec3(corner) + 0.5 * (k_brick - 1));
        const glm::vec3 w(middle - sweep.start_world);
        if (shape.distance(w) > shape.band + shape.brick_reach) continue;
        if (sweep.continues && glm::dot(w, shape.along) < -shape.brick_reach) continue;
        remove_in_brick(shape, corner, next_->page_index(corner.x >> 6, corner.y >> 6, corner.z >> 6),
                        Version::brick_index(corner.x, corner.y, corner.z), report);
      }
  return report;
}

void RemovalEditor::remove_in_brick(const Shape& shape, const glm::ivec3& low, std::size_t page_index,
                                    std::size_t index, RemovalReport& report) {
  const Volume& base = next_->base();
  const Page* old_page = next_->pages_[page_index].get();
  const Brick* old = old_page ? old_page->bricks[index].get() : nullptr;
  if (old && old->is_hollow) return;

  // Distances of the sweep alone, then whether any is nearer than what is there.
  alignas(16) float fresh[k_brick_voxels];
  const glm::vec3 corner(base.frame.world_from_volume(glm::dvec3(low)) - shape.sweep.start_world);
  float nearest = shape.band;
  for (int z = 0; z < k_brick; ++z)
    for (int y = 0; y < k_brick; ++y) {
      const glm::vec3 row = corner + static_cast<float>(y) * shape.ay + static_cast<float>(z) * shape.az;
      float* out = fresh + Brick::index(0, y, z);
      for (int x = 0; x < k_brick; ++x) {
        const auto step = static_cast<float>(x);
        const float wx = row.x + step * shape.ax.x, wy = row.y + step * shape.ax.y, wz = row.z + step * shape.ax.z;
        const float wt = wx * shape.along.x + wy * shape.along.y + wz * shape.along.z;
        const float t = std::min(std::max(wt, 0.0f), shape.length);
        const float qx = wx - t * shape.along.x, qy = wy - t * shape.along.y, qz = wz - t * shape.along.z;
        out[x] = std::sqrt(qx * qx + qy * qy + qz * qz) - shape.radius;
      }
      for (int x = 0; x < k_brick; ++x) nearest = std::min(nearest, out[x]);
    }
  if (nearest >= shape.band) return;
  bool is_changed = old == nullptr;
  for (std::size_t i = 0; i < k_brick_voxels && !is_changed; ++i)
    is_changed = std::max(fresh[i], -shape.band) < old->distance[i];

  Brick* brick = nullptr;
  if (is_changed) {
    brick = &editable_brick(editable_page(page_index), index);
    for (std::size_t i = 0; i < k_brick_voxels; ++i)
      brick->distance[i] = std::min(brick->distance[i], std::max(fresh[i], -shape.band));
    for (std::size_t z = 0; z < k_brick; ++z) {
      std::uint64_t kept = 0;
      for (std::size_t i = 0; i < 64; ++i) kept |= static_cast<std::uint64_t>(brick->distance[64 * z + i] > 0) << i;
      brick->kept[z] = kept;
    }
  }

  // Masks: voxels wholly inside are filled, those on the surface sampled; behind a continued sweep all is done.
  if (nearest >= shape.voxel_reach) {
    if (is_changed) ++report.bricks_changed;
    return;
  }
  RemovalMask* mask = nullptr;
  const RemovalMask* seen = brick ? brick->mask.get() : old->mask.get();
  bool is_hollow = true;
  for (int v = 0; v < k_brick_voxels; ++v) {
    const float d = fresh[v];
    if (d > -shape.band) is_hollow = false;
    if (d >= shape.voxel_reach) continue;
    const glm::ivec3 in(v % k_brick, v / k_brick % k_brick, v / (k_brick * k_brick));
    const auto voxel = static_cast<std::size_t>(v);
    if (seen) {
      const auto words = static_cast<std::size_t>(seen->words_per_voxel());
      const std::uint64_t* at = seen->words.data() + voxel * words;
      if (std::all_of(at, at + words, [](std::uint64_t word) { return word == k_all; })) continue;
    }
    const glm::vec3 c = corner + static_cast<float>(in.x) * shape.ax + static_cast<float>(in.y) * shape.ay +
                        static_cast<float>(in.z) * shape.az;
    if (shape.sweep.continues && glm::dot(c, shape.along) < -shape.voxel_reach) continue;
    if (mask == nullptr) {
      if (brick == nullptr) brick = &editable_brick(editable_page(page_index), index);
      if (!brick->mask) {
        brick->mask = Ref<RemovalMask>(new RemovalMask(shape.n));
        classify(*brick->mask, low);
        brick->mask->stroke = stroke_;
      }
      mask = &editable_mask(*brick, shape.n);
      seen = mask;
    }
    const auto words = static_cast<std::size_t>(mask->words_per_voxel());
    std::uint64_t samples[8];
    if (d <= -shape.voxel_reach) {
      std::fill(samples, samples + words, k_all);
    } else if (mask->n == shape.n) {
      shape.sample(c, samples);
    } else {
      Shape(shape.sweep, *next_, mask->n).sample(c, samples);  // a large ball where a small one was: rare
    }
    std::uint64_t* at = mask->words.data() + voxel * words;
    std::uint64_t any = 0;
    for (std::size_t w = 0; w < words; ++w) {
      samples[w] &= ~at[w];
      any |= samples[w];
      at[w] |= samples[w];
    }
    if (any == 0) continue;
    const glm::ivec3 where = low + in;
    if (!base.contains(where)) continue;
    const std::int64_t units = count_solid(*mask, where, voxel, samples);
    const std::size_t label = base.labels.is_empty() ? 0 : base.labels[base.index(where.x, where.y, where.z)];
    next_->ledger_.units_by_label[std::min(label, next_->ledger_.units_by_label.size() - 1)] += units;
    report.removed_units += units;
  }
  if (is_hollow && brick) brick->is_hollow = true;
  if (brick) ++report.bricks_changed;
}

}  // namespace trephine::volume
