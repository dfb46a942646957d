// CreaseBuilder: finds the creased cubes of an offset field, and computes the samples of their sheets.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vector_relational.hpp>
#include <map>
#include <memory>
#include <vector>

#include "volume/fields/crease_sheets.h"
#include "volume/fields/smooth_surface.h"

namespace trephine::volume {

/// Surface points in cubes of equal size, for queries by distance.
class PointBins {
 public:
  /// `edge`: length of the cubes' edges, mm.
  PointBins(const std::vector<SurfacePoint>& points, double edge) : edge_(edge) {
    glm::dvec3 high(-1e300);
    low_ = glm::dvec3(1e300);
    for (const SurfacePoint& p : points)
      low_ = glm::min(low_, glm::dvec3(p.at_world)), high = glm::max(high, glm::dvec3(p.at_world));
    if (points.empty()) low_ = high = glm::dvec3(0);
    size_ = glm::ivec3((high - low_) / edge_) + 1;
    first_.assign(static_cast<std::size_t>(size_.x) * static_cast<std::size_t>(size_.y) *
                          static_cast<std::size_t>(size_.z) +
                      1,
                  0);
    for (const SurfacePoint& p : points) ++first_[bin_of(p) + 1];
    for (std::size_t b = 1; b < first_.size(); ++b) first_[b] += first_[b - 1];
    order_.resize(points.size());
    std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
    for (std::size_t i = 0; i < points.size(); ++i)
      order_[next[bin_of(points[i])]++] = static_cast<std::uint32_t>(i);
  }
  /// Calls visit(index) for all points within `reach` mm of `at`, and for some farther points.
  template <class Visit>
  void for_near(const glm::dvec3& at, double reach, const Visit& visit) const {
    const glm::ivec3 first = bin_at(at - reach), last = bin_at(at + reach);
    for (int z = first.z; z <= last.z; ++z)
      for (int y = first.y; y <= last.y; ++y) {
        const std::size_t row = index({0, y, z});
        for (std::uint32_t i = first_[row + static_cast<std::size_t>(first.x)];
             i < first_[row + static_cast<std::size_t>(last.x) + 1]; ++i)
          visit(order_[i]);
      }
  }

 private:
  std::size_t index(const glm::ivec3& b) const {
    return static_cast<std::size_t>(b.x) +
           static_cast<std::size_t>(size_.x) *
               (static_cast<std::size_t>(b.y) +
                static_cast<std::size_t>(size_.y) * static_cast<std::size_t>(b.z));
  }
  glm::ivec3 bin_at(const glm::dvec3& p) const {
    return glm::clamp(glm::ivec3(glm::floor((p - low_) / edge_)), glm::ivec3(0), size_ - 1);
  }
  std::size_t bin_of(const SurfacePoint& p) const { return index(bin_at(glm::dvec3(p.at_world))); }

  double edge_;
  glm::dvec3 low_{0};
  glm::ivec3 size_{0};
  std::vector<std::uint32_t> first_, order_;
};

/// Builder of the sheets of one tile, for one call of build(). Borrows its arguments. Builders of different
/// tiles may run in parallel.
class CreaseBuilder {
 public:
  static constexpr std::size_t k_cones = 42;
  /// Number of lattice points that are read beyond each side of a tile.
  static constexpr int k_margin = 1;
  /// Largest distance (steps) of a creased cube from the offset surface.
  static constexpr double k_band = 1.6;

  struct Offset {
    const Frame &lattice, &volume;
    const SmoothSurface& surface;
    double radius, step, far;  ///< mm
  };
  /// `points`: the surface points within radius + far of the tile and its margin.
  CreaseBuilder(const Offset& offset, const std::vector<SurfacePoint>& points)
      : offset_(offset), points_(points) {}

  /// Stores the sheets of one tile of whole bricks; returns the number of its creased cubes. u_at(v):
  /// value (mm) of the offset field at lattice point v; is_near(v): true if v may be within k_band steps of
  /// the offset surface; is_matter(v): true if v is in the solid.
  template <class U, class IsNear, class IsMatter>
  std::size_t build(const VoxelBox& tile, const U& u_at, const IsNear& is_near, const IsMatter& is_matter,
                    CreaseSheets& sheets) {
    const std::vector<glm::ivec3> cubes = creased_cubes(tile, u_at, is_near);
    if (cubes.empty()) return 0;
    const PointBins bins(points_, 2 * offset_.step);
    std::vector<CreaseSheets::Mask> cones;
    cones.reserve(points_.size()), normals_.reserve(points_.size());
    for (const SurfacePoint& point : points_) {
      const glm::dvec3 out = -offset_.volume.gradient_world_from_volume(
          offset_.surface.jet(false, offset_.volume.volume_from_world(glm::dvec3(point.at_world))).gradient);
      cones.push_back(cones_of(out));
      normals_.emplace_back(glm::dot(out, out) > 0 ? glm::normalize(out) : glm::dvec3(0));
    }
    contacts_.assign(points_.size(), Contact::unknown);
    // Computes the samples that the creased cubes read, each once.
    low_ = tile.low - k_margin, size_ = tile.high - tile.low + 1 + 2 * k_margin;
    std::vector<std::uint32_t> number(static_cast<std::size_t>(size_.x) * static_cast<std::size_t>(size_.y) *
                                          static_cast<std::size_t>(size_.z),
                                      k_none);
    std::vector<Sample> samples;
    for (const glm::ivec3& v : cubes)
      for (int n = 0; n < 27; ++n) {
        const glm::ivec3 near = v + offset_of(n);
        if (number[index(near)] != k_none) continue;
        number[index(near)] = static_cast<std::uint32_t>(samples.size());
        samples.push_back(sample(near, is_matter(near), cones, bins));
      }
    std::map<std::array<int, 3>, std::vector<Creased>> by_brick;
    std::size_t count = 0;
    for (const glm::ivec3& v : cubes) {
      std::array<Sample*, 27> around;
      for (int n = 0; n < 27; ++n)
        around[static_cast<std::size_t>(n)] = &samples[number[index(v + offset_of(n))]];
      const CreaseSheets::Mask kept = sheets_of(around);
      if (kept == 0 || equals_field(kept, around, v, u_at)) continue;
      const glm::ivec3 brick = v / SampleBrick::k_edge;
      by_brick[{brick.x, brick.y, brick.z}].push_back({v, kept});
      ++count;
    }
    for (const auto& [at, creased] : by_brick) {
      const glm::ivec3 brick(at[0], at[1], at[2]);
      sheets.slot(brick) = make_brick(
          brick, creased, [&](const glm::ivec3& v) -> Sample& { return samples[number[index(v)]]; });
    }
    return count;
  }

  /// Returns the cones that contain a normal; all of them for a null vector.
  static CreaseSheets::Mask cones_of(const glm::dvec3& normal) noexcept;

 private:
  static constexpr std::uint32_t k_none = ~0u;
  /// Distances of one lattice point to the surface points of each cone.
  struct Sample {
    std::array<std::uint32_t, k_cones> nearest;  ///< k_none: no point, or inside the solid
    std::array<float, k_cones> u;                ///< mm
    CreaseSheets::Mask refined = 0;              ///< the sheets whose u is final
  };
  static constexpr double k_slack = 0.03;  ///< steps; sampled distances are too long by at most this
  /// `impossible`: a ball that touches the surface point from outside meets other surface points.
  enum class Contact : std::uint8_t { unknown, possible, impossible };
  struct Creased {
    glm::ivec3 cube;
    CreaseSheets::Mask sheets;
  };
  static glm::ivec3 offset_of(int n) { return glm::ivec3(n % 3, n / 3 % 3, n / 9) - 1; }
  std::size_t index(const glm::ivec3& v) const {
    const glm::ivec3 c = v - low_;
    return static_cast<std::size_t>(c.x) +
           static_cast<std::size_t>(size_.x) *
               (static_cast<std::size_t>(c.y) +
                static_cast<std::size_t>(size_.y) * static_cast<std::size_t>(c.z));
  }

  /// Returns the cubes near the offset surface in which the slope of the spline of u is below 0.9. A distance
  /// has slope 1; splines are less steep between flanks whose normals are more than 50 degrees apart. Order:
  /// that of the tile, x fastest.
  template <class U, class IsNear>
  std::vector<glm::ivec3> creased_cubes(const VoxelBox& tile, const U& u_at, const IsNear& is_near) const {
    constexpr double k_slope = 0.9;  // mm per mm
    std::vector<glm::ivec3> cubes;
    for (int z = tile.low.z; z <= tile.high.z; ++z)
      for (int y = tile.low.y; y <= tile.high.y; ++y)
        for (int x = tile.low.x; x <= tile.high.x; ++x) {
          const glm::ivec3 v(x, y, z);
          if (!is_near(v) || !(std::abs(u_at(v)) < k_band * offset_.step)) continue;
          QuadraticPatch patch;
          for (int k = -1; k <= 1; ++k)
            for (int j = -1; j <= 1; ++j) {
              const auto value = [&](int i) { return u_at(v + glm::ivec3(i, j, k)); };
              patch.set_row(j + 1, k + 1, value(-1), value(0), value(1));
            }
          // Tests the corners too, where only eight samples have weight and neighbouring cubes agree, so that
          // creased cubes end where the spline is accurate again.
          const auto is_flat_at = [&](const glm::dvec3& at) {
            const ValueAndGradient field = patch.value_and_gradient(at);
            const glm::dvec3 slope = offset_.lattice.gradient_world_from_volume(field.gradient);
            return std::abs(field.value) < 1.5 * offset_.step && glm::dot(slope, slope) < k_slope * k_slope;
          };
          bool is_creased = is_flat_at(glm::dvec3(0));
          for (int n = 0; n < 8 && !is_creased; ++n)
            is_creased = is_flat_at(glm::dvec3(n & 1, n >> 1 & 1, n >> 2) - 0.5);
          if (is_creased) cubes.push_back(v);
        }
    return cubes;
  }
  /// Returns true if a ball that touches point i from outside has its centre within `far` of `from`, and
  /// meets other surface points, as at the bottom of a groove. The second test does not depend on `from`; its
  /// result is stored in contacts_.
  bool is_out_of_reach(std::uint32_t i, const glm::vec3& from, const PointBins& bins) {
    constexpr double k_depth = 0.1;  // steps
    const glm::vec3 centre = points_[i].at_world + static_cast<float>(offset_.radius) * normals_[i];
    // points_ contains all surface points that the ball may meet only if the ball's centre is within `far` of
    // `from`.
    if (normals_[i] == glm::vec3(0) || glm::distance(centre, from) > static_cast<float>(offset_.far))
      return false;
    if (contacts_[i] == Contact::unknown) {
      const double free = offset_.radius - k_depth * offset_.step;
      const auto square = static_cast<float>(free * free);
      contacts_[i] = Contact::possible;
      bins.for_near(glm::dvec3(centre), free, [&](std::uint32_t k) {
        const glm::vec3 separation = centre - points_[k].at_world;
        if (glm::dot(separation, separation) < square) contacts_[i] = Contact::impossible;
      });
    }
    return contacts_[i] == Contact::impossible;
  }

  /// Returns the distances of lattice point v to the sampled points of each cone. Omits points that a ball
  /// cannot touch. Such points are on the rounded bottom of a groove, and their normals are between those of
  /// the flanks. If the nearest point of a cone is omitted, the distance is that to the tangent plane of the
  /// nearest point that a ball can touch. Inside the solid u is `far` in all sheets, so that the field's
  /// value applies.
  Sample sample(const glm::ivec3& v, bool is_matter, const std::vector<CreaseSheets::Mask>& cones,
                const PointBins& bins) {
    Sample result;
    result.nearest.fill(k_none);
    result.u.fill(static_cast<float>(is_matter ? offset_.far : -offset_.far));
    if (is_matter) return result;
    const glm::dvec3 at = offset_.lattice.world_from_volume(glm::dvec3(v));
    const double reach = offset_.radius + offset_.far;
    std::array<float, k_cones> square, square_of_all;
    square.fill(static_cast<float>(reach * reach));
    square_of_all = square;
    const glm::vec3 from(at);
    bins.for_near(at, reach, [&](std::uint32_t i) {
      const glm::vec3 separation = from - points_[i].at_world;
      const float s = glm::dot(separation, separation);
      for (CreaseSheets::Mask rest = cones[i]; rest != 0; rest &= rest - 1) {
        const auto cone = static_cast<std::size_t>(std::countr_zero(rest));
        square_of_all[cone] = std::min(square_of_all[cone], s);
        if (s < square[cone] && !is_out_of_reach(i, from, bins)) square[cone] = s, result.nearest[cone] = i;
      }
    });
    for (std::size_t cone = 0; cone < k_cones; ++cone) {
      const std::uint32_t i = result.nearest[cone];
      if (i == k_none) continue;
      double distance = std::sqrt(static_cast<double>(square[cone]));
      if (square_of_all[cone] < square[cone]) {
        const double least = std::sqrt(static_cast<double>(square_of_all[cone])) - k_slack * offset_.step;
        const auto by_plane = static_cast<double>(glm::dot(from - points_[i].at_world, normals_[i]));
        distance = std::clamp(by_plane, std::min(least, distance), distance);
        result.refined |= CreaseSheets::Mask{1} << cone;
      }
      result.u[cone] = clamped(distance);
    }
    return result;
  }
  float clamped(double distance) const {
    return static_cast<float>(std::clamp(offset_.radius - distance, -offset_.far, offset_.far));
  }
  /// Returns the sheets that may be solid somewhere in a cube. Omits a sheet whose solid is inside that of
  /// another sheet, with tolerance k_slack.
  CreaseSheets::Mask sheets_of(const std::array<Sample*, 27>& around) const {
    const auto slack = static_cast<float>(k_slack * offset_.step);
    const auto contains = [&](std::size_t outer, std::size_t inner) {
      for (const Sample* s : around)
        if (s->u[outer] + slack < s->u[inner]) return false;
      return true;
    };
    CreaseSheets::Mask kept = 0;
    for (std::size_t cone = 0; cone < k_cones; ++cone)
      for (const Sample* s : around)
        if (s->nearest[cone] != k_none && s->u[cone] > -slack) kept |= CreaseSheets::Mask{1} << cone;
    for (CreaseSheets::Mask rest = kept; rest != 0; rest &= rest - 1) {
      const auto sheet = static_cast<std::size_t>(std::countr_zero(rest));
      for (CreaseSheets::Mask others = kept & ~(CreaseSheets::Mask{1} << sheet); others != 0;
           others &= others - 1)
        if (contains(static_cast<std::size_t>(std::countr_zero(others)), sheet)) {
          kept &= ~(CreaseSheets::Mask{1} << sheet);
          break;
        }
    }
    return kept;
  }
  /// Returns true if the cube has only one sheet, and the sheet is nowhere more than 0.1 steps below the
  /// field.
  template <class U>
  bool equals_field(CreaseSheets::Mask kept, const std::array<Sample*, 27>& around, const glm::ivec3& v,
                    const U& u_at) const {
    if (std::popcount(kept) != 1) return false;
    const auto sheet = static_cast<std::size_t>(std::countr_zero(kept));
    for (int n = 0; n < 27; ++n)
      if (static_cast<double>(around[static_cast<std::size_t>(n)]->u[sheet]) <
          u_at(v + offset_of(n)) - 0.1 * offset_.step)
        return false;
    return true;
  }
  /// Makes a brick from its creased cubes, which are sorted by their indices.
  template <class SampleAt>
  std::unique_ptr<CreaseSheets::Brick> make_brick(const glm::ivec3& brick,
                                                  const std::vector<Creased>& creased,
                                                  const SampleAt& sample_at) const {
    constexpr int k_reach = CreaseSheets::Brick::k_reach;
    auto result = std::make_unique<CreaseSheets::Brick>();
    const glm::ivec3 low = SampleBrick::k_edge * brick;
    std::vector<CreaseSheets::Mask> masks(k_reach * k_reach * k_reach);
    for (const Creased& one : creased) {
      result->cubes.add(SampleBrick::index_of(one.cube), one.sheets);
      for (int n = 0; n < 27; ++n)
        masks[CreaseSheets::Brick::point_index(one.cube + offset_of(n), low)] |= one.sheets;
    }
    for (std::size_t i = 0; i < masks.size(); ++i) {
      if (masks[i] == 0) continue;
      const int x = static_cast<int>(i) % k_reach, y = static_cast<int>(i) / k_reach % k_reach,
                z = static_cast<int>(i) / (k_reach * k_reach);
      const glm::ivec3 v = low + glm::ivec3(x, y, z) - 1;
      result->points.add(i, masks[i]);
      result->first.push_back(static_cast<std::uint32_t>(result->samples.size()));
      for (CreaseSheets::Mask rest = masks[i]; rest != 0; rest &= rest - 1)
        result->samples.push_back(refined(v, sample_at(v), std::countr_zero(rest)));
    }
    result->cubes.shrink(), result->points.shrink();
    result->first.shrink_to_fit(), result->samples.shrink_to_fit();
    return result;
  }
  /// Returns u of a sheet at lattice point v. Near the offset surface, u is computed from the exact distance
  /// of v to the surface near the sheet's nearest sampled point.
  float refined(const glm::ivec3& v, Sample& s, int sheet) const {
    constexpr double k_refined = 2.2;  // steps from the offset surface within which distances are exact
    const auto cone = static_cast<std::size_t>(sheet);
    const std::uint32_t nearest = s.nearest[cone];
    if (nearest == k_none || (s.refined >> sheet & 1) != 0) return s.u[cone];
    float u = s.u[cone];
    if (static_cast<double>(std::abs(u)) < k_refined * offset_.step) {
      bool is_found = false;
      const glm::dvec3 at = offset_.lattice.world_from_volume(glm::dvec3(v));
      u = clamped(offset_.surface.distance(at, points_[nearest], is_found));
    }
    for (std::size_t other = 0; other < k_cones; ++other)
      if (s.nearest[other] == nearest && (s.refined >> other & 1) == 0)
        s.u[other] = u, s.refined |= CreaseSheets::Mask{1} << other;
    return u;
  }

  Offset offset_;
  const std::vector<SurfacePoint>& points_;
  std::vector<glm::vec3> normals_;  ///< by point: unit, out of the solid; 0 if unknown
  std::vector<Contact> contacts_;   ///< by point
  glm::ivec3 low_{0}, size_{0};     ///< lattice points of the tile and its margin
};

}  // namespace trephine::volume
