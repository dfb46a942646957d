#include "volume/removal.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <emmintrin.h>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_access.hpp>
#include <glm/matrix.hpp>

namespace trephine::volume {

namespace {

constexpr std::uint64_t k_all = ~std::uint64_t{0};

/// Largest fineness a mask has; 4 where the ball spans many voxels, 8 where it is small.
int samples_per_edge(double radius_mm, const Frame& frame) {
  const glm::dvec3 s = frame.spacing();
  return radius_mm < 4 * std::max({s.x, s.y, s.z}) ? 8 : 4;
}

}  // namespace

/// What one call to remove() needs everywhere.
struct RemovalEditor::Shape : SweepShape {
  Sweep sweep;

  Shape(const Sweep& s, const Version& version, int fineness) : sweep(s) {
    const Frame& frame = version.base().frame;
    n = fineness;
    radius = static_cast<float>(s.radius_mm);
    band = static_cast<float>(version.band_mm());
    const glm::dvec3 d = s.end_world - s.start_world;
    const double l = glm::length(d);
    length = static_cast<float>(l);
    for (int a = 0; a < 3; ++a) {
      along[a] = l > 0 ? static_cast<float>(d[a] / l) : 0.0f;
      ax[a] = static_cast<float>(frame.axes()[0][a]);
      ay[a] = static_cast<float>(frame.axes()[1][a]);
      az[a] = static_cast<float>(frame.axes()[2][a]);
    }
    voxel_reach = static_cast<float>(0.5 * frame.diagonal_mm() * 1.0001 + 1e-5);
    for (int i = 0; i < n * n * n; ++i) {
      const auto offset = [this](int k) {
        return (static_cast<float>(k) + 0.5f) / static_cast<float>(n) - 0.5f;
      };
      offset_x[i] = offset(i % n), offset_y[i] = offset(i / n % n), offset_z[i] = offset(i / (n * n));
      float square = 0;
      for (int a = 0; a < 3; ++a) {
        const float o = offset_x[i] * ax[a] + offset_y[i] * ay[a] + offset_z[i] * az[a];
        square += o * o;
      }
      offset_squared[i] = square;
    }
  }

  static float dot(const glm::vec3& v, const float* w) { return v.x * w[0] + v.y * w[1] + v.z * w[2]; }
  float projection(const glm::vec3& w) const { return dot(w, along); }
  /// Half the extent of a brick's voxel centres along a unit direction.
  float brick_extent(const glm::vec3& direction) const {
    constexpr float k_half = 0.5f * (k_brick - 1);
    return k_half *
               (std::abs(dot(direction, ax)) + std::abs(dot(direction, ay)) + std::abs(dot(direction, az))) +
           1e-4f;
  }
  float brick_extent_along() const { return brick_extent({along[0], along[1], along[2]}); }
  /// Is nothing to do in the brick whose middle is at w? It lies beyond the band, by the plane through the
  /// nearest point of the sweep's axis, or wholly behind a continued sweep.
  bool misses_brick(const glm::vec3& w) const {
    const float wt = projection(w);
    if (sweep.continues && length > 0 && wt < -brick_extent_along() - voxel_reach) return true;
    const glm::vec3 q = w - std::clamp(wt, 0.0f, length) * glm::vec3(along[0], along[1], along[2]);
    const float far = std::sqrt(glm::dot(q, q));
    return far > 0 && far - brick_extent(q / far) > radius + band;
  }
  glm::vec3 voxel_step(float x, float y, float z) const {
    return {x * ax[0] + y * ay[0] + z * az[0], x * ax[1] + y * ay[1] + z * az[1],
            x * ax[2] + y * ay[2] + z * az[2]};
  }
};

RemovalEditor::RemovalEditor(std::shared_ptr<const Version> start, std::vector<Field> solids,
                             const RemovalKernels& kernels)
    : solids_(std::move(solids)), kernels_(&kernels) {
  reset(std::move(start));
}

RemovalEditor::RemovalEditor(const RemovalEditor& other)
    : next_(std::make_shared<Version>(*other.next_)),
      solids_(other.solids_),
      kernels_(other.kernels_),
      stroke_(other.stroke_) {}

RemovalEditor& RemovalEditor::operator=(const RemovalEditor& other) {
  RemovalEditor copy(other);
  return *this = std::move(copy);
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

void RemovalEditor::remove_in_brick(const Shape& shape, const glm::ivec3& low, std::size_t page_index,
                                    std::size_t index, RemovalReport& report) {
  const Volume& base = next_->base();
  const Page* old_page = next_->pages_[page_index].get();
  const Brick* old = old_page ? old_page->bricks[index].get() : nullptr;
  if (old && old->is_hollow) return;
  const glm::vec3 corner(base.frame.world_from_volume(glm::dvec3(low)) - shape.sweep.start_world);
  const glm::vec3 middle = corner + shape.voxel_step(3.5f, 3.5f, 3.5f);
  const bool is_ball = shape.projection(middle) - shape.brick_extent_along() >= shape.length;
  BrickSweep sweep;
  kernels_->sweep_brick(shape, &corner.x, is_ball, old ? old->distance.data() : nullptr, sweep);
  if (!sweep.is_in_band) return;

  Brick* brick = nullptr;
  if (sweep.is_nearer) {
    brick = &editable_brick(editable_page(page_index), index);
    std::memcpy(brick->distance.data(), sweep.distance, sizeof sweep.distance);
    std::copy_n(sweep.kept, k_brick, brick->kept.begin());
  }

  // Masks: voxels wholly inside are filled, those on the surface sampled; behind a continued sweep all is
  // done.
  RemovalMask* mask = nullptr;
  for (std::size_t z = 0; z < k_brick; ++z) {
    const RemovalMask* seen = brick ? brick->mask.get() : old ? old->mask.get() : nullptr;
    const std::uint64_t ahead = shape.sweep.continues ? sweep.ahead[z] : k_all;
    for (std::uint64_t left = sweep.touched[z] & ahead & ~(seen ? seen->full[z] : 0); left != 0;
         left &= left - 1) {
      const int bit = std::countr_zero(left);
      const glm::ivec3 in(bit % k_brick, bit / k_brick, static_cast<int>(z));
      const glm::vec3 c = corner + shape.voxel_step(static_cast<float>(in.x), static_cast<float>(in.y),
                                                    static_cast<float>(in.z));
      if (mask == nullptr) {
        if (brick == nullptr) brick = &editable_brick(editable_page(page_index), index);
        if (!brick->mask) {
          brick->mask = Ref<RemovalMask>(new RemovalMask(shape.n));
          classify(*brick->mask, low);
          brick->mask->stroke = stroke_;
        }
        mask = &editable_mask(*brick, shape.n);
      }
      std::uint64_t samples[8];
      if (sweep.inside[z] >> bit & 1)
        std::fill_n(samples, mask->words_per_voxel(), k_all);
      else if (mask->n == shape.n)
        kernels_->sample(shape, &c.x, (sweep.past_end[z] >> bit & 1) != 0, samples);
      else
        kernels_->sample(Shape(shape.sweep, *next_, mask->n), &c.x, false,
                         samples);  // a large ball where a small one was
      report.removed_units += mark(*mask, low + in, 64 * z + static_cast<std::size_t>(bit), samples);
    }
  }
  if (brick) {
    brick->is_hollow = sweep.is_hollow;
    ++report.bricks_changed;
  }
}

std::int64_t RemovalEditor::mark(RemovalMask& mask, const glm::ivec3& voxel, std::size_t in_brick,
                                 std::uint64_t* samples) {
  const auto words = static_cast<std::size_t>(mask.words_per_voxel());
  std::uint64_t* at = mask.words.data() + in_brick * words;
  std::uint64_t any = 0, all = k_all;
  for (std::size_t w = 0; w < words; ++w) {
    samples[w] &= ~at[w];
    any |= samples[w];
  }
  if (any == 0) return 0;
  for (std::size_t w = 0; w < words; ++w) all &= at[w] |= samples[w];
  if (all == k_all) mask.full[in_brick / 64] |= std::uint64_t{1} << (in_brick % 64);
  const Volume& base = next_->base();
  if (!base.contains(voxel)) return 0;
  const std::int64_t units = count_solid(mask, voxel, in_brick, samples);
  const std::size_t label = base.labels.is_empty() ? 0 : base.labels[base.index(voxel.x, voxel.y, voxel.z)];
  std::vector<std::int64_t>& ledger = next_->ledger_.units_by_label;
  ledger[std::min(label, ledger.size() - 1)] += units;
  return units;
}

}  // namespace trephine::volume
