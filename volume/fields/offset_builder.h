// OffsetField::Builder: the passes that compute the samples of an offset field, tile by tile. One file: the
// passes share the samples of a tile.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vector_relational.hpp>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "volume/base/parallel.h"
#include "volume/fields/crease_builder.h"
#include "volume/fields/offset_field.h"
#include "volume/fields/smooth_surface.h"
#include "volume/fields/wavefront.h"

namespace trephine::volume {

/// Fills the bricks of a box of lattice points, tile by tile.
class OffsetField::Builder {
 public:
  static constexpr double k_band = 2.5;  ///< steps on each side of the offset surface that are sampled

  /// `previous`: field of the solid before a removal, or null for a complete build. `changed`: voxels in
  /// which the previous solid and the new solid differ.
  Builder(OffsetField& out, const Field& field, const Occupancy& bits, const Version* version,
          const OffsetField* previous, const VoxelBox& changed, const SoftField* soft)
      : out_(out),
        field_(field),
        bits_(bits),
        version_(version),
        previous_(previous),
        surface_(field, version, soft),
        shortest_step_(shortest_step(out.frame_)) {
    if (!previous_) return;
    // A changed sample of a cut affects splines up to 1.5 samples away.
    const CutLattice& cuts = version_->lattice();
    const auto lattice_of = [&](const glm::dvec3& sample) {
      return out_.frame_.volume_from_world(
          field_.volume().frame.world_from_volume(cuts.volume_from_lattice(sample)));
    };
    changed_ = {lattice_of(glm::dvec3(cuts.low_of(changed.low)) - 1.5),
                lattice_of(glm::dvec3(cuts.high_of(changed.high)) + 1.5), shortest_step_};
  }

  /// Box of the lattice points whose distance may have changed.
  VoxelBox affected_box() const {
    if (!previous_) return {glm::ivec3(0), out_.slots_size_ * SampleBrick::k_edge - 1};
    const glm::ivec3 margin = out_.steps_within(out_.radius_ + out_.far_) + 1,
                     last = out_.slots_size_ * SampleBrick::k_edge - 1;
    return {glm::clamp(glm::ivec3(glm::floor(changed_.low)) - margin, glm::ivec3(0), last),
            glm::clamp(glm::ivec3(glm::ceil(changed_.high)) + margin, glm::ivec3(0), last)};
  }

  /// Omits the remaining tiles when `is_cancelled` becomes true.
  void run(int threads, Work& work, const std::atomic<bool>* is_cancelled = nullptr) {
    const VoxelBox box = affected_box();
    out_.copy_pages(box.low / SampleBrick::k_edge, box.high / SampleBrick::k_edge);
    const glm::ivec3 first = box.low / k_tile, last = box.high / k_tile, count = last - first + 1;
    std::mutex mutex;
    parallel_for(count.x * count.y * count.z, threads, [&](int i) {
      if (is_cancelled != nullptr && *is_cancelled) return;
      const glm::ivec3 tile = first + glm::ivec3(i % count.x, i / count.x % count.y, i / (count.x * count.y));
      Work part;
      build_tile({glm::max(box.low, tile * k_tile), glm::min(box.high, tile * k_tile + (k_tile - 1))}, part);
      const std::lock_guard lock(mutex);
      work.samples += part.samples;
      work.cells += part.cells;
      work.creased += part.creased;
    });
  }

 private:
  static constexpr double k_refined = 2.2;  ///< steps from the offset surface with exact distances
  static constexpr int k_tile = 96;         ///< lattice points along the edge of a tile

  /// Returns true if the distance at v may have changed: the changed box is at most as far as the previous
  /// surface, and no remaining matter was found within that distance.
  bool is_stale(const glm::ivec3& v) const {
    const double u = previous_->at(v.x, v.y, v.z);
    if (u <= -out_.far_) return false;  // u is already at its lower bound
    return changed_.distance(glm::dvec3(v)) <= std::abs(out_.radius_ - u) + 0.1 * out_.step_ &&
           !has_matter_within(v, out_.radius_ - u);
  }
  /// Returns true if a test point within `distance` mm of lattice point v is in matter (tolerance: 1/200 of a
  /// step). May miss matter.
  bool has_matter_within(const glm::ivec3& v, double distance) const {
    const glm::dvec3 at = out_.frame_.world_from_volume(glm::dvec3(v)), p = voxel(glm::dvec3(v));
    // Inside matter the distance is a depth, which is needed only for small tools.
    if (surface_.is_solid(p)) return out_.radius_ >= out_.far_;
    if (!(distance > 0) || !surface_.has_cut()) return false;
    // Tests points in the directions toward the previous solid, toward the end of the cut and toward the
    // surface of the scan. The points are 1/200 of a step farther than `distance`; the tool may hover by this
    // length.
    glm::dvec3 uphill(0), central(0);
    const double centre = previous_->at(v.x, v.y, v.z);
    for (int a = 0; a < 3; ++a) {
      glm::ivec3 step(0);
      step[a] = 1;
      const glm::ivec3 next = v + step, last = v - step;
      const double u_next = previous_->at(next.x, next.y, next.z),
                   u_last = previous_->at(last.x, last.y, last.z);
      central[a] = u_next - u_last;
      // Differentiates toward the higher value, because the lower value may be clamped to the band.
      uphill[a] = u_next > u_last ? u_next - centre : centre - u_last;
    }
    const Frame& frame = field_.volume().frame;
    for (const glm::dvec3& direction :
         {out_.frame_.gradient_world_from_volume(central), out_.frame_.gradient_world_from_volume(uphill),
          frame.gradient_world_from_volume(surface_.jet(true, p).gradient),
          frame.gradient_world_from_volume(surface_.jet(false, p).gradient)}) {
      const double length = glm::length(direction);
      if (!(length > 0)) continue;
      const glm::dvec3 q = frame.volume_from_world(at + (distance + 0.005 * out_.step_) / length * direction);
      if (field_.volume().contains(voxel_of(q)) && surface_.is_solid(q)) return true;
    }
    return false;
  }
  /// Appends a flag for each of the lattice points low .. high, row by row; returns the box of the stale
  /// points.
  VoxelBox find_stale(const glm::ivec3& low, const glm::ivec3& high, std::vector<bool>& stale) const {
    VoxelBox box{high + 1, low - 1};
    for (int z = low.z; z <= high.z; ++z)
      for (int y = low.y; y <= high.y; ++y)
        for (int x = low.x; x <= high.x; ++x) {
          stale.push_back(is_stale({x, y, z}));
          if (stale.back())
            box = {glm::min(box.low, glm::ivec3(x, y, z)), glm::max(box.high, glm::ivec3(x, y, z))};
        }
    return box;
  }

  /// Bits of 64 voxels of row (y, z), without removed voxels; 0 outside the grid.
  std::uint64_t word(int w, int y, int z) const {
    const glm::ivec3& size = field_.volume().size;
    if (y < 0 || z < 0 || y >= size.y || z >= size.z || w < 0 || w >= bits_.words_per_row()) return 0;
    std::uint64_t bits = bits_.row(y, z)[w];
    if (version_ != nullptr && bits != 0) version_->mask_row(y, z, w, 1, &bits);
    return bits;
  }

  /// Kinds of the voxels of a box, by their bits and those of their neighbours.
  class VoxelKinds {
   public:
    /// mixed: the voxel and its 26 neighbours are not all equal, or a cut on a finer lattice may cross the
    /// voxel.
    enum Kind : std::uint8_t { free, mixed, solid };
    VoxelKinds(const Builder& builder, const glm::ivec3& low, const glm::ivec3& high)
        : low_(low), high_(high), size_(glm::max(high - low + 1, glm::ivec3(0))) {
      kinds_.resize(static_cast<std::size_t>(size_.x) * static_cast<std::size_t>(size_.y) *
                    static_cast<std::size_t>(size_.z));
      if (kinds_.empty()) return;
      // Reads every word once, and one more word and row on each side.
      const int first = (low.x >> 6) - 1, words = (high.x >> 6) - first + 2;
      std::vector<std::uint64_t> bits;
      for (int z = low.z - 1; z <= high.z + 1; ++z)
        for (int y = low.y - 1; y <= high.y + 1; ++y)
          for (int w = first; w < first + words; ++w) bits.push_back(builder.word(w, y, z));
      const auto row = [&](int y, int z) {
        return bits.data() + static_cast<std::size_t>(words) *
                                 static_cast<std::size_t>(y - low.y + 1 + (size_.y + 2) * (z - low.z + 1));
      };
      for (int z = low.z; z <= high.z; ++z)
        for (int y = low.y; y <= high.y; ++y)
          for (int w = low.x >> 6; w <= high.x >> 6; ++w) {
            std::uint64_t all = ~std::uint64_t{0}, any = 0;
            for (int dz = -1; dz <= 1; ++dz)
              for (int dy = -1; dy <= 1; ++dy) {
                const std::uint64_t* centre = row(y + dy, z + dz) + (w - first);
                const std::uint64_t left = centre[0] << 1 | centre[-1] >> 63,
                                    right = centre[0] >> 1 | centre[1] << 63;
                all &= centre[0] & left & right;
                any |= centre[0] | left | right;
              }
            if (any == 0) continue;
            const std::uint64_t mixed_bits = (any & ~all) | builder.cut_word(w, y, z, any),
                                solid_bits = row(y, z)[w - first];
            for (int x = std::max(low.x, 64 * w); x <= std::min(high.x, 64 * w + 63); ++x)
              kinds_[index({x, y, z})] = mixed_bits >> (x & 63) & 1   ? mixed
                                         : solid_bits >> (x & 63) & 1 ? solid
                                                                      : free;
          }
    }
    const glm::ivec3& low() const { return low_; }
    const glm::ivec3& high() const { return high_; }
    /// Returns the kind of a voxel. Returns `free` outside the box, which contains all queried voxels of the
    /// grid.
    Kind at(const glm::ivec3& v) const {
      const bool is_inside = v.x >= low_.x && v.y >= low_.y && v.z >= low_.z && v.x <= high_.x &&
                             v.y <= high_.y && v.z <= high_.z;
      return is_inside ? kinds_[index(v)] : free;
    }

   private:
    std::size_t index(const glm::ivec3& v) const {
      const glm::ivec3 offset = v - low_;
      return static_cast<std::size_t>(offset.x) +
             static_cast<std::size_t>(size_.x) *
                 (static_cast<std::size_t>(offset.y) +
                  static_cast<std::size_t>(size_.y) * static_cast<std::size_t>(offset.z));
    }
    glm::ivec3 low_, high_, size_;
    std::vector<Kind> kinds_;
  };
  /// Returns the bits of `any` whose voxels may be crossed by cuts on a finer lattice. `any`: word w of row
  /// (y, z).
  std::uint64_t cut_word(int w, int y, int z, std::uint64_t any) const {
    if (version_ == nullptr || version_->is_uncut()) return 0;
    const CutLattice& lattice = version_->lattice();
    const glm::ivec3 first(64 * w, y, z);
    if (lattice.has_voxel_resolution() ||
        !version_->has_brick(lattice.low_of(first), lattice.high_of(first + glm::ivec3(63, 0, 0))))
      return 0;
    std::uint64_t cut = 0;
    for (; any != 0; any &= any - 1) {
      const glm::ivec3 v = first + glm::ivec3(std::countr_zero(any), 0, 0);
      if (version_->has_brick(lattice.low_of(v), lattice.high_of(v))) cut |= any & (~any + 1);
    }
    return cut;
  }

  /// Samples surface points in the mixed voxels, which are subdivided to the lattice's step. Omits points
  /// farther than `reach` mm from `target`.
  std::vector<SurfacePoint> sample_surface(const VoxelKinds& kinds, const LatticeBox& target,
                                           double reach) const {
    const Frame& frame = field_.volume().frame;
    std::vector<SurfacePoint> points;
    const glm::dvec3 cells =
        glm::max(glm::ceil(field_.volume().frame.spacing() / out_.step_ - 1e-9), glm::dvec3(1));
    const glm::ivec3 count(cells), &low = kinds.low(), &high = kinds.high();
    // Largest distance from a voxel's centre to a surface point projected from its cells.
    const glm::dvec3& spacing = frame.spacing();
    const glm::dvec3 steps = spacing / cells;
    const double margin =
        0.5 * (spacing.x + spacing.y + spacing.z) + 1.5 * std::max({steps.x, steps.y, steps.z});
    for (int z = low.z; z <= high.z; ++z)
      for (int y = low.y; y <= high.y; ++y)
        for (int x = low.x; x <= high.x; ++x) {
          const glm::ivec3 v(x, y, z);
          if (kinds.at(v) != VoxelKinds::mixed) continue;
          if (target.distance(out_.frame_.volume_from_world(frame.world_from_volume(glm::dvec3(v)))) >
              reach + margin)
            continue;
          bool is_found = false;
          for (int i = 0; i < count.x * count.y * count.z; ++i) {
            const glm::ivec3 cell(i % count.x, i / count.x % count.y, i / (count.x * count.y));
            const glm::dvec3 from = glm::dvec3(v) + (glm::dvec3(cell) + 0.5) / cells - 0.5;
            SurfacePoint point;
            if (surface_.project(from, cells, point)) {
              points.push_back(point);
              is_found = true;
            }
            if (SurfacePoint rim; surface_.project_to_rim(from, cells, rim)) points.push_back(rim);
          }
          if (is_solid_voxel(v)) sample_thin_wall(v, is_found, points);
        }
    return points;
  }
  /// Samples both sides of a wall that is one voxel thick. In the middle of such a wall the gradient
  /// vanishes.
  void sample_thin_wall(const glm::ivec3& v, bool is_found, std::vector<SurfacePoint>& points) const {
    for (int axis = 0; axis < 3; ++axis) {
      glm::ivec3 previous = v, next = v;
      --previous[axis], ++next[axis];
      const bool is_previous_solid = is_solid_voxel(previous), is_next_solid = is_solid_voxel(next);
      if (is_found && (is_previous_solid || is_next_solid)) continue;
      if (!is_previous_solid) surface_.bisect(glm::dvec3(v), glm::dvec3(previous), points);
      if (!is_next_solid) surface_.bisect(glm::dvec3(v), glm::dvec3(next), points);
    }
  }

  /// Tests lattice points and boxes for matter.
  class Matter {
   public:
    Matter(const Builder& builder, const VoxelKinds& kinds) : builder_(builder), kinds_(kinds) {}
    bool operator()(const glm::ivec3& v) const {
      const glm::dvec3 p = builder_.voxel(glm::dvec3(v));
      const VoxelKinds::Kind kind = kinds_.at(voxel_of(p));
      return kind == VoxelKinds::mixed ? builder_.surface_.is_solid(p) : kind == VoxelKinds::solid;
    }
    /// Returns true if a box of lattice points that no surface crosses is solid. If a surface was missed,
    /// returns true for a partly solid box.
    bool is_solid_box(const glm::ivec3& from, const glm::ivec3& to) const {
      const glm::dvec3 low = builder_.voxel(glm::dvec3(from)), high = builder_.voxel(glm::dvec3(to));
      const glm::ivec3 first = voxel_of(low), last = voxel_of(high);
      for (int z = first.z; z <= last.z; ++z)
        for (int y = first.y; y <= last.y; ++y)
          for (int x = first.x; x <= last.x; ++x) {
            const VoxelKinds::Kind kind = kinds_.at({x, y, z});
            if (kind == VoxelKinds::solid) return true;
            if (kind == VoxelKinds::mixed && has_solid_corner(glm::max(low, glm::dvec3(x, y, z) - 0.5),
                                                              glm::min(high, glm::dvec3(x, y, z) + 0.5)))
              return true;
          }
      return false;
    }

   private:
    bool has_solid_corner(const glm::dvec3& low, const glm::dvec3& high) const {
      for (int corner = 0; corner < 8; ++corner)
        if (builder_.surface_.is_solid(
                {corner & 1 ? high.x : low.x, corner & 2 ? high.y : low.y, corner & 4 ? high.z : low.z}))
          return true;
      return false;
    }
    const Builder& builder_;
    const VoxelKinds& kinds_;
  };

  /// Samples of a tile to compute: all, or after a cut those that the cut may change.
  struct Selection {
    VoxelBox tile, box;       ///< `box`: bounds of the selected samples; empty (low > high) without any
    std::vector<bool> stale;  ///< flags of the whole tile, x fastest; empty: all are selected
    bool operator()(const glm::ivec3& v) const {
      if (stale.empty()) return true;
      if (glm::any(glm::lessThan(v, box.low)) || glm::any(glm::greaterThan(v, box.high))) return false;
      const glm::ivec3 c = v - tile.low, size = tile.high - tile.low + 1;
      return static_cast<bool>(stale[static_cast<std::size_t>(c.x + size.x * (c.y + size.y * c.z))]);
    }
  };
  Selection select(const VoxelBox& tile) const {
    Selection selection{tile, tile, {}};
    if (previous_) selection.box = find_stale(tile.low, tile.high, selection.stale);
    return selection;
  }

  /// u at the lattice points in and around a tile, each computed once.
  class TileSamples {
   public:
    TileSamples(const VoxelBox& box) : low_(box.low), size_(box.high - box.low + 1) {
      values_.assign(static_cast<std::size_t>(size_.x) * static_cast<std::size_t>(size_.y) *
                         static_cast<std::size_t>(size_.z),
                     std::numeric_limits<float>::quiet_NaN());
    }
    float& at(const glm::ivec3& v) {
      const glm::ivec3 c = v - low_;
      return values_[static_cast<std::size_t>(c.x) +
                     static_cast<std::size_t>(size_.x) *
                         (static_cast<std::size_t>(c.y) +
                          static_cast<std::size_t>(size_.y) * static_cast<std::size_t>(c.z))];
    }

   private:
    glm::ivec3 low_, size_;
    std::vector<float> values_;
  };

  void build_tile(const VoxelBox& tile, Work& work) {
    const Selection is_selected = select(tile);
    const auto& [low, high] = is_selected.box;
    if (glm::any(glm::greaterThan(low, high))) return;
    const double reach = out_.radius_ + (k_band + 1) * out_.step_;
    const int margin = builds_sheets() ? CreaseBuilder::k_margin : 0;
    const glm::ivec3 halo = out_.steps_within(reach) + 1 + margin;
    // The lattice is parallel to the volume's axes, so that a box of lattice points is also a box of voxels.
    const glm::ivec3 voxel_low =
                         glm::max(glm::ivec3(glm::floor(voxel(glm::dvec3(low - halo)))), glm::ivec3(0)),
                     voxel_high = glm::min(glm::ivec3(glm::ceil(voxel(glm::dvec3(high + halo)))),
                                           field_.volume().size - 1);
    const VoxelKinds kinds(*this, voxel_low, voxel_high);
    const Matter is_matter(*this, kinds);
    const LatticeBox box{glm::dvec3(low - margin), glm::dvec3(high + margin), shortest_step_};
    const std::vector<SurfacePoint> points = sample_surface(kinds, box, reach);
    work.samples += points.size();
    std::optional<Wavefront> wavefront;
    if (!points.empty()) {
      wavefront.emplace(out_.frame_, box, halo, points);
      wavefront->spread(out_.step_, reach, inner_reach(), is_matter);
    }
    std::optional<TileSamples> samples;
    if (builds_sheets() && wavefront) samples.emplace(VoxelBox{low - margin, high + margin});
    fill_bricks(is_selected, wavefront, points, is_matter, samples, work);
    if (samples) build_sheets({low, high}, wavefront, points, is_matter, *samples, work);
  }
  /// True for a complete build of a field with sheets; updates keep the sheets of the complete build.
  bool builds_sheets() const { return out_.sheets_ != nullptr && previous_ == nullptr; }

  void fill_bricks(const Selection& is_selected, const std::optional<Wavefront>& wavefront,
                   const std::vector<SurfacePoint>& points, const Matter& is_matter,
                   std::optional<TileSamples>& samples, Work& work) {
    const glm::ivec3 first = is_selected.box.low / SampleBrick::k_edge,
                     last = is_selected.box.high / SampleBrick::k_edge;
    for (int bz = first.z; bz <= last.z; ++bz)
      for (int by = first.y; by <= last.y; ++by)
        for (int bx = first.x; bx <= last.x; ++bx) {
          const glm::ivec3 corner = glm::ivec3(bx, by, bz) * SampleBrick::k_edge;
          SampleSlot& slot = out_.writable_slot({bx, by, bz});
          // A brick that the wavefront did not reach is uniform.
          if (!previous_ && !is_reached(wavefront, corner))
            slot = {nullptr, is_matter.is_solid_box(corner, corner + (SampleBrick::k_edge - 1))};
          else
            fill(slot, corner, is_selected, wavefront, points, is_matter, samples, work);
        }
  }
  static bool is_reached(const std::optional<Wavefront>& wavefront, const glm::ivec3& corner) {
    for (int k = 0; wavefront && k < SampleBrick::k_edge * SampleBrick::k_edge * SampleBrick::k_edge; ++k)
      if (wavefront->nearest(corner + in_brick(k)) != Wavefront::k_none) return true;
    return false;
  }
  static glm::ivec3 in_brick(int k) {
    return {k % SampleBrick::k_edge, k / SampleBrick::k_edge % SampleBrick::k_edge,
            k / (SampleBrick::k_edge * SampleBrick::k_edge)};
  }

  /// Computes the selected samples of the brick at `corner`; stores a brick only near the offset surface.
  void fill(SampleSlot& slot, const glm::ivec3& corner, const Selection& is_selected,
            const std::optional<Wavefront>& wavefront, const std::vector<SurfacePoint>& points,
            const Matter& is_matter, std::optional<TileSamples>& samples, Work& work) const {
    const float far = static_cast<float>(out_.far_);
    auto brick = slot.brick ? std::make_shared<SampleBrick>(*slot.brick) : std::make_shared<SampleBrick>();
    if (!slot.brick) brick->values.fill(slot.is_solid ? far : -far);
    bool is_changed = false;
    for (int k = 0; k < SampleBrick::k_edge * SampleBrick::k_edge * SampleBrick::k_edge; ++k) {
      const glm::ivec3 v = corner + in_brick(k);
      if (!is_selected(v)) continue;
      float& u = brick->values[static_cast<std::size_t>(k)];
      const float value = static_cast<float>(sample(v, wavefront, points, is_matter, work));
      if (samples) samples->at(v) = value;
      // After a removal u must not increase anywhere, not even by rounding.
      if (previous_ && value >= u) continue;
      u = value;
      is_changed = true;
    }
    if (!is_changed) return;
    const auto [lowest, highest] = std::minmax_element(brick->values.begin(), brick->values.end());
    const bool is_near = *lowest > -far ? *lowest < far : *highest > -far;
    slot.is_solid = *highest > 0;
    slot.brick = is_near ? std::move(brick) : nullptr;
  }
  /// u at lattice point v.
  double sample(const glm::ivec3& v, const std::optional<Wavefront>& wavefront,
                const std::vector<SurfacePoint>& points, const Matter& is_matter, Work& work) const {
    const std::uint32_t nearest = wavefront ? wavefront->nearest(v) : Wavefront::k_none;
    const bool is_within = is_matter(v);
    if (nearest == Wavefront::k_none) return is_within ? out_.far_ : -out_.far_;
    ++work.cells;
    // Inside the solid the distance is negative.
    const double sign = is_within ? -1 : 1, spread = wavefront->distance(v);
    const bool is_refined = std::abs(sign * spread - out_.radius_) < k_refined * out_.step_;
    const double distance = is_refined ? exact_distance(v, *wavefront, points) : spread;
    return std::clamp(out_.radius_ - sign * distance, -out_.far_, out_.far_);
  }

  /// Exact distance (mm) of lattice point v to the surface. If the search from its nearest surface point
  /// fails (as on rims), also tries those of its neighbours.
  double exact_distance(const glm::ivec3& v, const Wavefront& wavefront,
                        const std::vector<SurfacePoint>& points) const {
    const glm::dvec3 at = out_.frame_.world_from_volume(glm::dvec3(v));
    const std::uint32_t nearest = wavefront.nearest(v);
    bool is_found = false;
    double distance = surface_.distance(at, points[nearest], is_found);
    for (int k = 0; k < 6 && !is_found; ++k) {
      glm::ivec3 neighbour = v;
      neighbour[k / 2] += k % 2 ? 1 : -1;
      const std::uint32_t other = wavefront.nearest(neighbour);
      if (other != Wavefront::k_none && other != nearest)
        distance = std::min(distance, surface_.distance(at, points[other], is_found));
    }
    return distance;
  }

  /// Computes the sheets of the creased cubes of a tile.
  void build_sheets(const VoxelBox& tile, const std::optional<Wavefront>& wavefront,
                    const std::vector<SurfacePoint>& points, const Matter& is_matter, TileSamples& samples,
                    Work& work) {
    CreaseBuilder builder({out_.frame_, field_.volume().frame, surface_, out_.radius_, out_.step_, out_.far_},
                          points);
    work.creased += builder.build(
        tile,
        [&](const glm::ivec3& v) {
          float& u = samples.at(v);
          if (std::isnan(u)) u = static_cast<float>(sample(v, wavefront, points, is_matter, work));
          return static_cast<double>(u);
        },
        [&](const glm::ivec3& v) {
          // The sampled distance is too long by less than half a step.
          return wavefront->nearest(v) != Wavefront::k_none &&
                 std::abs(wavefront->distance(v) - out_.radius_) < (CreaseBuilder::k_band + 0.5) * out_.step_;
        },
        is_matter, *out_.sheets_);
  }

  /// Converts lattice coordinates to the volume frame.
  glm::dvec3 voxel(const glm::dvec3& lattice) const {
    return field_.volume().frame.volume_from_world(out_.frame_.world_from_volume(lattice));
  }
  /// Depth in the solid (mm) to which samples are needed.
  double inner_reach() const { return std::max(0.0, (k_band + 1) * out_.step_ - out_.radius_); }
  bool is_solid_voxel(const glm::ivec3& v) const {
    return field_.volume().contains(v) && bits_.is_solid(v) && (version_ == nullptr || version_->is_kept(v));
  }

  OffsetField& out_;
  const Field& field_;
  const Occupancy& bits_;
  const Version* version_;
  const OffsetField* previous_;
  SmoothSurface surface_;
  double shortest_step_;  ///< from shortest_step(), mm
  LatticeBox changed_{};  ///< lattice points at which cuts may differ
};

}  // namespace trephine::volume
