#include "volume/fields/quadratic_patch.h"

#include "volume/base/cpu.h"

namespace trephine::volume {

namespace {

/// Converts four int16 to two pairs of doubles.
void widen(const std::int16_t* row, __m128d& low, __m128d& high) noexcept {
  const __m128i packed = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(row));
  const __m128i wide = _mm_srai_epi32(_mm_unpacklo_epi16(packed, packed), 16);
  low = _mm_cvtepi32_pd(wide);
  high = _mm_cvtepi32_pd(_mm_shuffle_epi32(wide, _MM_SHUFFLE(3, 2, 3, 2)));
}

}  // namespace

void QuadraticPatch::load(const Field& field, const glm::ivec3& v) noexcept {
  const Volume& volume = field.volume();
  const Shape& shape = field.shape();
  const glm::ivec3& size = volume.size;
  const bool is_inside =
      v.x >= 1 && v.y >= 1 && v.z >= 1 && v.x + 1 < size.x && v.y + 1 < size.y && v.z + 1 < size.z;
  if (is_inside && !shape.is_label()) {
    const std::size_t row = static_cast<std::size_t>(size.x), slice = row * static_cast<std::size_t>(size.y);
    const std::size_t first = volume.index(v.x - 1, v.y - 1, v.z - 1);
    if (first + 2 * slice + 2 * row + 3 <
        volume.window_voxels().size()) {  // the fourth sample of the last row is readable
      const std::int16_t* base = volume.window_voxels().data() + first;
      const __m128d from = _mm_set1_pd(shape.low), to = _mm_set1_pd(shape.high);
      const bool is_open = shape.high > 1e300;
      for (std::size_t k = 0; k < 3; ++k)
        for (std::size_t j = 0; j < 3; ++j) {
          __m128d low, high;
          widen(base + k * slice + j * row, low, high);
          Lanes g(_mm_sub_pd(low, from), _mm_sub_pd(high, from));
          if (!is_open) g = smaller(g, Lanes(_mm_sub_pd(to, low), _mm_sub_pd(to, high)));
          rows_[k][j] = g;
        }
      return;
    }
  }
  for (int k = 0; k < 3; ++k)
    for (int j = 0; j < 3; ++j) {
      const int y = v.y + j - 1, z = v.z + k - 1;
      rows_[k][j] = Lanes(field.at(v.x - 1, y, z), field.at(v.x, y, z), field.at(v.x + 1, y, z));
    }
}

void QuadraticPatch::load_distance(const Version& version, const glm::ivec3& s) noexcept {
  const int bx = s.x & (k_brick - 1), by = s.y & (k_brick - 1), bz = s.z & (k_brick - 1);
  const auto is_within = [](int b) { return b >= 1 && b + 2 < k_brick; };
  if (is_within(bx) && is_within(by) && is_within(bz) && version.lattice().contains(s)) {
    if (const Brick* brick = version.brick_at(s)) {
      for (int k = 0; k < 3; ++k)
        for (int j = 0; j < 3; ++j) {
          const __m128 four =
              _mm_loadu_ps(brick->distance.data() + Brick::index(bx - 1, by + j - 1, bz + k - 1));
          rows_[k][j] = Lanes(_mm_cvtps_pd(four), _mm_cvtps_pd(_mm_movehl_ps(four, four)));
        }
      return;
    }
  }
  const glm::ivec3 low = s - 1, high = s + 1;
  if (!version.lattice().contains(low) || !version.lattice().contains(high)) {
    for (int k = 0; k < 3; ++k)
      for (int j = 0; j < 3; ++j) {
        const int y = low.y + j, z = low.z + k;
        rows_[k][j] = Lanes(version.sample_distance({low.x, y, z}), version.sample_distance({s.x, y, z}),
                            version.sample_distance({high.x, y, z}));
      }
    return;
  }
  // The samples are in one or two bricks along each axis. Finds these bricks, then reads the samples.
  const glm::ivec3 parts = high / k_brick - low / k_brick;
  const Brick* bricks[8] = {};
  for (int c = 0; c < 8; ++c)
    if ((c & 1) <= parts.x && (c >> 1 & 1) <= parts.y && (c >> 2) <= parts.z)
      bricks[c] = version.brick_at({c & 1 ? high.x : low.x, c & 2 ? high.y : low.y, c & 4 ? high.z : low.z});
  const auto part = [](int at, int from) { return at / k_brick - from / k_brick; };
  const int px[3] = {0, part(s.x, low.x), parts.x};
  const double uncut = version.band_mm();
  for (int k = 0; k < 3; ++k)
    for (int j = 0; j < 3; ++j) {
      const int y = low.y + j, z = low.z + k;
      const int corner = 2 * part(y, low.y) + 4 * part(z, low.z);
      const std::size_t row = Brick::index(0, y & (k_brick - 1), z & (k_brick - 1));
      const auto at = [&](int i) {
        const Brick* brick = bricks[corner + px[i]];
        return brick ? static_cast<double>(
                           brick->distance[row + static_cast<std::size_t>((low.x + i) & (k_brick - 1))])
                     : uncut;
      };
      rows_[k][j] = Lanes(at(0), at(1), at(2));
    }
}

Jet cut_jet(const Version& version, const glm::dvec3& p) noexcept {
  const CutLattice::Point at = version.lattice().point_of(p);
  QuadraticPatch patch;
  patch.load_distance(version, at.sample);
  Jet jet = patch.jet(at.at);
  rescale(jet, version.lattice().scale());
  return jet;
}

const bool k_has_wide_patches = uses_avx2();

QuadraticPatch::HessianBound QuadraticPatch::hessian_bound() const noexcept {
  if (k_has_wide_patches) {
    double out[6];
    hessian_bound_of_patch_wide(samples(), out);
    return {{out[0], out[1], out[2]}, {out[3], out[4], out[5]}};
  }
  return narrow_hessian_bound();
}

QuadraticPatch::HessianBound QuadraticPatch::narrow_hessian_bound() const noexcept {
  const auto second = [](const Lanes& a, const Lanes& b, const Lanes& c) { return magnitude(a - b - b + c); };
  Lanes yy(0, 0, 0), zz = yy, yz = yy, xy = yy, xz = yy;
  double xx = 0;
  for (int k = 0; k < 3; ++k) {
    yy = larger(yy, second(rows_[k][0], rows_[k][1], rows_[k][2]));
    zz = larger(zz, second(rows_[0][k], rows_[1][k], rows_[2][k]));
    for (int j = 0; j < 3; ++j) {
      const Lanes step = rows_[k][j].step();
      xx = std::max(xx, std::abs(step.second() - step.first()));
    }
    for (int j = 0; j < 2; ++j) {
      xy = larger(xy, magnitude((rows_[k][j + 1] - rows_[k][j]).step()));
      xz = larger(xz, magnitude((rows_[j + 1][k] - rows_[j][k]).step()));
    }
  }
  for (int k = 0; k < 2; ++k)
    for (int j = 0; j < 2; ++j)
      yz = larger(yz, magnitude(rows_[k + 1][j + 1] - rows_[k + 1][j] - rows_[k][j + 1] + rows_[k][j]));
  const auto max2 = [](const Lanes& a) { return std::max(a.first(), a.second()); };
  return {{xx, yy.max3(), zz.max3()}, {yz.max3(), max2(xz), max2(xy)}};
}

double QuadraticPatch::minimum() const noexcept {
  Lanes minimum = rows_[0][0];
  for (int k = 0; k < 3; ++k)
    for (int j = 0; j < 3; ++j) minimum = smaller(minimum, rows_[k][j]);
  return std::min(std::min(minimum.first(), minimum.second()), minimum.third());
}

double QuadraticPatch::maximum() const noexcept {
  Lanes maximum = rows_[0][0];
  for (int k = 0; k < 3; ++k)
    for (int j = 0; j < 3; ++j) maximum = larger(maximum, rows_[k][j]);
  return maximum.max3();
}

}  // namespace trephine::volume
