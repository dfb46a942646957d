#include "volume/removal.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <emmintrin.h>
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

/// Everything in mm relative to the start of the sweep, single precision: a sweep and its ball are tens of
/// mm.
struct RemovalEditor::Shape {
  Sweep sweep;
  int n;                       // mask fineness
  float radius, band, length;  // mm
  glm::vec3 along;             // unit direction of the sweep, or 0
  glm::vec3 ax, ay, az;        // a voxel step
  float voxel_reach;           // half a voxel's diagonal, with a margin for rounding
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
    for (int i = 0; i < n; ++i) offset[i] = (static_cast<float>(i) + 0.5f) / static_cast<float>(n) - 0.5f;
    for (int k = 0; k < n; ++k)
      for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
          const glm::vec3 o = offset[i] * ax + offset[j] * ay + offset[k] * az;
          offset_squared[(k * n + j) * n + i] = glm::dot(o, o);
        }
  }

  /// Half the extent of a brick's voxel centres along a unit direction.
  float brick_extent(const glm::vec3& n) const {
    constexpr float k_half = 0.5f * (k_brick - 1);
    return k_half * (std::abs(glm::dot(n, ax)) + std::abs(glm::dot(n, ay)) + std::abs(glm::dot(n, az))) +
           1e-4f;
  }
  /// Is nothing to do in the brick whose middle is at w? It lies beyond the band, by the plane through the
  /// nearest point of the sweep's axis, or wholly behind a continued sweep.
  bool misses_brick(const glm::vec3& w) const {
    const float wt = glm::dot(w, along);
    if (sweep.continues && length > 0 && wt < -brick_extent(along) - voxel_reach) return true;
    const glm::vec3 q = w - std::clamp(wt, 0.0f, length) * along;
    const float far = std::sqrt(glm::dot(q, q));
    return far > 0 && far - brick_extent(q / far) > radius + band;
  }

  /// Which samples of the voxel centred at c lie in the swept ball; n^3 bits into `words`.
  /// Squared distances by the expansion |c + o|^2 = |c|^2 + 2 c.o + |o|^2.
  void sample(const glm::vec3& c, std::uint64_t* words) const {
    const float projection = glm::dot(c, along);
    const bool is_past_end = projection >= length + voxel_reach || length == 0;
    const glm::vec3 from = is_past_end ? c - length * along : c;
    if (is_past_end)
      n == 4 ? sample_ball<4>(from, words) : sample_ball<8>(from, words);
    else
      n == 4 ? sample_capsule<4>(from, words) : sample_capsule<8>(from, words);
  }

 private:
  /// Sixteen comparisons with 0 as sixteen bits.
  static std::uint64_t bits_of(const __m128* d) {
    const __m128 zero = _mm_setzero_ps();
    const auto is_in = [&](int i) { return _mm_castps_si128(_mm_cmple_ps(d[i], zero)); };
    const __m128i packed =
        _mm_packs_epi16(_mm_packs_epi32(is_in(0), is_in(1)), _mm_packs_epi32(is_in(2), is_in(3)));
    return static_cast<std::uint64_t>(_mm_movemask_epi8(packed));
  }
  template <int N>
  void sample_ball(const glm::vec3& c, std::uint64_t* words) const {
    const float cc = glm::dot(c, c) - radius * radius;
    const float y = 2 * glm::dot(c, ay), z = 2 * glm::dot(c, az);
    const __m128 x = _mm_set1_ps(2 * glm::dot(c, ax));
    const __m128 ox[2] = {_mm_mul_ps(_mm_load_ps(offset), x), _mm_mul_ps(_mm_load_ps(offset + 4), x)};
    __m128 d[4];
    int at = 0;
    for (int k = 0; k < N; ++k)
      for (int j = 0; j < N; ++j) {
        const __m128 base = _mm_set1_ps(cc + (offset[j] * y + offset[k] * z));
        for (int i = 0; i < N / 4; ++i, ++at) {
          d[at & 3] = _mm_add_ps(_mm_add_ps(base, ox[i]), _mm_load_ps(offset_squared + 4 * at));
          if ((at & 3) == 3) put(bits_of(d), at / 4, words);
        }
      }
  }
  template <int N>
  void sample_capsule(const glm::vec3& c, std::uint64_t* words) const {
    const float cc = glm::dot(c, c) - radius * radius, ct = glm::dot(c, along);
    const float y = 2 * glm::dot(c, ay), z = 2 * glm::dot(c, az);
    const float ty = glm::dot(ay, along), tz = glm::dot(az, along);
    const __m128 x = _mm_set1_ps(2 * glm::dot(c, ax)), tx = _mm_set1_ps(glm::dot(ax, along));
    const __m128 ox[2] = {_mm_mul_ps(_mm_load_ps(offset), x), _mm_mul_ps(_mm_load_ps(offset + 4), x)};
    const __m128 otx[2] = {_mm_mul_ps(_mm_load_ps(offset), tx), _mm_mul_ps(_mm_load_ps(offset + 4), tx)};
    const __m128 zero = _mm_setzero_ps(), end = _mm_set1_ps(length);
    __m128 d[4];
    int at = 0;
    for (int k = 0; k < N; ++k)
      for (int j = 0; j < N; ++j) {
        const __m128 base = _mm_set1_ps(cc + (offset[j] * y + offset[k] * z));
        const __m128 base_t = _mm_set1_ps(ct + (offset[j] * ty + offset[k] * tz));
        for (int i = 0; i < N / 4; ++i, ++at) {
          const __m128 ww = _mm_add_ps(_mm_add_ps(base, ox[i]), _mm_load_ps(offset_squared + 4 * at));
          const __m128 wt = _mm_add_ps(base_t, otx[i]);
          const __m128 t = _mm_min_ps(_mm_max_ps(wt, zero), end);
          // |w - t u|^2 = |w|^2 + t (t - 2 w.u)
          d[at & 3] = _mm_add_ps(ww, _mm_mul_ps(t, _mm_sub_ps(t, _mm_add_ps(wt, wt))));
          if ((at & 3) == 3) put(bits_of(d), at / 4, words);
        }
      }
  }
  /// Sixteen samples, the `part`th of a voxel's; parts come in order.
  static void put(std::uint64_t bits, int part, std::uint64_t* words) {
    std::uint64_t& word = words[part / 4];
    word = part % 4 == 0 ? bits : word | bits << (16 * (part % 4));
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
  if (mask->n < n)
    brick.mask = Ref<RemovalMask>(mask->refined());
  else if (mask->stroke != stroke_)
    brick.mask = Ref<RemovalMask>(mask->copy());
  brick.mask->stroke = stroke_;
  return *brick.mask;
}

void RemovalEditor::classify(RemovalMask& mask, const glm::ivec3& low) const {
  // A voxel's cube lies in cells whose corners are its 27 neighbours; a trilinear value lies between its
  // corners'. Rows of ten bits, ANDed (ORed) with their neighbours along x, then over nine rows.
  constexpr int k_edge = k_brick + 2;
  for (const Field& field : solids_) {
    std::array<std::array<unsigned, k_edge>, k_edge> all, any;
    for (std::size_t z = 0; z < k_edge; ++z)
      for (std::size_t y = 0; y < k_edge; ++y) {
        unsigned row = 0;
        for (int x = 0; x < k_edge; ++x)
          row |= static_cast<unsigned>(field.at(low.x + x - 1, low.y + static_cast<int>(y) - 1,
                                                low.z + static_cast<int>(z) - 1) >= 0)
                 << x;
        all[z][y] = row & row >> 1 & row >> 2;
        any[z][y] = row | row >> 1 | row >> 2;
      }
    for (std::size_t z = 0; z < k_brick; ++z)
      for (std::size_t y = 0; y < k_brick; ++y) {
        unsigned solid = 0xff, touched = 0;
        for (std::size_t n = 0; n < 9; ++n) {
          solid &= all[z + n / 3][y + n % 3];
          touched |= any[z + n / 3][y + n % 3];
        }
        mask.base_solid[z] |= static_cast<std::uint64_t>(solid & 0xff) << (8 * y);
        mask.base_air[z] |= static_cast<std::uint64_t>(touched & 0xff)
                            << (8 * y);  // not air; turned round below
      }
  }
  for (std::uint64_t& slice : mask.base_air) slice = ~slice;
}

std::int64_t RemovalEditor::count_solid(const RemovalMask& mask, const glm::ivec3& voxel,
                                        std::size_t in_brick, const std::uint64_t* fresh) const {
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

  // The box of voxels within radius + band of the sweep: a ball spans |row of the inverse| voxels along an
  // axis.
  const double reach = sweep.radius_mm + next_->band_mm_;
  const glm::dvec3 a = base.frame.volume_from_world(sweep.start_world);
  const glm::dvec3 b = base.frame.volume_from_world(sweep.end_world);
  const glm::dmat3 inverse = glm::inverse(base.frame.axes());
  glm::ivec3 low(0), high(0);
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
        if (shape.misses_brick(w)) continue;
        remove_in_brick(shape, corner, next_->page_index(corner.x >> 6, corner.y >> 6, corner.z >> 6),
                        Version::brick_index(corner.x, corner.y, corner.z), report);
      }
  return report;
}

/// A brick's worth of distances to one sweep, and what follows from them, as bits laid out like Brick::kept.
struct RemovalEditor::BrickSweep {
  alignas(16) std::array<float, k_brick_voxels> distance;  // mm, clamped below at -band
  std::array<std::uint64_t, k_brick> touched;              // the voxel's cube may meet the swept ball
  std::array<std::uint64_t, k_brick> inside;               // the voxel's cube lies in it
  bool is_in_band = false, is_nearer = false, is_hollow = true;

  /// `corner`: centre of the brick's first voxel, relative to the sweep's start; `old`: distances so far, or
  /// null.
  BrickSweep(const Shape& shape, const glm::vec3& corner, const float* old) {
    const __m128 zero = _mm_setzero_ps(), length = _mm_set1_ps(shape.length),
                 radius = _mm_set1_ps(shape.radius);
    const __m128 band = _mm_set1_ps(shape.band), deep = _mm_set1_ps(-shape.band);
    const __m128 reach = _mm_set1_ps(shape.voxel_reach), within = _mm_set1_ps(-shape.voxel_reach);
    const __m128 ux = _mm_set1_ps(shape.along.x), uy = _mm_set1_ps(shape.along.y),
                 uz = _mm_set1_ps(shape.along.z);
    const __m128 lane[2] = {_mm_setr_ps(0, 1, 2, 3), _mm_setr_ps(4, 5, 6, 7)};
    const auto steps = [&lane](float step) {
      return std::array{_mm_mul_ps(lane[0], _mm_set1_ps(step)), _mm_mul_ps(lane[1], _mm_set1_ps(step))};
    };
    const std::array step_x = steps(shape.ax.x), step_y = steps(shape.ax.y), step_z = steps(shape.ax.z);
    // A brick wholly past the sweep's end sees a ball.
    const glm::vec3 middle = corner + 0.5f * (k_brick - 1) * (shape.ax + shape.ay + shape.az);
    const bool is_ball = glm::dot(middle, shape.along) - shape.brick_extent(shape.along) >= shape.length;
    const glm::vec3 from = is_ball ? corner - shape.length * shape.along : corner;
    int near = 0, nearer = 0, shallow = 0;
    for (int z = 0; z < k_brick; ++z) {
      std::uint64_t touched_slice = 0, inside_slice = 0;
      for (int y = 0; y < k_brick; ++y) {
        const glm::vec3 row = from + static_cast<float>(y) * shape.ay + static_cast<float>(z) * shape.az;
        for (std::size_t half = 0; half < 2; ++half) {
          const std::size_t at = Brick::index(0, y, z) + 4 * half;
          __m128 qx = _mm_add_ps(_mm_set1_ps(row.x), step_x[half]),
                 qy = _mm_add_ps(_mm_set1_ps(row.y), step_y[half]);
          __m128 qz = _mm_add_ps(_mm_set1_ps(row.z), step_z[half]);
          if (!is_ball) {
            const __m128 wt =
                _mm_add_ps(_mm_add_ps(_mm_mul_ps(qx, ux), _mm_mul_ps(qy, uy)), _mm_mul_ps(qz, uz));
            const __m128 t = _mm_min_ps(_mm_max_ps(wt, zero), length);
            qx = _mm_sub_ps(qx, _mm_mul_ps(t, ux)), qy = _mm_sub_ps(qy, _mm_mul_ps(t, uy)),
            qz = _mm_sub_ps(qz, _mm_mul_ps(t, uz));
          }
          const __m128 square =
              _mm_add_ps(_mm_add_ps(_mm_mul_ps(qx, qx), _mm_mul_ps(qy, qy)), _mm_mul_ps(qz, qz));
          const __m128 d = _mm_max_ps(_mm_sub_ps(_mm_sqrt_ps(square), radius), deep);
          _mm_store_ps(distance.data() + at, d);
          near |= _mm_movemask_ps(_mm_cmplt_ps(d, band));
          shallow |= _mm_movemask_ps(_mm_cmpgt_ps(d, deep));
          if (old) nearer |= _mm_movemask_ps(_mm_cmplt_ps(d, _mm_loadu_ps(old + at)));
          const int bit = 8 * y + 4 * static_cast<int>(half);
          touched_slice |= static_cast<std::uint64_t>(_mm_movemask_ps(_mm_cmplt_ps(d, reach))) << bit;
          inside_slice |= static_cast<std::uint64_t>(_mm_movemask_ps(_mm_cmple_ps(d, within))) << bit;
        }
      }
      touched[static_cast<std::size_t>(z)] = touched_slice;
      inside[static_cast<std::size_t>(z)] = inside_slice;
    }
    is_in_band = near != 0;
    is_nearer = old == nullptr || nearer != 0;
    is_hollow = shallow == 0;
  }
};

void RemovalEditor::remove_in_brick(const Shape& shape, const glm::ivec3& low, std::size_t page_index,
                                    std::size_t index, RemovalReport& report) {
  const Volume& base = next_->base();
  const Page* old_page = next_->pages_[page_index].get();
  const Brick* old = old_page ? old_page->bricks[index].get() : nullptr;
  if (old && old->is_hollow) return;
  const glm::vec3 corner(base.frame.world_from_volume(glm::dvec3(low)) - shape.sweep.start_world);
  const BrickSweep sweep(shape, corner, old ? old->distance.data() : nullptr);
  if (!sweep.is_in_band) return;

  // Distances: the nearer of old and new, and the bits that follow.
  Brick* brick = nullptr;
  if (sweep.is_nearer) {
    brick = &editable_brick(editable_page(page_index), index);
    const __m128 zero = _mm_setzero_ps();
    for (std::size_t z = 0; z < k_brick; ++z) {
      std::uint64_t kept = 0;
      for (std::size_t i = 0; i < 64; i += 4) {
        float* at = brick->distance.data() + 64 * z + i;
        const __m128 d = _mm_min_ps(_mm_loadu_ps(at), _mm_load_ps(sweep.distance.data() + 64 * z + i));
        _mm_storeu_ps(at, d);
        kept |= static_cast<std::uint64_t>(_mm_movemask_ps(_mm_cmpgt_ps(d, zero))) << i;
      }
      brick->kept[z] = kept;
    }
  }

  // Masks: voxels wholly inside are filled, those on the surface sampled; behind a continued sweep all is
  // done.
  RemovalMask* mask = nullptr;
  for (std::size_t z = 0; z < k_brick; ++z) {
    const RemovalMask* seen = brick ? brick->mask.get() : old ? old->mask.get() : nullptr;
    for (std::uint64_t left = sweep.touched[z] & ~(seen ? seen->full[z] : 0); left != 0; left &= left - 1) {
      const int bit = std::countr_zero(left);
      const glm::ivec3 in(bit % k_brick, bit / k_brick, static_cast<int>(z));
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
      }
      report.removed_units += mark(shape, *mask, low + in, 64 * z + static_cast<std::size_t>(bit), c,
                                   (sweep.inside[z] >> bit & 1) != 0);
    }
  }
  if (brick) {
    brick->is_hollow = sweep.is_hollow;
    ++report.bricks_changed;
  }
}

std::int64_t RemovalEditor::mark(const Shape& shape, RemovalMask& mask, const glm::ivec3& voxel,
                                 std::size_t in_brick, const glm::vec3& centre, bool is_inside) {
  const auto words = static_cast<std::size_t>(mask.words_per_voxel());
  std::uint64_t samples[8];
  if (is_inside)
    std::fill(samples, samples + words, k_all);
  else if (mask.n == shape.n)
    shape.sample(centre, samples);
  else
    Shape(shape.sweep, *next_, mask.n).sample(centre, samples);  // a large ball where a small one was: rare
  std::uint64_t* at = mask.words.data() + in_brick * words;
  std::uint64_t any = 0, all = k_all;
  for (std::size_t w = 0; w < words; ++w) {
    samples[w] &= ~at[w];
    at[w] |= samples[w];
    any |= samples[w];
    all &= at[w];
  }
  if (all == k_all) mask.full[in_brick / 64] |= std::uint64_t{1} << (in_brick % 64);
  const Volume& base = next_->base();
  if (any == 0 || !base.contains(voxel)) return 0;
  const std::int64_t units = count_solid(mask, voxel, in_brick, samples);
  const std::size_t label = base.labels.is_empty() ? 0 : base.labels[base.index(voxel.x, voxel.y, voxel.z)];
  std::vector<std::int64_t>& ledger = next_->ledger_.units_by_label;
  ledger[std::min(label, ledger.size() - 1)] += units;
  return units;
}

}  // namespace trephine::volume
