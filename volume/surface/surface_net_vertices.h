// NetVertices: vertices of a surface net, with equal bits for the whole surface, a chunk and a single cell.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <emmintrin.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "volume/scan/trilinear.h"
#include "volume/surface/surface_net_cases.h"
#include "volume/surface/surface_nets.h"

namespace trephine::volume {

/// Position of the cut on the edge from kept voxel `solid` (0) to its neighbour `air` (1), linear between the
/// samples on the edge; above 1 if there is no cut.
inline float cut_crossing(const Version& version, const glm::ivec3& solid, const glm::ivec3& air) noexcept {
  const CutLattice& lattice = version.lattice();
  const glm::ivec3 step = air - solid, start = lattice.centre_of(solid);
  const glm::ivec3 length = glm::abs(step) * lattice.per_voxel();
  const int count = std::max({length.x, length.y, length.z});
  auto previous = static_cast<float>(version.sample_distance(start));
  for (int i = 1; i <= count; ++i) {
    const auto d = static_cast<float>(version.sample_distance(start + i * step));
    if (d <= 0) return (static_cast<float>(i - 1) + previous / (previous - d)) / static_cast<float>(count);
    previous = d;
  }
  return 2;
}

/// Returns a point near p on the zero surfaces of two fields, both trilinear between the corners of a cell,
/// clamped to the cell; returns p if their tangent planes are nearly parallel. Cell coordinates, 0 to 1.
inline glm::vec3 common_edge(const float* g, const float* d, const glm::vec3& p) noexcept {
  CellCorners corners_g, corners_d;
  std::copy_n(g, 8, corners_g.begin());
  std::copy_n(d, 8, corners_d.begin());
  glm::dvec3 at(p);
  constexpr int k_steps = 4;  // Newton steps; with thick slices the scan's field is curved within a cell
  for (int i = 0; i < k_steps; ++i) {
    const glm::dvec3 a = trilinear_gradient(corners_g, at), b = trilinear_gradient(corners_d, at);
    const double u = -trilinear_value(corners_g, at), v = -trilinear_value(corners_d, at);
    const double aa = glm::dot(a, a), bb = glm::dot(b, b), ab = glm::dot(a, b), det = aa * bb - ab * ab;
    if (!(det > 1e-3 * aa * bb)) return p;
    at += (u * bb - v * ab) / det * a + (v * aa - u * ab) / det * b;
    at = glm::clamp(at, glm::dvec3(0), glm::dvec3(1));
  }
  return glm::vec3(at);
}

/// Computes the vertices of a cell's patches (cell coordinates). A vertex is the mean of the crossings of its
/// patch. If `is_sharp` and the patch has crossings of both the field `g` and the cut `d`, the vertex is a
/// point of their common edge. `solid`: bits of the solid corners, as in `net`. The crossing on an edge is at
/// the first zero of `g` or `d` from its solid end, or in its middle if there is no zero.
inline void place_patches(const float* g, const float* d, bool is_cut, int solid, const NetCase& net,
                          bool is_sharp, glm::vec3* out) noexcept {
  struct Patch {
    glm::vec3 sum{0};
    int field_crossings = 0, cut_crossings = 0;
  };
  std::array<Patch, 4> patches;
  for (int e = 0; e < 12; ++e) {
    if (!(net.edges >> e & 1)) continue;
    const int axis = e / 4, low = net_edge_corner(e), high = low | 1 << axis;
    const bool is_low_solid = solid >> low & 1;
    const int in = is_low_solid ? low : high, air = is_low_solid ? high : low;
    const float no_crossing = 2, t_field = g[air] < 0 ? g[in] / (g[in] - g[air]) : no_crossing,
                t_cut = is_cut && d[air] <= 0 ? d[in] / (d[in] - d[air]) : no_crossing;
    const float first = std::min(t_field, t_cut), t = first < no_crossing ? first : 0.5f;
    glm::vec3 p(static_cast<float>(low & 1), static_cast<float>(low >> 1 & 1),
                static_cast<float>(low >> 2 & 1));
    p[axis] = is_low_solid ? t : 1 - t;
    Patch& patch = patches[net.patch_of_edge[static_cast<std::size_t>(e)]];
    patch.sum += p;
    ++(t_cut < t_field ? patch.cut_crossings : patch.field_crossings);
  }
  for (std::size_t k = 0; k < net.patch_count; ++k) {
    const Patch& patch = patches[k];
    out[k] = patch.sum / static_cast<float>(patch.field_crossings + patch.cut_crossings);
    if (is_sharp && patch.cut_crossings > 0 && patch.field_crossings > 0) out[k] = common_edge(g, d, out[k]);
  }
}

/// Borrows the objects of its source. Any thread; allocates nothing.
class NetVertices {
 public:
  explicit NetVertices(const SurfaceSource& source)
      : source_(source),
        volume_(source.field->volume()),
        is_cut_(source.version != nullptr && !source.version->is_uncut()),
        low_(static_cast<float>(source.field->shape().low)),
        is_plain_window_(!source.field->shape().is_label() && std::isinf(source.field->shape().high)) {}

  /// Computes the vertices (volume frame) of a cell with case `net`, one per patch.
  void place(const glm::ivec3& cell, const NetCase& net, glm::vec3* out) const {
    alignas(16) float g[8], d[8];
    const bool is_inside = cell.x >= 0 && cell.y >= 0 && cell.z >= 0 && cell.x + 1 < volume_.size.x &&
                           cell.y + 1 < volume_.size.y && cell.z + 1 < volume_.size.z;
    bool is_cut = false;
    if (is_inside && is_plain_window_) {
      const std::size_t row = static_cast<std::size_t>(volume_.size.x),
                        slice = row * static_cast<std::size_t>(volume_.size.y);
      const std::int16_t* v = volume_.window_voxels().data() + volume_.index(cell.x, cell.y, cell.z);
      const auto pair = [](const std::int16_t* at) {
        int packed;
        std::memcpy(&packed, at, sizeof packed);
        return _mm_cvtsi32_si128(packed);
      };
      const __m128i near = _mm_unpacklo_epi32(pair(v), pair(v + row)),
                    far = _mm_unpacklo_epi32(pair(v + slice), pair(v + slice + row));
      const auto above_threshold = [this](__m128i values) {  // the lower four int16, as floats
        return _mm_sub_ps(_mm_cvtepi32_ps(_mm_srai_epi32(_mm_unpacklo_epi16(values, values), 16)),
                          _mm_set1_ps(low_));
      };
      _mm_store_ps(g, above_threshold(near));
      _mm_store_ps(g + 4, above_threshold(far));
    } else {
      for (int i = 0; i < 8; ++i)
        g[i] = static_cast<float>(
            source_.field->at(cell.x + (i & 1), cell.y + (i >> 1 & 1), cell.z + (i >> 2 & 1)));
    }
    if (is_cut_) is_cut = cut_distances(cell, d);
    const bool is_fine = is_cut && !source_.version->lattice().has_voxel_resolution();
    if (is_fine) return place_by_edges(cell, g, net, out);
    // A single patch without a common edge of field and cut: computes all twelve edges at once.
    const auto is_air = [](float value) { return value < 0; };
    const bool may_be_rim = is_cut && !source_.uses_voxel_centres_only && std::any_of(g, g + 8, is_air);
    if (net.patch_count == 1 && !may_be_rim) {
      *out = glm::vec3(cell) + (is_cut ? mean_crossing<true>(g, d, net) : mean_crossing<false>(g, d, net));
      return;
    }
    int solid = 0;
    for (int i = 0; i < 8; ++i) solid |= static_cast<int>(g[i] >= 0 && (!is_cut || d[i] > 0)) << i;
    place_patches(g, d, is_cut, solid, net, !source_.uses_voxel_centres_only, out);
    for (std::size_t k = 0; k < net.patch_count; ++k) out[k] += glm::vec3(cell);
  }

 private:
  /// Variant for a lattice finer than the voxels: evaluates the cut along each edge.
  void place_by_edges(const glm::ivec3& cell, const float* g, const NetCase& net, glm::vec3* out) const {
    const auto corner = [&cell](int i) { return cell + glm::ivec3(i & 1, i >> 1 & 1, i >> 2 & 1); };
    std::array<glm::vec3, 4> sum{};
    std::array<int, 4> count{};
    for (int e = 0; e < 12; ++e) {
      if (!(net.edges >> e & 1)) continue;
      const int axis = e / 4, low = net_edge_corner(e), high = low | 1 << axis;
      const glm::ivec3 at = corner(low);
      const bool is_low_solid = g[low] >= 0 && source_.version->voxel_distance(at.x, at.y, at.z) > 0;
      const int in = is_low_solid ? low : high, air = is_low_solid ? high : low;
      float t = g[air] < 0 ? g[in] / (g[in] - g[air]) : 1;
      t = std::min(t, cut_crossing(*source_.version, corner(in), corner(air)));
      glm::vec3 p(static_cast<float>(low & 1), static_cast<float>(low >> 1 & 1),
                  static_cast<float>(low >> 2 & 1));
      p[axis] = is_low_solid ? t : 1 - t;
      const std::size_t patch = net.patch_of_edge[static_cast<std::size_t>(e)];
      sum[patch] += p;
      ++count[patch];
    }
    for (std::size_t k = 0; k < net.patch_count; ++k)
      out[k] = glm::vec3(cell) + sum[k] / static_cast<float>(count[k]);
  }
  /// Reads the distances to the cut at a cell's corners. Returns true if a corner is removed; else d may be
  /// incomplete.
  bool cut_distances(const glm::ivec3& cell, float* d) const {
    const Version& version = *source_.version;
    const CutLattice& lattice = version.lattice();
    const glm::ivec3 low = lattice.centre_of(cell), high = low + lattice.per_voxel();
    if ((low >> 3) == (high >> 3) && lattice.contains(low)) {
      const Brick* brick = version.brick_at(low);
      if (brick == nullptr) return false;
      const glm::ivec3 from = low & (k_brick - 1), to = high & (k_brick - 1);
      const float* at = brick->distance.data();
      d[0] = at[Brick::index(from.x, from.y, from.z)], d[1] = at[Brick::index(to.x, from.y, from.z)];
      d[2] = at[Brick::index(from.x, to.y, from.z)], d[3] = at[Brick::index(to.x, to.y, from.z)];
      d[4] = at[Brick::index(from.x, from.y, to.z)], d[5] = at[Brick::index(to.x, from.y, to.z)];
      d[6] = at[Brick::index(from.x, to.y, to.z)], d[7] = at[Brick::index(to.x, to.y, to.z)];
    } else {
      // The corners are in up to eight bricks. The two corners of an edge along x are usually in one brick.
      const auto band = static_cast<float>(version.band_mm());
      bool is_any = false;
      for (int i = 0; i < 8; i += 2) {
        const Brick* brick = nullptr;
        glm::ivec3 brick_position(-1);
        for (int x = 0; x < 2; ++x) {
          const glm::ivec3 s(x ? high.x : low.x, i >> 1 & 1 ? high.y : low.y, i >> 2 & 1 ? high.z : low.z);
          if ((s >> 3) != brick_position) {
            brick_position = s >> 3;
            brick = lattice.contains(s) ? version.brick_at(s) : nullptr;
          }
          d[i + x] =
              brick && lattice.contains(s) ? brick->distance[Brick::index(s.x & 7, s.y & 7, s.z & 7)] : band;
          is_any = is_any || brick != nullptr;
        }
      }
      if (!is_any) return false;
    }
    return std::any_of(d, d + 8, [](float value) { return value <= 0; });
  }

  /// Mean of the crossings of all twelve edges; those not crossed add nothing. A crossing is at the first
  /// zero of the two fields from the solid end of an edge.
  template <bool IsCut>
  static glm::vec3 mean_crossing(const float* g, const float* d, const NetCase& net) {
    const __m128 zero = _mm_setzero_ps(), one = _mm_set1_ps(1);
    const auto choose = [](__m128 mask, __m128 yes, __m128 no) {
      return _mm_or_ps(_mm_and_ps(mask, yes), _mm_andnot_ps(mask, no));
    };
    const auto ratio = [](__m128 from, __m128 to) { return _mm_div_ps(from, _mm_sub_ps(from, to)); };
    const auto along = [&](__m128 g0, __m128 g1, __m128 d0, __m128 d1) {
      __m128 solid0 = _mm_cmpge_ps(g0, zero), solid1 = _mm_cmpge_ps(g1, zero), t = ratio(g0, g1);
      if constexpr (IsCut) {
        const __m128 tg = t, td = ratio(d0, d1);
        const __m128 up = _mm_min_ps(choose(solid1, one, tg), choose(_mm_cmple_ps(d1, zero), td, one));
        const __m128 down = _mm_max_ps(choose(solid0, zero, tg), choose(_mm_cmple_ps(d0, zero), td, zero));
        solid0 = _mm_and_ps(solid0, _mm_cmpgt_ps(d0, zero));
        solid1 = _mm_and_ps(solid1, _mm_cmpgt_ps(d1, zero));
        t = choose(solid0, up, down);
      }
      return _mm_and_ps(_mm_xor_ps(solid0, solid1), t);
    };
    const auto total = [](__m128 v) {
      const __m128 pairs = _mm_add_ps(v, _mm_movehl_ps(v, v));
      return _mm_cvtss_f32(_mm_add_ss(pairs, _mm_shuffle_ps(pairs, pairs, 1)));
    };
    const __m128 gl = _mm_load_ps(g), gh = _mm_load_ps(g + 4);  // corners 0-3 and 4-7
    const __m128 dl = IsCut ? _mm_load_ps(d) : zero, dh = IsCut ? _mm_load_ps(d + 4) : zero;
    const auto even = [](__m128 low, __m128 high) {
      return _mm_shuffle_ps(low, high, _MM_SHUFFLE(2, 0, 2, 0));
    };
    const auto odd = [](__m128 low, __m128 high) {
      return _mm_shuffle_ps(low, high, _MM_SHUFFLE(3, 1, 3, 1));
    };
    const auto front = [](__m128 low, __m128 high) { return _mm_movelh_ps(low, high); };
    const auto back = [](__m128 low, __m128 high) { return _mm_movehl_ps(high, low); };
    const float x = total(along(even(gl, gh), odd(gl, gh), even(dl, dh), odd(dl, dh)));
    const float y = total(along(front(gl, gh), back(gl, gh), front(dl, dh), back(dl, dh)));
    const float z = total(along(gl, gh, dl, dh));
    return net.inverse_count * glm::vec3(x + net.corner_sum[0], y + net.corner_sum[1], z + net.corner_sum[2]);
  }

  SurfaceSource source_;
  const Volume& volume_;
  bool is_cut_;
  float low_;
  bool is_plain_window_;
};

}  // namespace trephine::volume
