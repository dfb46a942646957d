#include "volume/offset_field.h"

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <mutex>

#include "volume/parallel.h"
#include "volume/smooth_surface.h"
#include "volume/work_counters.h"

namespace trephine::volume {

using glm::dvec3;
using glm::ivec3;

namespace {

constexpr double k_steps_a_radius = 12;  // of the lattice
constexpr double k_band = 2.5;           // steps on either side of the offset surface that are sampled
constexpr double k_refined = 2.2;        // steps within which distances are exact
constexpr int k_tile = 96;               // lattice points along the edge of what is built at once

}  // namespace

/// Fills the bricks of a box of lattice points, tile by tile.
class OffsetField::Builder {
 public:
  Builder(OffsetField& out, const Field& field, const Occupancy& bits, const Version* version,
          bool is_after_removal)
      : out_(out),
        field_(field),
        bits_(bits),
        version_(version),
        is_after_removal_(is_after_removal),
        surface_(field, version) {}

  void run(const ivec3& low, const ivec3& high, int threads, Work& work) {
    const ivec3 first = low / k_tile, last = high / k_tile, count = last - first + 1;
    std::mutex mutex;
    parallel_for(count.x * count.y * count.z, threads, [&](int i) {
      const ivec3 tile = first + ivec3(i % count.x, i / count.x % count.y, i / (count.x * count.y));
      Work part;
      build_tile(glm::max(low, tile * k_tile), glm::min(high, tile * k_tile + (k_tile - 1)), part);
      const std::lock_guard lock(mutex);
      work.samples += part.samples;
      work.cells += part.cells;
    });
  }

 private:
  /// Bits of 64 voxels of row (y, z), without what was cut; nothing outside the grid.
  std::uint64_t word(int w, int y, int z) const {
    const ivec3& size = field_.volume().size;
    if (y < 0 || z < 0 || y >= size.y || z >= size.z || w < 0 || w >= bits_.words_per_row()) return 0;
    std::uint64_t bits = bits_.row(y, z)[w];
    if (version_ != nullptr && bits != 0) version_->mask_row(y, z, w, 1, &bits);
    return bits;
  }
  /// Voxels of a word with solid and free ones among themselves and their 26 neighbours, or next to a cut
  /// that their centres may not show.
  std::uint64_t mixed_word(int w, int y, int z) const {
    std::uint64_t all = ~std::uint64_t{0}, any = 0;
    for (int dz = -1; dz <= 1; ++dz)
      for (int dy = -1; dy <= 1; ++dy) {
        const std::uint64_t here = word(w, y + dy, z + dz), before = word(w - 1, y + dy, z + dz),
                            after = word(w + 1, y + dy, z + dz);
        const std::uint64_t left = here << 1 | before >> 63, right = here >> 1 | after << 63;
        all &= here & left & right;
        any |= here | left | right;
      }
    std::uint64_t mixed = any & ~all;
    if (version_ == nullptr || version_->is_untouched() || any == 0) return mixed;
    const CutLattice& lattice = version_->lattice();
    if (lattice.is_of_voxels()) return mixed;
    const ivec3 first(64 * w, y, z);
    if (!version_->has_brick(lattice.low_of(first), lattice.high_of(first + ivec3(63, 0, 0)))) return mixed;
    for (int b = 0; b < 64; ++b) {
      const ivec3 v = first + ivec3(b, 0, 0);
      if ((any >> b & 1) && version_->has_brick(lattice.low_of(v), lattice.high_of(v)))
        mixed |= std::uint64_t{1} << b;
    }
    return mixed;
  }

  /// What is known of the voxels of a box by their bits and those around them.
  class VoxelKinds {
   public:
    enum Kind : std::uint8_t { free, mixed, solid };
    VoxelKinds(const Builder& builder, const ivec3& low, const ivec3& high)
        : low_(low), high_(high), size_(glm::max(high - low + 1, ivec3(0))) {
      kinds_.resize(static_cast<std::size_t>(size_.x) * static_cast<std::size_t>(size_.y) *
                    static_cast<std::size_t>(size_.z));
      for (int z = low.z; z <= high.z; ++z)
        for (int y = low.y; y <= high.y; ++y)
          for (int w = low.x >> 6; w <= high.x >> 6; ++w) {
            const std::uint64_t of_mixed = builder.mixed_word(w, y, z), of_solid = builder.word(w, y, z);
            if ((of_mixed | of_solid) == 0) continue;
            for (int x = std::max(low.x, 64 * w); x <= std::min(high.x, 64 * w + 63); ++x)
              kinds_[index({x, y, z})] = of_mixed >> (x & 63) & 1   ? mixed
                                         : of_solid >> (x & 63) & 1 ? solid
                                                                    : free;
          }
    }
    /// Beyond the box nothing is solid: it ends where the grid does, or beyond all that is asked.
    Kind at(const ivec3& v) const {
      const bool is_in = v.x >= low_.x && v.y >= low_.y && v.z >= low_.z && v.x <= high_.x &&
                         v.y <= high_.y && v.z <= high_.z;
      return is_in ? kinds_[index(v)] : free;
    }

   private:
    std::size_t index(const ivec3& v) const {
      const ivec3 in = v - low_;
      return static_cast<std::size_t>(in.x) +
             static_cast<std::size_t>(size_.x) *
                 (static_cast<std::size_t>(in.y) +
                  static_cast<std::size_t>(size_.y) * static_cast<std::size_t>(in.z));
    }
    ivec3 low_, high_, size_;
    std::vector<Kind> kinds_;
  };

  /// Surface points in a box of voxels, as near to each other as the lattice is fine: each voxel is divided
  /// where it is longer than a step.
  void sample_surface(const ivec3& low, const ivec3& high, std::vector<SurfacePoint>& points) const {
    const dvec3 cells = glm::max(glm::ceil(field_.volume().frame.spacing() / out_.step_ - 1e-9), dvec3(1));
    const ivec3 count(cells);
    for (int z = low.z; z <= high.z; ++z)
      for (int y = low.y; y <= high.y; ++y)
        for (int w = low.x >> 6; w <= high.x >> 6; ++w)
          for (std::uint64_t edge = mixed_word(w, y, z); edge != 0; edge &= edge - 1) {
            const ivec3 v(64 * w + std::countr_zero(edge), y, z);
            if (v.x < low.x || v.x > high.x) continue;
            bool is_found = false;
            for (int i = 0; i < count.x * count.y * count.z; ++i) {
              const ivec3 in(i % count.x, i / count.x % count.y, i / (count.x * count.y));
              const dvec3 from = dvec3(v) + (dvec3(in) + 0.5) / cells - 0.5;
              SurfacePoint point;
              if (surface_.project(from, cells, point)) {
                points.push_back(point);
                is_found = true;
              }
              if (SurfacePoint rim; surface_.project_to_rim(from, cells, rim)) points.push_back(rim);
            }
            if (is_solid_voxel(v)) sample_sheet(v, is_found, points);
          }
  }
  /// A sheet of one voxel has two sides and, in its middle, no slope that leads to them.
  void sample_sheet(const ivec3& v, bool is_found, std::vector<SurfacePoint>& points) const {
    for (int axis = 0; axis < 3; ++axis) {
      ivec3 before = v, after = v;
      --before[axis], ++after[axis];
      const bool is_before = is_solid_voxel(before), is_after = is_solid_voxel(after);
      if (is_found && (is_before || is_after)) continue;
      if (!is_before) surface_.bisect(dvec3(v), dvec3(before), points);
      if (!is_after) surface_.bisect(dvec3(v), dvec3(after), points);
    }
  }

  void build_tile(const ivec3& low, const ivec3& high, Work& work) {
    const Frame& frame = field_.volume().frame;
    const double reach = out_.radius_ + (k_band + 1) * out_.step_;
    // The lattice is aligned with the volume's axes: a box of it is a box of voxels.
    const auto voxel = [&](const dvec3& p) {
      return frame.volume_from_world(out_.frame_.world_from_volume(p));
    };
    const ivec3 halo = out_.steps_within(reach) + 1;
    const ivec3 from = low - halo, to = high + halo, size = to - from + 1;
    const ivec3 voxel_low = glm::max(ivec3(glm::floor(voxel(dvec3(from)))), ivec3(0)),
                voxel_high = glm::min(ivec3(glm::ceil(voxel(dvec3(to)))), field_.volume().size - 1);
    const VoxelKinds kinds(*this, voxel_low, voxel_high);
    const auto is_matter = [&](const dvec3& p) {
      const VoxelKinds::Kind kind = kinds.at(voxel_of(p));
      return kind == VoxelKinds::mixed ? surface_.is_solid(p) : kind == VoxelKinds::solid;
    };
    std::vector<SurfacePoint> points;
    sample_surface(voxel_low, voxel_high, points);
    work.samples += points.size();

    // Nearest points spread outward, nearest first (a brush fire with distances to the points themselves).
    constexpr std::uint32_t k_none = ~0u;
    const std::size_t cells = static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y) *
                              static_cast<std::size_t>(size.z);
    std::vector<std::uint32_t> nearest;
    std::vector<float> square;
    const auto cell_index = [&](const ivec3& c) {
      return static_cast<std::size_t>(c.x) +
             static_cast<std::size_t>(size.x) *
                 (static_cast<std::size_t>(c.y) +
                  static_cast<std::size_t>(size.y) * static_cast<std::size_t>(c.z));
    };
    const auto world_of = [&](const ivec3& c) {
      return glm::vec3(out_.frame_.world_from_volume(dvec3(from + c)));
    };
    if (!points.empty()) {
      nearest.assign(cells, k_none);
      square.assign(cells, 1e30f);
      const float step = static_cast<float>(out_.step_), limit = static_cast<float>(reach);
      std::vector<std::vector<std::uint32_t>> buckets(static_cast<std::size_t>(reach / out_.step_ * 2) + 3);
      const float most = limit * limit;
      const float inner = static_cast<float>(inner_reach());
      std::size_t burning = 0;
      // Cell i is inside the box, `at` its place.
      const auto offer = [&](std::size_t i, const glm::vec3& at, std::uint32_t point) {
        const glm::vec3 d = at - points[point].at_world;
        const float s = glm::dot(d, d);
        if (s >= square[i] || s > most) return;
        square[i] = s;
        nearest[i] = point;
        // Never into a bucket that has burnt: a point may be nearer to a neighbour than to the cell it came
        // from.
        const std::size_t bucket = std::max(burning, static_cast<std::size_t>(2 * std::sqrt(s) / step));
        buckets[std::min(bucket, buckets.size() - 1)].push_back(static_cast<std::uint32_t>(i));
      };
      const auto contains = [&](const ivec3& c) {
        return c.x >= 0 && c.y >= 0 && c.z >= 0 && c.x < size.x && c.y < size.y && c.z < size.z;
      };
      for (std::uint32_t p = 0; p < points.size(); ++p) {
        const dvec3 at = out_.frame_.volume_from_world(dvec3(points[p].at_world));
        const ivec3 c = ivec3(glm::floor(at)) - from;
        for (int k = 0; k < 8; ++k) {
          const ivec3 corner = c + ivec3(k & 1, k >> 1 & 1, k >> 2 & 1);
          if (contains(corner)) offer(cell_index(corner), world_of(corner), p);
        }
      }
      // The 26 neighbours: how far in memory and in the world.
      std::array<glm::vec3, 27> away;
      std::array<std::ptrdiff_t, 27> jump;
      for (int n = 0; n < 27; ++n) {
        const ivec3 d(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1);
        const auto k = static_cast<std::size_t>(n);
        away[k] = glm::vec3(out_.frame_.vector_world_from_volume(dvec3(d)));
        jump[k] =
            d.x + static_cast<std::ptrdiff_t>(size.x) * (d.y + static_cast<std::ptrdiff_t>(size.y) * d.z);
      }
      for (; burning < buckets.size(); ++burning)
        for (std::size_t k = 0; k < buckets[burning].size(); ++k) {
          const std::size_t i = buckets[burning][k];
          const ivec3 c(
              static_cast<int>(i % static_cast<std::size_t>(size.x)),
              static_cast<int>(i / static_cast<std::size_t>(size.x) % static_cast<std::size_t>(size.y)),
              static_cast<int>(i / (static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y))));
          // Outward: the way to the nearest point never leads through the solid. Inward only as deep as a
          // small radius needs samples there.
          if (!(square[i] < inner * inner) && is_matter(voxel(dvec3(from + c)))) continue;
          const std::uint32_t p = nearest[i];
          const glm::vec3 at = world_of(c);
          const bool is_inner =
              c.x > 0 && c.y > 0 && c.z > 0 && c.x + 1 < size.x && c.y + 1 < size.y && c.z + 1 < size.z;
          for (std::size_t n = 0; n < 27; ++n)
            if (n != 13 &&
                (is_inner || contains(c + ivec3(static_cast<int>(n % 3) - 1, static_cast<int>(n / 3 % 3) - 1,
                                                static_cast<int>(n / 9) - 1))))
              offer(static_cast<std::size_t>(static_cast<std::ptrdiff_t>(i) + jump[n]), at + away[n], p);
        }
    }

    // Bricks: those with anything near the offset surface are kept.
    const ivec3 first = low / k_edge, last = high / k_edge;
    for (int bz = first.z; bz <= last.z; ++bz)
      for (int by = first.y; by <= last.y; ++by)
        for (int bx = first.x; bx <= last.x; ++bx) {
          const ivec3 b(bx, by, bz);
          // Where the fire never came a brick is all free or all solid.
          bool is_reached = false;
          if (!points.empty())
            for (int k = 0; k < k_edge * k_edge && !is_reached; ++k) {
              const std::uint32_t* row =
                  nearest.data() + cell_index(b * k_edge + ivec3(0, k % k_edge, k / k_edge) - from);
              is_reached = std::any_of(row, row + k_edge, [](std::uint32_t p) { return p != k_none; });
            }
          Slot& slot = out_.own_slot(b);
          const Slot before = slot;
          if (!is_reached) {
            const bool is_solid =
                has_matter(kinds, voxel(dvec3(b * k_edge)), voxel(dvec3(b * k_edge + (k_edge - 1))));
            if (!is_after_removal_ || !is_solid) slot = {nullptr, is_solid};
            continue;
          }
          auto brick = std::make_shared<Brick>();
          bool is_near = false, is_solid = false;
          for (int k = 0; k < k_edge * k_edge * k_edge; ++k) {
            const ivec3 v = b * k_edge + ivec3(k % k_edge, k / k_edge % k_edge, k / (k_edge * k_edge));
            double u = -out_.far_;
            const ivec3 c = v - from;
            const std::size_t i = cell_index(c);
            if (nearest[i] != k_none) {
              double distance = std::sqrt(static_cast<double>(square[i]));
              // In the solid itself the distance has the other sign.
              const bool is_within = is_matter(voxel(dvec3(v)));
              if (std::abs((is_within ? -distance : distance) - out_.radius_) < k_refined * out_.step_)
                distance = surface_.distance(out_.frame_.world_from_volume(dvec3(v)), points[nearest[i]]);
              if (is_within) distance = -distance;
              u = std::clamp(out_.radius_ - distance, -out_.far_, out_.far_);
              ++work.cells;
            } else if (is_matter(voxel(dvec3(v)))) {
              u = out_.far_;
            }
            // Where matter was taken the tool is nowhere held that it was not before, whatever rounding says.
            if (is_after_removal_)
              u = std::min(u, before.brick ? static_cast<double>(before.brick->u[static_cast<std::size_t>(k)])
                                           : (before.is_solid ? out_.far_ : -out_.far_));
            brick->u[static_cast<std::size_t>(k)] = static_cast<float>(u);
            is_near = is_near || std::abs(u) < out_.far_;
            is_solid = is_solid || u > 0;
          }
          slot.is_solid = is_solid;
          slot.brick = is_near || has_both(*brick) ? std::move(brick) : nullptr;
        }
  }

  /// Is there any matter in a box that holds no surface? Where that was missed the tool is held off.
  bool has_matter(const VoxelKinds& kinds, const dvec3& low, const dvec3& high) const {
    const ivec3 first = voxel_of(low), last = voxel_of(high);
    for (int z = first.z; z <= last.z; ++z)
      for (int y = first.y; y <= last.y; ++y)
        for (int x = first.x; x <= last.x; ++x)
          if (const VoxelKinds::Kind kind = kinds.at({x, y, z}); kind != VoxelKinds::free) {
            if (kind == VoxelKinds::solid) return true;
            // Of a mixed voxel what lies in the box.
            const dvec3 v(x, y, z), from = glm::max(low, v - 0.5), to = glm::min(high, v + 0.5);
            for (int corner = 0; corner < 8; ++corner)
              if (surface_.is_solid(
                      {corner & 1 ? to.x : from.x, corner & 2 ? to.y : from.y, corner & 4 ? to.z : from.z}))
                return true;
          }
    return false;
  }

  /// How deep in the solid (mm) samples may lie that count.
  double inner_reach() const { return std::max(0.0, (k_band + 1) * out_.step_ - out_.radius_); }
  bool is_solid_voxel(const ivec3& v) const {
    return field_.volume().contains(v) && bits_.is_solid(v) && (version_ == nullptr || version_->is_kept(v));
  }
  static bool has_both(const Brick& brick) {
    const auto [low, high] = std::minmax_element(brick.u.begin(), brick.u.end());
    return *low < 0 && *high > 0;
  }

  OffsetField& out_;
  const Field& field_;
  const Occupancy& bits_;
  const Version* version_;
  bool is_after_removal_;  ///< the field had bricks before, of a solid that held this one
  SmoothSurface surface_;
};

Result<std::shared_ptr<const OffsetField>> OffsetField::build(const Field& field, const Occupancy& bits,
                                                              const Version* version, double radius,
                                                              int threads, Work* work) {
  const auto begin = std::chrono::steady_clock::now();
  ++work_counters().offset_fields;
  const Frame& base = field.volume().frame;
  const dvec3 extent = base.spacing() * dvec3(field.volume().size);
  if (!(radius > 0 && radius <= 20) || radius > std::max({extent.x, extent.y, extent.z}))
    return Error{"the tool's radius is out of range", "radius", std::to_string(radius) + " mm",
                 "above 0, at most 20 mm and no larger than the volume", ""};
  const dvec3& spacing = base.spacing();
  const double step = std::max(radius / k_steps_a_radius, std::min({spacing.x, spacing.y, spacing.z}));
  std::shared_ptr<OffsetField> result(new OffsetField);
  result->radius_ = radius;
  result->step_ = step;
  result->far_ = k_band * step;
  // The volume's axes with steps of equal length, and room for the tool beyond every border.
  glm::dmat3 axes;
  dvec3 origin(0);
  for (int a = 0; a < 3; ++a) axes[a] = base.axes()[a] * (step / spacing[a]);
  auto shape = Frame::from_axes(base.origin(), axes);
  if (!shape) return shape.error();
  result->frame_ = shape.value();
  const ivec3 beyond = result->steps_within(radius + (k_band + 2) * step);
  for (int a = 0; a < 3; ++a) {
    result->size_[a] = static_cast<int>(std::ceil(extent[a] / step)) + 2 * beyond[a];
    origin[a] = -static_cast<double>(beyond[a]) * (step / spacing[a]);
  }
  auto frame = Frame::from_axes(base.world_from_volume(origin), axes);
  if (!frame) return frame.error();
  result->frame_ = frame.value();
  result->slots_size_ = (result->size_ + (k_edge - 1)) / k_edge;
  result->pages_size_ = (result->slots_size_ + 3) / 4;
  result->pages_.resize(static_cast<std::size_t>(result->pages_size_.x) *
                        static_cast<std::size_t>(result->pages_size_.y) *
                        static_cast<std::size_t>(result->pages_size_.z));
  result->own_pages(ivec3(0), result->slots_size_ - 1);
  Work done;
  Builder(*result, field, bits, version, false)
      .run(ivec3(0), result->slots_size_ * k_edge - 1, threads, done);
  done.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  if (work) *work = done;
  return std::shared_ptr<const OffsetField>(std::move(result));
}

std::shared_ptr<const OffsetField> OffsetField::updated(const Field& field, const Occupancy& bits,
                                                        const Version& version, const VoxelBox& changed,
                                                        int threads, Work* work) const {
  const auto begin = std::chrono::steady_clock::now();
  ++work_counters().offset_fields;
  std::shared_ptr<OffsetField> result(new OffsetField(*this));
  const double reach = radius_ + (k_band + 1) * step_;
  const Frame& base = field.volume().frame;
  const ivec3 beyond = steps_within(reach) + 2;
  const auto lattice = [&](const ivec3& v) {
    return frame_.volume_from_world(base.world_from_volume(dvec3(v)));
  };
  // Whole bricks of all that may have changed.
  ivec3 low = (ivec3(glm::floor(lattice(changed.low))) - beyond) / k_edge,
        high = (ivec3(glm::ceil(lattice(changed.high))) + beyond) / k_edge;
  low = glm::clamp(low, ivec3(0), slots_size_ - 1) * k_edge;
  high = glm::clamp(high, ivec3(0), slots_size_ - 1) * k_edge + (k_edge - 1);
  result->own_pages(low / k_edge, high / k_edge);
  Work done;
  Builder(*result, field, bits, &version, true).run(low, high, threads, done);
  done.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  if (work) *work = done;
  return result;
}

void OffsetField::own_pages(const ivec3& low, const ivec3& high) {
  for (int z = low.z >> 2; z <= high.z >> 2; ++z)
    for (int y = low.y >> 2; y <= high.y >> 2; ++y)
      for (int x = low.x >> 2; x <= high.x >> 2; ++x) {
        auto& page = pages_[page_index({4 * x, 4 * y, 4 * z})];
        page = page ? std::make_shared<Page>(*page) : std::make_shared<Page>();
      }
}

/// Lattice steps along each axis that a ball of `mm` reaches, sheared axes included.
ivec3 OffsetField::steps_within(double mm) const noexcept {
  ivec3 steps;
  for (int a = 0; a < 3; ++a) {
    dvec3 along(0);
    along[a] = 1;
    steps[a] = static_cast<int>(std::ceil(mm * glm::length(frame_.gradient_world_from_volume(along))));
  }
  return steps;
}

std::size_t OffsetField::bytes() const noexcept {
  std::size_t bricks = 0;
  for (const auto& page : pages_)
    for (const Slot& slot : page->entries) bricks += slot.brick != nullptr;
  return pages_.size() * (sizeof(Page) + sizeof pages_[0]) + bricks * sizeof(Brick);
}

double OffsetField::at(int x, int y, int z) const noexcept {
  if (!contains({x, y, z})) return -far_;
  const Slot& slot = this->slot({x >> 3, y >> 3, z >> 3});
  if (!slot.brick) return slot.is_solid ? far_ : -far_;
  return static_cast<double>(
      slot.brick->u[static_cast<std::size_t>(((z & 7) * k_edge + (y & 7)) * k_edge + (x & 7))]);
}

void OffsetField::load(const ivec3& v, QuadraticPatch& patch) const noexcept {
  const int bx = v.x & 7, by = v.y & 7, bz = v.z & 7;
  const auto is_within = [](int b) { return b >= 1 && b + 1 < k_edge; };
  if (is_within(bx) && is_within(by) && is_within(bz) && contains(v)) {
    if (const Brick* brick = slot({v.x >> 3, v.y >> 3, v.z >> 3}).brick.get()) {
      for (int k = 0; k < 3; ++k)
        for (int j = 0; j < 3; ++j) {
          const float* row = brick->u.data() +
                             static_cast<std::size_t>(((bz + k - 1) * k_edge + by + j - 1) * k_edge + bx - 1);
          patch.set_row(j, k, static_cast<double>(row[0]), static_cast<double>(row[1]),
                        static_cast<double>(row[2]));
        }
      return;
    }
  }
  for (int k = 0; k < 3; ++k)
    for (int j = 0; j < 3; ++j)
      patch.set_row(j, k, at(v.x - 1, v.y + j - 1, v.z + k - 1), at(v.x, v.y + j - 1, v.z + k - 1),
                    at(v.x + 1, v.y + j - 1, v.z + k - 1));
}

bool OffsetField::is_free_around(const ivec3& v) const noexcept {
  const ivec3 low = glm::clamp(v - 1, ivec3(0), size_ - 1) >> 3,
              high = glm::clamp(v + 1, ivec3(0), size_ - 1) >> 3;
  for (int z = low.z; z <= high.z; ++z)
    for (int y = low.y; y <= high.y; ++y)
      for (int x = low.x; x <= high.x; ++x) {
        const Slot& slot = this->slot({x, y, z});
        if (slot.brick || slot.is_solid) return false;
      }
  return true;
}

VoxelBox OffsetField::free_box(const ivec3& v) const noexcept {
  if (!contains(v) || !is_free_around(v)) return {ivec3(0), ivec3(-1)};
  const ivec3 b = v >> 3;
  const Slot& slot = this->slot(b);
  if (slot.brick || slot.is_solid) return {ivec3(0), ivec3(-1)};
  // Within a free brick, but for its faces, whose cubes read the neighbours.
  const ivec3 low = b * k_edge + 1, high = b * k_edge + (k_edge - 2);
  const bool is_inner = glm::all(glm::greaterThanEqual(v, low)) && glm::all(glm::lessThanEqual(v, high));
  return is_inner ? VoxelBox{low, high} : VoxelBox{v, v};
}

}  // namespace trephine::volume
