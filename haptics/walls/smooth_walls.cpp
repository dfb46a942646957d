// One file: all queries share the cache of patches and the tests of occupancy.
#include "haptics/walls/smooth_walls.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace trephine::haptics {

using glm::dvec3;
using glm::ivec3;

namespace {

constexpr double k_rounding = 1e-11;  // share of a patch's magnitude by which its evaluation may be off
constexpr double k_short = 0.998;     // share of a free step, so that a motion never ends on the wall itself
constexpr int k_max_proofs = 24;      // evaluations in one cube before the motion counts as blocked

}  // namespace

double free_step(double c, double derivative, double second_derivative) noexcept {
  const double root = std::sqrt(std::max(0.0, derivative * derivative - 2 * second_derivative * c));
  const double denominator = derivative + root;
  return denominator > 0 ? -2 * c / denominator : 1e300;
}

double rounding_of(const volume::ValueAndGradient& field,
                   const volume::QuadraticPatch::HessianBound& hessian) noexcept {
  const dvec3& g = field.gradient;
  return k_rounding * (1 + std::abs(field.value) + std::abs(g.x) + std::abs(g.y) + std::abs(g.z) +
                       hessian.pure.x + hessian.pure.y + hessian.pure.z);
}

const volume::QuadraticPatch::HessianBound& SmoothWalls::hessian_bound_of(Cached& cached) const noexcept {
  if (!cached.has_hessian_bound) {
    cached.hessian_bound = cached.patch.hessian_bound();
    cached.has_hessian_bound = true;
    if (cached.key == k_cut && is_fine_) rescale(cached.hessian_bound, version_->lattice().scale());
  }
  return cached.hessian_bound;
}

volume::ValueAndGradient SmoothWalls::cut_value_and_gradient(const volume::CutLattice::Point& at) noexcept {
  volume::ValueAndGradient field = patch(k_cut, at.sample).patch.value_and_gradient(at.at);
  if (is_fine_) rescale(field, version_->lattice().scale());
  return field;
}

SmoothWalls::Cached& SmoothWalls::patch(int key, const ivec3& v) noexcept {
  Cached* slot = nullptr;
  if (large_) {
    const auto part = [](int i, std::uint32_t factor) { return static_cast<std::uint32_t>(i) * factor; };
    const std::uint32_t hash =
        part(v.x, 1) + part(v.y, 7) + part(v.z, 61) + part(key, 0x9e3779b1u);  // neighbours have other slots
    const std::size_t index = hash % LargeCache::k_slots + (key == k_cut ? LargeCache::k_slots : 0);
    slot = &large_->all[index];
    if (std::exchange(large_->is_used[index], true) && slot->key == key && slot->voxel == v) return *slot;
  } else {
    for (int i = 0; i < count_; ++i)
      if (Cached& cached = cache_[static_cast<std::size_t>(i)]; cached.key == key && cached.voxel == v)
        return cached;
    count_ = std::min(count_ + 1, k_cached);
    slot = &cache_[static_cast<std::size_t>(next_)];
    next_ = next_ + 1 == k_cached ? 0 : next_ + 1;
  }
  Cached& fresh = *slot;
  fresh.key = key;
  fresh.voxel = v;
  fresh.has_hessian_bound = false;
  if (key == k_cut)
    fresh.patch.load_distance(*version_, v);
  else if (is_round_ && key >> k_sheet_shift != 0)
    offset(static_cast<std::size_t>(key & ((1 << k_sheet_shift) - 1)))
        .load_sheet((key >> k_sheet_shift) - 1, v, fresh.patch);
  else if (is_round_)
    offset(static_cast<std::size_t>(key)).load(v, fresh.patch);
  else if (const TouchItem& shape = scene_->items[static_cast<std::size_t>(key)]; shape.soft)
    shape.soft->load(v, fresh.patch);
  else
    fresh.patch.load(shape.field, v);
  ++counters_->cells;
  return fresh;
}

bool SmoothWalls::is_near_cut(const ivec3& v) const noexcept {
  if (!is_cut_) return false;
  const volume::CutLattice& lattice = version_->lattice();
  return version_->has_brick(lattice.low_of(v) - 1, lattice.high_of(v) + 1);
}

namespace {

/// Returns true if all voxels within `reach` (at most 31) of v are air.
bool are_air(const volume::Occupancy& bits, const ivec3& size, const ivec3& v, int reach) noexcept {
  const int x0 = std::max(v.x - reach, 0), x1 = std::min(v.x + reach, size.x - 1);
  if (x0 > x1) return true;
  for (int z = std::max(v.z - reach, 0); z <= std::min(v.z + reach, size.z - 1); ++z)
    for (int y = std::max(v.y - reach, 0); y <= std::min(v.y + reach, size.y - 1); ++y) {
      const std::uint64_t* row = bits.row(y, z);
      std::uint64_t few = row[x0 >> 6] >> (x0 & 63);
      if ((x0 >> 6) != (x1 >> 6)) few |= row[x1 >> 6] << (64 - (x0 & 63));
      if (few & ((2ull << (x1 - x0)) - 1)) return false;
    }
  return true;
}

}  // namespace

bool SmoothWalls::is_free_within(int shape, const dvec3& p, double steps, double mm) const noexcept {
  if (!blocks(shape, Side::front)) return true;
  // The smooth solid lies only in solid voxels and their neighbours. For p beyond the grid, the nearest point
  // of the grid is tested.
  const dvec3 at = glm::clamp(p, dvec3(0), dvec3(volume_->size) - 1.0);
  const dvec3 beyond = glm::abs(p - at);
  if (std::max({beyond.x, beyond.y, beyond.z}) - 1.5 >= steps) return true;
  const ivec3 v = volume::voxel_of(at);
  const int blocks_away = empty_distance(shape, v);
  if (blocks_away > 1 && 4 * (blocks_away - 1) - 1 >= steps) return true;
  const TouchItem& item = scene_->items[static_cast<std::size_t>(shape)];
  const dvec3 from_centre = glm::abs(at - dvec3(v));
  const double to_border = 0.5 - std::max({from_centre.x, from_centre.y, from_centre.z});
  const bool is_extended = item.soft && item.soft->is_extended();
  if (!is_extended && to_border + 1 >= steps && are_air(*item.bits, volume_->size, v, 2)) return true;
  if (to_border >= steps && is_air_around(shape, v)) return true;
  if (!is_cut_ || !is_near_cut(v)) return false;
  // The smooth distance to removed matter deviates from the sampled one by less than a step of its lattice.
  const dvec3& spacing = version_->lattice().frame().spacing();
  return -version_->distance(p) - std::max({spacing.x, spacing.y, spacing.z}) >= mm;
}

bool SmoothWalls::is_air_within(int shape, const dvec3& p, double steps) const noexcept {
  constexpr double k_most = 16;
  if (!(steps <= k_most)) return false;
  const TouchItem& item = scene_->items[static_cast<std::size_t>(shape)];
  // The cubes within `steps` of p, and one more, because the smooth solid extends to neighbours of solid
  // voxels.
  const int overlap = item.soft && item.soft->is_extended() ? volume::SoftField::k_overlap : 0;
  return are_air(*item.bits, volume_->size, volume::voxel_of(p), static_cast<int>(steps) + 2 + overlap);
}

int SmoothWalls::empty_distance(int shape, const ivec3& v) const noexcept {
  const TouchItem& item = scene_->items[static_cast<std::size_t>(shape)];
  // The extension of a soft shape fits into one block of four voxels.
  static_assert(volume::SoftField::k_overlap <= 4);
  const int extension = item.soft && item.soft->is_extended() ? 1 : 0;
  return item.bits->empty_distance(v) - extension;
}

bool SmoothWalls::is_air_around(int shape, const ivec3& v) const noexcept {
  const auto item = [this](int s) -> const TouchItem& { return scene_->items[static_cast<std::size_t>(s)]; };
  if (!are_air(*item(shape).bits, volume_->size, v, 1)) return false;
  // A soft shape may extend beyond its own bits.
  const volume::SoftField* soft = item(shape).soft.get();
  return !soft || !soft->is_extended() || soft->is_air_around(v);
}

volume::Jet SmoothWalls::jet(const Wall& wall, const dvec3& p) noexcept {
  volume::Jet jet;
  if (wall.is_cut) {
    const volume::CutLattice& lattice = version_->lattice();
    const volume::CutLattice::Point at = lattice.point_of(p);
    jet = patch(k_cut, at.sample).patch.jet(at.at);
    if (is_fine_) rescale(jet, lattice.scale());
  } else {
    const Cached& cached = patch_of(wall, volume::voxel_of(p));
    jet = cached.patch.jet(p - dvec3(cached.voxel));
  }
  if (wall.is_back) {
    jet.value = -jet.value;
    jet.gradient = -jet.gradient;
    jet.hessian_diagonal = -jet.hessian_diagonal;
    jet.hessian_mixed = -jet.hessian_mixed;
  }
  return jet;
}

volume::ValueAndGradient SmoothWalls::value_and_gradient(const Wall& wall, const dvec3& p) noexcept {
  volume::ValueAndGradient field;
  if (wall.is_cut) {
    field = cut_value_and_gradient(version_->lattice().point_of(p));
  } else {
    const Cached& cached = patch_of(wall, volume::voxel_of(p));
    field = cached.patch.value_and_gradient(p - dvec3(cached.voxel));
  }
  if (wall.is_back) {
    field.value = -field.value;
    field.gradient = -field.gradient;
  }
  return field;
}

SmoothWalls::CubeSpan SmoothWalls::cubes_of(const Wall& wall, const dvec3& a, const dvec3& b) const noexcept {
  const volume::CutLattice& lattice = version_->lattice();
  const ivec3 u = wall.is_cut ? lattice.point_of(a).sample : volume::voxel_of(a),
              v = wall.is_cut ? lattice.point_of(b).sample : volume::voxel_of(b);
  return {glm::min(u, v), glm::max(u, v)};
}

void SmoothWalls::widen(const Wall& wall, const Span& span, const dvec3& m,
                        volume::QuadraticPatch::HessianBound& bound, bool& is_whole) noexcept {
  const CubeSpan cubes = cubes_of(wall, span.a, span.b), at = cubes_of(wall, m, m),
                 both(glm::min(cubes.first, at.first), glm::max(cubes.second, at.second));
  if (both != cubes) bound = bound_over(wall, both, is_whole);
}

volume::QuadraticPatch::HessianBound SmoothWalls::hessian_bound(const Wall& wall, const Span& span,
                                                                bool& is_whole, int most) noexcept {
  return bound_over(wall, cubes_of(wall, span.a, span.b), is_whole, most);
}

volume::QuadraticPatch::HessianBound SmoothWalls::bound_over(const Wall& wall, const CubeSpan& cubes,
                                                             bool& is_whole, int most) noexcept {
  const auto& [low, high] = cubes;
  is_whole = true;
  const auto bound_at = [&](const ivec3& v) -> const volume::QuadraticPatch::HessianBound& {
    return hessian_bound_of(wall.is_cut ? patch(k_cut, v) : patch_of(wall, v));
  };
  volume::QuadraticPatch::HessianBound bound = bound_at(low);
  if (low == high) return bound;
  const auto add = [&](const ivec3& v) {
    const auto& here = bound_at(v);
    bound.pure = glm::max(bound.pure, here.pure);
    bound.cross = glm::max(bound.cross, here.cross);
  };
  const ivec3 extent = high - low + 1;
  is_whole = extent.x * extent.y * extent.z <= most;
  if (!is_whole) {
    add(high);
    return bound;
  }
  for (int z = low.z; z <= high.z; ++z)
    for (int y = low.y; y <= high.y; ++y)
      for (int x = low.x; x <= high.x; ++x) add({x, y, z});
  return bound;
}

bool SmoothWalls::is_solid(int shape, const dvec3& p) noexcept {
  if (value_and_gradient({shape, false, false}, p).value < 0) return false;
  const ivec3 cube = volume::voxel_of(p);
  if (const volume::CreaseSheets::Mask sheets = sheets_at(shape, cube); sheets != 0) {
    for (volume::CreaseSheets::Mask rest = sheets; rest != 0; rest &= rest - 1)
      if (value_and_gradient({shape, false, false, 0, std::countr_zero(rest), cube}, p).value >= 0)
        return true;
    return false;
  }
  return !is_near_cut(cube) || value_and_gradient({shape, true, false}, p).value >= 0;
}

bool SmoothWalls::is_covered(int shape, const ShapeSet& inside, const ivec3& v) noexcept {
  if (end_ - begin_ < 2 || !is_near_cut(v) || inside.contains(shape) || !blocks(shape, Side::front))
    return false;
  for (int other = next_shape(0); other < ShapeSet::k_max; other = next_shape(other + 1)) {
    if (other == shape || inside.contains(other) || !blocks(other, Side::front)) continue;
    if (!(patch(other, v).patch.minimum() > 0)) continue;
    if (other < shape || !(patch(shape, v).patch.minimum() > 0))
      return true;  // if two shapes fill the cube, the first one keeps its wall
  }
  return false;
}

int SmoothWalls::walls_at(int shape, const ShapeSet& inside, const dvec3& p, double,
                          WallList& walls) noexcept {
  const bool is_inside = inside.contains(shape);
  if (is_covered(shape, inside, volume::voxel_of(p))) return 0;
  const bool has_cut = is_near_cut(volume::voxel_of(p));
  walls[0] = {shape, false, is_inside};
  if (const volume::CreaseSheets::Mask sheets = is_inside ? 0 : sheets_at(shape, volume::voxel_of(p));
      sheets != 0)
    return sheets_near(shape, sheets, p, walls);
  if (!has_cut) return 1;
  walls[1] = {shape, true, is_inside};
  if (is_inside) return 2;
  // A point is free if either function is negative there: the wall of the smaller depth decides.
  const auto depth = [&](const Wall& wall) {
    const volume::ValueAndGradient s = value_and_gradient(wall, p);
    const double steepness = glm::length(s.gradient);
    return steepness > 0 ? s.value / steepness : s.value < 0 ? -1e300 : 1e300;
  };
  if (depth(walls[1]) < depth(walls[0])) walls[0] = walls[1];
  return 1;
}

double SmoothWalls::reach_in_piece(const Wall& field, const ivec3& v, const ivec3* sample, const Leg& leg,
                                   double t0, double t1, Wall& blocker) noexcept {
  const bool is_inside = field.is_back;
  const dvec3 &a = leg.a, &along = leg.along, origin = a - dvec3(v);
  const volume::CutLattice& lattice = version_->lattice();
  const auto in_cube = [&](double t) {
    const dvec3 p = origin + t * along;
    return is_fine_ ? p * lattice.scale() - dvec3(*sample - lattice.centre_of(v)) : p;
  };
  // Returns the length, in units of t, of the free part of the leg that begins at t, forward (direction 1) or
  // backward (-1), as proven by the field alone or by the cut alone.
  const auto proven = [&](bool is_cut, double t, double direction) {
    volume::ValueAndGradient s;
    Cached& cached = is_cut ? patch(k_cut, *sample) : patch_of(field, v);
    if (is_cut)
      s = cut_value_and_gradient({*sample, in_cube(t)});
    else
      s = cached.patch.value_and_gradient(origin + t * along);
    const auto& hessian = hessian_bound_of(cached);
    const double sign = is_inside ? -1.0 : 1.0;
    const double c = sign * s.value + rounding_of(s, hessian);
    if (c >= 0) return 0.0;
    return free_step(c, sign * direction * glm::dot(s.gradient, along), hessian.along(along));
  };
  const auto step_from = [&](double t, double direction, bool& by_cut) {
    by_cut = false;
    const double by_field = proven(false, t, direction);
    if (sample == nullptr) return by_field;
    // From outside one of the two proofs suffices; from inside both are required.
    if (!is_inside && by_field >= t1 - t0) return by_field;
    const double other = proven(true, t, direction);
    by_cut = is_inside ? other < by_field : other > by_field;
    return by_cut ? other : by_field;
  };
  double t = t0, end = t1;
  bool by_cut = false;
  for (int i = 0; i < k_max_proofs; ++i) {
    const double forward = step_from(t, 1, by_cut);
    if (t + forward >= end) return t1;
    if (forward < leg.min_step) break;
    t += k_short * forward;
    bool ignored = false;
    const double backward = step_from(end, -1, ignored);
    if (end - backward <= t) return t1;
    if (backward > leg.min_step) end -= backward;
  }
  blocker = {field.shape, by_cut, is_inside, 0, by_cut ? -1 : field.sheet, v};
  return t;
}

double SmoothWalls::reach_in_cube(int shape, bool is_inside, const ivec3& v, const Leg& leg, double t0,
                                  double t1, Wall& blocker) noexcept {
  const Wall field{shape, false, is_inside};
  if (!is_near_cut(v)) {
    const double free = reach_in_piece(field, v, nullptr, leg, t0, t1, blocker);
    const volume::CreaseSheets::Mask sheets = free < t1 && !is_inside ? sheets_at(shape, v) : 0;
    if (sheets == 0) return free;
    // A motion that is free of the field is free of all its sheets.
    double end = t1;
    for (volume::CreaseSheets::Mask rest = sheets; rest != 0 && end > free; rest &= rest - 1) {
      Wall sheet;
      const Wall one{shape, false, false, 0, std::countr_zero(rest), v};
      if (const double t = reach_in_piece(one, v, nullptr, leg, free, end, sheet); t < end)
        end = t, blocker = sheet;
    }
    return end;
  }
  const volume::CutLattice& lattice = version_->lattice();
  if (!is_fine_) {
    const ivec3 sample = lattice.centre_of(v);
    return reach_in_piece(field, v, &sample, leg, t0, t1, blocker);
  }
  // Without matter the cut need not be evaluated.
  if (!is_inside && patch(shape, v).patch.maximum() < 0) return t1;
  // Walks through the sample cubes that the leg meets. Rounding may leave short segments before the first and
  // after the last one, which are tested with the nearest sample.
  const volume::Segment in_samples(lattice.lattice_from_volume(leg.a),
                                   lattice.lattice_from_volume(leg.a + leg.along));
  volume::VoxelWalk walk(in_samples, {lattice.low_of(v), lattice.high_of(v)});
  ivec3 sample = lattice.point_of(leg.a + 0.5 * (t0 + t1) * leg.along).sample;
  sample = glm::clamp(sample, lattice.low_of(v), lattice.high_of(v));
  for (double t = t0; t < t1;) {
    double end = t1;
    if (!walk.is_done()) {
      sample = walk.voxel();
      // In a hollow brick all is free, except at its faces, where cubes read the neighbours.
      if (!is_inside && lattice.contains(sample)) {
        const volume::Brick* brick = version_->brick_at(sample);
        const volume::VoxelBox core{(sample >> 3 << 3) + 1, (sample >> 3 << 3) + (volume::k_brick - 2)};
        if (brick && brick->is_hollow && core.contains(sample)) {
          walk.advance_past(core);
          t = walk.is_done() ? t1 : std::max(t, walk.t_enter());
          continue;
        }
      }
      end = std::clamp(walk.t_exit(), t, t1);
      walk.advance();
      if (walk.is_done()) end = t1;
    }
    ++counters_->voxels;
    const double free = reach_in_piece(field, v, &sample, leg, t, end, blocker);
    if (free < end) return free;
    t = end;
  }
  return t1;
}

void SmoothWalls::pass(int shape, const ivec3& v, const dvec3& a, const dvec3& along, double t0, double t1,
                       ShapeSet& inside, double& t_changed) noexcept {
  const int steps = 1 + static_cast<int>(8 * (t1 - t0) * glm::length(along));
  const bool was_inside = inside.contains(shape);
  const bool has_cut = is_near_cut(v);
  for (int i = 1; i <= std::min(steps, 16); ++i) {
    const double t = t0 + (t1 - t0) * i / std::min(steps, 16);
    const dvec3 p = a + t * along;
    // A point on the surface within rounding (at the end of a cube, or on the border of the grid) does not
    // count as having passed it. Otherwise the next cube would block the motion at its first point.
    Cached& cached = patch(shape, v);
    const volume::ValueAndGradient scan = cached.patch.value_and_gradient(p - dvec3(v));
    const double tolerance = rounding_of(scan, hessian_bound_of(cached));
    bool is_solid = scan.value > tolerance, is_free = scan.value < -tolerance;
    if (has_cut) {
      const volume::ValueAndGradient cut = value_and_gradient({shape, true, false}, p);
      is_solid = is_solid && cut.value > 0;
      is_free = is_free || cut.value < 0;
    }
    const bool is_now = was_inside ? !is_free : is_solid;
    if (is_now == was_inside) continue;
    inside.flip(shape);
    t_changed = t;
    return;
  }
  t_changed = t1;
}

Reach SmoothWalls::reach(const dvec3& a, const dvec3& b, ShapeSet& inside, double tolerance) noexcept {
  const dvec3 along = b - a;
  const double length = glm::length(frame().vector_world_from_volume(along));
  if (!(length > 0)) return {};
  const Leg leg{a, along, tolerance / length};

  // Changes of `inside` at a position t. Those behind the wall of a shape that is tested later are reverted.
  struct InsideChange {
    int shape;
    double t;
  };
  const auto cube = [&](const ivec3& v, double t0, double t1, Reach& reach, bool is_known_near) {
    std::array<InsideChange, 32> inside_changes;
    std::size_t change_count = 0;
    for (int s = next_shape(0); s < ShapeSet::k_max; s = next_shape(s + 1)) {
      double from = t0;
      for (int turn = 0; turn < 4 && from < reach.t; ++turn) {
        const bool is_inside = inside.contains(s);
        if (!is_inside && !is_known_near &&
            (is_round_ ? offset(static_cast<std::size_t>(s)).is_free_around(v) : is_air_around(s, v)))
          break;
        if (is_covered(s, inside, v)) break;
        if (blocks(s, side_of(is_inside))) {
          Wall wall;
          const double free = reach_in_cube(s, is_inside, v, leg, from, std::min(t1, reach.t), wall);
          if (free < std::min(t1, reach.t)) reach = {free, true, wall};
          break;
        }
        const ShapeSet before = inside;
        pass(s, v, a, along, from, std::min(t1, reach.t), inside, from);
        if (inside != before && change_count < inside_changes.size())
          inside_changes[change_count++] = {s, from};
        if (from >= t1) break;
      }
    }
    for (std::size_t i = 0; i < change_count; ++i)
      if (inside_changes[i].t > reach.t) inside.flip(inside_changes[i].shape);
  };

  Reach reach;
  const ivec3 first = volume::voxel_of(a);
  if (first == volume::voxel_of(b)) {
    ++counters_->voxels;
    cube(first, 0, 1, reach, true);
    return reach;
  }
  // A cube's polynomial reads one voxel around it, so that matter may extend one voxel beyond the grid.
  const ivec3 size = grid_size();
  const volume::VoxelBox box{ivec3(-1), size};
  volume::VoxelWalk walk(volume::Segment(a, b), box);
  while (!walk.is_done()) {
    const ivec3 v = walk.voxel();
    ++counters_->voxels;
    if (is_round_ && inside.is_empty()) {
      const int first = next_shape(0);
      volume::VoxelBox free = offset(static_cast<std::size_t>(first)).free_box(v);
      for (int s = next_shape(first + 1); s < ShapeSet::k_max; s = next_shape(s + 1)) {
        const volume::VoxelBox other = offset(static_cast<std::size_t>(s)).free_box(v);
        free = {glm::max(free.low, other.low), glm::min(free.high, other.high)};
      }
      if (free.contains(v)) {
        walk.advance_past(free);
        continue;
      }
    } else if (inside.is_empty() && volume_->contains(v)) {
      int far = 255;
      for (int s = next_shape(0); s < ShapeSet::k_max; s = next_shape(s + 1))
        far = std::min(far, empty_distance(s, v));
      if (far > 1) {
        const ivec3 block(v.x >> 2, v.y >> 2, v.z >> 2);
        walk.advance_past({4 * (block - (far - 2)), 4 * (block + (far - 1)) - 1});
        continue;
      }
    }
    cube(v, walk.t_enter(), walk.t_exit(), reach, false);
    if (reach.is_blocked) {
      // The solid may be discontinuous at the faces of creased cubes. The motion ends a little before the
      // face, so that rounding cannot move its end into the next cube.
      constexpr double k_clear = 1e-7;  // voxels
      if (is_round_ && reach.t <= walk.t_enter()) {
        reach.t = std::max(0.0, walk.t_enter() - k_clear / glm::length(along));
        if (v != first && offset(static_cast<std::size_t>(reach.wall.shape)).has_sheets())
          reach.wall.is_step = true, reach.wall.cube = v;
      }
      return reach;
    }
    walk.advance();
  }
  return reach;
}

}  // namespace trephine::haptics
