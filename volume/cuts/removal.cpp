#include "volume/cuts/removal.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_access.hpp>
#include <glm/matrix.hpp>

#include "volume/cuts/removal_shape.h"

namespace trephine::volume {

namespace {

constexpr std::uint64_t k_all = ~std::uint64_t{0};

CellPoints cell_points(int n, const Frame& lattice) {
  CellPoints points;
  points.n = n;
  for (int i = 0; i < n * n * n; ++i) {
    const auto offset = [n](int k) { return (static_cast<float>(k) + 0.5f) / static_cast<float>(n) - 0.5f; };
    points.x[i] = offset(i % n), points.y[i] = offset(i / n % n), points.z[i] = offset(i / (n * n));
    float square = 0;
    for (int a = 0; a < 3; ++a) {
      const float o = points.x[i] * static_cast<float>(lattice.axes()[0][a]) +
                      points.y[i] * static_cast<float>(lattice.axes()[1][a]) +
                      points.z[i] * static_cast<float>(lattice.axes()[2][a]);
      square += o * o;
    }
    points.squared[i] = square;
  }
  return points;
}

}  // namespace

VoxelBox union_of(const VoxelBox& a, const VoxelBox& b) noexcept {
  if (a.low.x > a.high.x) return b;
  if (b.low.x > b.high.x) return a;
  return {glm::min(a.low, b.low), glm::max(a.high, b.high)};
}

void add(RemovalReport& sum, const RemovalReport& report) noexcept {
  sum.removed_units += report.removed_units;
  sum.bricks_changed += report.bricks_changed;
  sum.intensity_sum += report.intensity_sum;
  sum.intensity_square_sum += report.intensity_square_sum;

  sum.box = union_of(sum.box, report.box);
}

RemovalEditor::RemovalEditor(std::shared_ptr<const Version> start, std::vector<Field> solids,
                             const RemovalKernels& kernels)
    : solids_(std::move(solids)), kernels_(&kernels) {
  const Frame& lattice = start->lattice().frame();
  auto points = std::make_shared<std::array<CellPoints, 2>>();
  *points = {cell_points(4, lattice), cell_points(8, lattice)};
  points_ = std::move(points);
  reset(std::move(start));
}

RemovalEditor::RemovalEditor(const RemovalEditor& other)
    : next_(std::make_shared<Version>(*other.next_)),
      solids_(other.solids_),
      kernels_(other.kernels_),
      points_(other.points_),
      frozen_strokes_(std::make_shared<std::atomic<std::uint64_t>>(0)) {
  next_->stroke_ = 0;
  next_->frozen_strokes_ = frozen_strokes_;
}

RemovalEditor& RemovalEditor::operator=(const RemovalEditor& other) {
  RemovalEditor copy(other);
  return *this = std::move(copy);
}

void RemovalEditor::reset(std::shared_ptr<const Version> start) {
  const std::uint64_t serial = next_ ? std::max(next_->serial_, start->serial_) : start->serial_;
  next_ = std::make_shared<Version>(*start);
  next_->serial_ = serial + 1;
  next_->stroke_ = 0;
  next_->frozen_strokes_ = frozen_strokes_;
  end_stroke();
}

std::uint64_t RemovalEditor::next_stroke() noexcept {
  static std::atomic<std::uint64_t> last{0};
  return ++last;
}

void RemovalEditor::end_stroke() noexcept {
  frozen_strokes_->store(stroke_, std::memory_order_release);
  stroke_ = next_stroke();
}

std::shared_ptr<const Version> RemovalEditor::publish() {
  std::shared_ptr<const Version> done = std::move(next_);
  next_ = std::make_shared<Version>(*done);
  ++next_->serial_;
  return done;
}

namespace {
/// Returns the object of a slot, which version `serial` may write. Replaces an object of an older version by
/// a new object, into which copy(old, fresh) copies the contents. Puts a new object into an empty slot.
template <class T, class Copy>
T& editable(Ref<T>& slot, std::uint64_t serial, Copy&& copy) {
  if (!slot || slot->serial != serial) {
    auto* fresh = new T;
    if (slot) copy(*slot, *fresh);
    fresh->serial = serial;
    slot = Ref<T>(fresh);
  }
  return *slot;
}
}  // namespace

Ref<Brick>& RemovalEditor::editable_slot(const glm::ivec3& s) {
  Region& region = editable(next_->regions_[next_->region_index(s)], next_->serial_,
                            [](const Region& old, Region& fresh) { fresh.pages = old.pages; });
  Page& page = editable(region.pages[Version::page_index(s)], next_->serial_,
                        [](const Page& old, Page& fresh) { fresh.bricks = old.bricks; });
  return page.bricks[Version::brick_index(s)];
}

Brick& RemovalEditor::swept_brick(const glm::ivec3& s, const BrickSweep& sweep) {
  Ref<Brick>& slot = editable_slot(s);
  if (!slot) ++next_->brick_count_;
  Brick& brick =
      editable(slot, next_->serial_, [](const Brick& old, Brick& fresh) { fresh.mask = old.mask; });
  // The distances of the sweep are already the smaller of old and new ones.
  std::memcpy(brick.distance.data(), sweep.distance, sizeof sweep.distance);
  std::copy_n(sweep.kept, k_brick, brick.kept.begin());
  return brick;
}

RemovalMask& RemovalEditor::editable_mask(Brick& brick, int n) {
  RemovalMask* mask = brick.mask.get();
  if (mask->n < n)
    brick.mask = Ref<RemovalMask>(mask->refined());
  else if (mask->stroke != stroke_)
    brick.mask = Ref<RemovalMask>(mask->copy());
  brick.mask->stroke = next_->stroke_ = stroke_;
  return *brick.mask;
}

namespace {

constexpr int k_cells = k_brick + 2;  // cells along a brick's edge, with one neighbour at each end

/// One bit for each of the 10^3 samples of a brick and around it: set if the trilinear field of the base is
/// solid at the sample. Stored in rows of ten bits.
class SolidSamples {
 public:
  SolidSamples(const Field& field, const CutLattice& lattice, const glm::ivec3& first) {
    // Reads the voxels at the corners of all trilinear cells that contain samples, then interpolates axis by
    // axis. Rows of samples are parallel to rows of voxels, so that each coordinate has its own weights.
    std::array<std::array<int, k_cells>, 3> cell;
    std::array<std::array<double, k_cells>, 3> share;
    glm::ivec3 low, count;
    for (int a = 0; a < 3; ++a) {
      const auto axis = static_cast<std::size_t>(a);
      const int k = lattice.per_voxel()[a], centre = lattice.centre_of(glm::ivec3(0))[a];
      for (int i = 0; i < k_cells; ++i) {
        const int steps = first[a] + i - centre;
        const int c = steps >= 0 ? steps / k : -((-steps + k - 1) / k);
        cell[axis][static_cast<std::size_t>(i)] = c;
        share[axis][static_cast<std::size_t>(i)] = static_cast<double>(steps - c * k) / k;
      }
      low[a] = cell[axis][0];
      count[a] = cell[axis][k_cells - 1] + 2 - low[a];
    }
    const auto lerp = [](double a, double b, double t) { return t == 0 ? a : a + t * (b - a); };
    std::array<double, 12> row;
    std::array<std::array<double, k_cells>, 12> slice;
    std::array<std::array<std::array<double, k_cells>, k_cells>, 12> box;
    for (int z = 0; z < count.z; ++z) {
      for (int y = 0; y < count.y; ++y) {
        for (int x = 0; x < count.x; ++x)
          row[static_cast<std::size_t>(x)] = field.at(low.x + x, low.y + y, low.z + z);
        for (std::size_t i = 0; i < k_cells; ++i) {
          const auto c = static_cast<std::size_t>(cell[0][i] - low.x);
          slice[static_cast<std::size_t>(y)][i] = lerp(row[c], row[c + 1], share[0][i]);
        }
      }
      for (std::size_t j = 0; j < k_cells; ++j)
        for (std::size_t i = 0; i < k_cells; ++i) {
          const auto c = static_cast<std::size_t>(cell[1][j] - low.y);
          box[static_cast<std::size_t>(z)][j][i] = lerp(slice[c][i], slice[c + 1][i], share[1][j]);
        }
    }
    for (std::size_t k = 0; k < k_cells; ++k)
      for (std::size_t j = 0; j < k_cells; ++j) {
        const auto c = static_cast<std::size_t>(cell[2][k] - low.z);
        unsigned bits = 0;
        for (std::size_t i = 0; i < k_cells; ++i)
          bits |= static_cast<unsigned>(lerp(box[c][j][i], box[c + 1][j][i], share[2][k]) >= 0) << i;
        rows_[k][j] = bits;
      }
  }
  unsigned row(std::size_t y, std::size_t z) const { return rows_[z][y]; }

 private:
  std::array<std::array<unsigned, k_cells>, k_cells> rows_;
};

}  // namespace

void RemovalEditor::classify(RemovalMask& mask, const glm::ivec3& low) const {
  // A cell is inside the cube of the 27 samples around it, and trilinear values are between those of the
  // samples. So a cell is completely solid (air) if its 27 samples are solid (air). Rows of ten bits are
  // combined by AND (OR): first three neighbours along x, then nine rows.
  for (const Field& field : solids_) {
    const SolidSamples samples(field, next_->lattice_, low - 1);
    std::array<std::array<unsigned, k_cells>, k_cells> all_solid, any_solid;
    for (std::size_t z = 0; z < k_cells; ++z)
      for (std::size_t y = 0; y < k_cells; ++y) {
        const unsigned row = samples.row(y, z);
        all_solid[z][y] = row & row >> 1 & row >> 2;
        any_solid[z][y] = row | row >> 1 | row >> 2;
      }
    for (std::size_t z = 0; z < k_brick; ++z)
      for (std::size_t y = 0; y < k_brick; ++y) {
        unsigned solid = 0xff, touched = 0;
        for (std::size_t n = 0; n < 9; ++n) {
          solid &= all_solid[z + n / 3][y + n % 3];
          touched |= any_solid[z + n / 3][y + n % 3];
        }
        mask.base_solid[z] |= static_cast<std::uint64_t>(solid & 0xff) << (8 * y);
        mask.base_air[z] |= static_cast<std::uint64_t>(touched & 0xff)
                            << (8 * y);  // bits of cells that are not air; inverted below
      }
  }
  for (std::uint64_t& slice : mask.base_air) slice = ~slice;
}

std::int64_t RemovalEditor::count_solid(const RemovalMask& mask, const glm::ivec3& sample,
                                        std::size_t in_brick, const std::uint64_t* fresh) const {
  const std::uint64_t bit = std::uint64_t{1} << (in_brick % 64);
  const std::size_t slice = in_brick / 64;
  if (mask.base_air[slice] & bit) return 0;
  const int words = mask.words_per_cell(), n = mask.n;
  std::int64_t count = 0;
  if (mask.base_solid[slice] & bit) {
    for (int w = 0; w < words; ++w) count += std::popcount(fresh[w]);
  } else {
    const glm::dvec3 shift(point_shift(sample));
    for (int w = 0; w < words; ++w)
      for (std::uint64_t remaining = fresh[w]; remaining != 0; remaining &= remaining - 1) {
        const int s = 64 * w + std::countr_zero(remaining);
        const glm::dvec3 offset(s % n, s / n % n, s / (n * n));
        const glm::dvec3 p = next_->lattice_.volume_from_lattice(
            glm::dvec3(sample) + (offset + 0.5 + shift) / static_cast<double>(n) - 0.5);
        for (const Field& field : solids_)
          if (field.value(p) >= 0) {
            ++count;
            break;
          }
      }
  }
  return count * (RemovalLedger::k_units_per_cell / (n * n * n));
}

RemovalReport RemovalEditor::remove(const Sweep& sweep) {
  const SweptShape shape(sweep, *next_);
  const glm::dvec3 ends[] = {sweep.start_world, sweep.end_world};
  return remove(shape, ends, sweep.radius_mm + next_->band_mm_ + static_cast<double>(shape.allowance));
}

RemovalReport RemovalEditor::remove(const ToolSweep& sweep) {
  const ToolBody& body = sweep.body;
  if (body.is_ball())
    return remove(Sweep{sweep.start.at_world, sweep.end.at_world, body.radius, sweep.continues});
  // No point of the body moves more than a quarter of a step between poses; an arc is at most pi/2 times as
  // long as its chord.
  const glm::dvec3& h = next_->lattice_.frame().spacing();
  const double step = 0.25 * std::min({h.x, h.y, h.z});
  const double lever = std::max(std::abs(body.low()), std::abs(body.high())) + body.radius;
  const double path_mm = glm::length(sweep.end.at_world - sweep.start.at_world) +
                         1.58 * lever * glm::length(sweep.end.axis_world - sweep.start.axis_world);
  constexpr double k_max_poses = 1e6;  // far beyond any motion of a hand
  const int count = static_cast<int>(std::ceil(std::min(path_mm / step, k_max_poses)));
  RemovalReport total;
  for (int first = sweep.continues && count > 0 ? 1 : 0; first <= count; first += SweptShape::k_max_stamps) {
    const int last = std::min(first + SweptShape::k_max_stamps - 1, count);
    const SweptShape shape(sweep, first, last, std::max(1, count), *next_);
    // The body is inside the hull of balls of its largest radius at both ends of its axis.
    std::array<glm::dvec3, 2 * SweptShape::k_max_stamps> ends;
    std::size_t end_count = 0;
    for (int i = first; i <= last; ++i) {
      const ToolPose pose = between(sweep.start, sweep.end, static_cast<double>(i) / std::max(1, count));
      for (const double along : {body.low(), body.high()})
        ends[end_count++] = pose.at_world + along * pose.axis_world;
    }
    add(total, remove(shape, std::span(ends.data(), end_count),
                      std::max(body.radius, body.end_radius) + next_->band_mm_ +
                          static_cast<double>(shape.allowance)));
  }
  return total;
}

RemovalReport RemovalEditor::remove(const SweptShape& shape, std::span<const glm::dvec3> ends_world,
                                    double reach) {
  RemovalReport report;
  const CutLattice& lattice = next_->lattice_;

  // Box of the samples within reach of the ends. A ball of radius 1 mm extends |row of the inverse| steps
  // along an axis.
  glm::dvec3 a(1e300), b(-1e300);
  for (const glm::dvec3& end : ends_world) {
    const glm::dvec3 p = lattice.frame().volume_from_world(end);
    a = glm::min(a, p);
    b = glm::max(b, p);
  }
  const glm::dmat3 inverse = glm::inverse(lattice.frame().axes());
  glm::ivec3 low(0), high(0);
  for (int i = 0; i < 3; ++i) {
    const double extent = reach * glm::length(glm::row(inverse, i));
    const double limit = lattice.size()[i] - 1;
    low[i] = static_cast<int>(std::clamp(std::ceil(a[i] - extent), 0.0, limit + 1));
    high[i] = static_cast<int>(std::clamp(std::floor(b[i] + extent), -1.0, limit));
    if (low[i] > high[i]) return report;
  }
  // Box of the voxels that contain these samples.
  const glm::ivec3 last = next_->base().size - 1;
  report.box = {glm::clamp(lattice.voxel_of(low), glm::ivec3(0), last),
                glm::clamp(lattice.voxel_of(high), glm::ivec3(0), last)};

  const glm::ivec3 first_brick = low / k_brick, last_brick = high / k_brick;
  for (int z = first_brick.z; z <= last_brick.z; ++z)
    for (int y = first_brick.y; y <= last_brick.y; ++y)
      for (int x = first_brick.x; x <= last_brick.x; ++x) {
        const glm::ivec3 corner = k_brick * glm::ivec3(x, y, z);
        const glm::dvec3 middle = lattice.frame().world_from_volume(glm::dvec3(corner) + 0.5 * (k_brick - 1));
        if (!shape.misses_brick(glm::vec3(middle - shape.start_world)))
          remove_in_brick(shape, corner, report);
      }
  return report;
}

bool RemovalEditor::is_solid_in_scan(const glm::dvec3& p_world) const noexcept {
  const glm::dvec3 p = next_->base().frame.volume_from_world(p_world);
  return std::any_of(solids_.begin(), solids_.end(), [&](const Field& field) { return field.value(p) >= 0; });
}

void RemovalEditor::remove_in_brick(const SweptShape& shape, const glm::ivec3& low, RemovalReport& report) {
  const Brick* old = next_->brick_at(low);
  if (old && old->is_hollow) return;
  const glm::vec3 corner(next_->lattice_.frame().world_from_volume(glm::dvec3(low)) - shape.start_world);
  const glm::vec3 middle = corner + shape.lattice_step(3.5f, 3.5f, 3.5f);
  BrickSweep sweep;
  shape.sweep_brick(*kernels_, corner, middle, old ? old->distance.data() : nullptr, sweep);
  if (!sweep.is_in_band) return;

  Brick* brick = sweep.is_nearer ? &swept_brick(low, sweep) : nullptr;
  mark_cells(shape, sweep, corner, low, old, brick, report);
  if (brick == nullptr) return;
  ++report.bricks_changed;
  // If all samples are deeper than the band, every cell is completely inside one of the sweeps, and all its
  // points are marked. The shared hollow brick then replaces this brick.
  if (sweep.is_hollow) editable_slot(low) = next_->hollow_;
}

namespace {

/// Shifts of the points of a brick's cells: point_shift() of its 512 samples. Reads the indices from a table,
/// because a tick needs many of them.
class BrickShifts {
 public:
  explicit BrickShifts(const glm::ivec3& low) : turn_(point_shift_index(low)) {}
  /// Shifted position of the cell with index `in_brick` and coordinates `cell` in the brick, in steps of the
  /// lattice. `share`: spacing of the points in steps.
  glm::vec3 position(std::size_t in_brick, const glm::ivec3& cell, float share) const {
    const glm::ivec3 turn((k_turns[in_brick] + turn_) & (k_point_shift_count - 1u));
    return glm::vec3(cell) + share * glm::vec3(point_shift(turn.x), point_shift(turn.y), point_shift(turn.z));
  }

 private:
  static constexpr std::array<glm::uvec3, k_brick* k_brick* k_brick> k_turns = [] {
    std::array<glm::uvec3, k_brick * k_brick * k_brick> turns{};
    for (int z = 0; z < k_brick; ++z)
      for (int y = 0; y < k_brick; ++y)
        for (int x = 0; x < k_brick; ++x) turns[Brick::index(x, y, z)] = point_shift_index({x, y, z});
    return turns;
  }();
  glm::uvec3 turn_;
};

}  // namespace

/// Updates a brick's mask: marks all points of the cells that are completely inside the shape, and tests the
/// points of the cells on its surface. Skips the cells behind the start of a continued sweep, which the
/// previous sweep has marked.
void RemovalEditor::mark_cells(const SweptShape& shape, const BrickSweep& sweep, const glm::vec3& corner,
                               const glm::ivec3& low, const Brick* old, Brick*& brick,
                               RemovalReport& report) {
  const RemovalMask* current = brick ? brick->mask.get() : old ? old->mask.get() : nullptr;
  std::array<std::uint64_t, k_brick> cells;
  std::uint64_t any = 0;
  for (std::size_t z = 0; z < k_brick; ++z) {
    cells[z] =
        sweep.touched[z] & (shape.continues ? sweep.ahead[z] : k_all) & ~(current ? current->full[z] : 0);
    any |= cells[z];
  }
  if (any == 0) return;
  if (brick == nullptr) brick = &swept_brick(low, sweep);
  if (!brick->mask) {
    brick->mask = Ref<RemovalMask>(new RemovalMask(shape.n));
    classify(*brick->mask, low);
    brick->mask->stroke = stroke_;
  }
  RemovalMask& mask = editable_mask(*brick, shape.n);
  if (mask.n == 4)
    mark_cells_of<1>(shape, sweep, corner, low, cells, mask, report);
  else
    mark_cells_of<8>(shape, sweep, corner, low, cells, mask, report);
}

template <std::size_t Words>
void RemovalEditor::mark_cells_of(const SweptShape& shape, const BrickSweep& sweep, const glm::vec3& corner,
                                  const glm::ivec3& low, const std::array<std::uint64_t, k_brick>& cells,
                                  RemovalMask& mask, RemovalReport& report) {
  const float shift_share = 1 / static_cast<float>(shape.n);
  const BrickShifts shifts(low);
  const CellPoints& cell_points = (*points_)[shape.n == 8];
  const bool is_as_fine = mask.n == shape.n;
  const CutLattice& lattice = next_->lattice_;
  const Volume& base = next_->base();
  // Most bricks are completely inside the volume.
  const bool is_within =
      base.contains(lattice.voxel_of(low)) && base.contains(lattice.voxel_of(low + k_brick - 1));

  for (std::size_t z = 0; z < k_brick; ++z)
    for (std::uint64_t remaining = cells[z]; remaining != 0; remaining &= remaining - 1) {
      const int bit = std::countr_zero(remaining);
      const auto in_brick = 64 * z + static_cast<std::size_t>(bit);
      const glm::ivec3 cell(bit % k_brick, bit / k_brick, static_cast<int>(z));
      // A shape is always sampled at its own resolution, even in a finer mask, so that the order of cuts
      // makes no difference.
      std::array<std::uint64_t, Words> points;
      if (sweep.inside[z] >> bit & 1) {
        points.fill(k_all);
      } else {
        const glm::vec3 at = shifts.position(in_brick, cell, shift_share),
                        c = corner + shape.lattice_step(at.x, at.y, at.z);
        const bool is_past_end = (sweep.past_end[z] >> bit & 1) != 0;
        std::uint64_t coarse = 0;
        shape.sample(*kernels_, cell_points, c, is_past_end, is_as_fine ? points.data() : &coarse);
        if constexpr (Words == 8) {
          if (!is_as_fine) refine_points(coarse, points.data());
        }
      }
      if (!mark(mask, in_brick, points)) continue;
      if (is_within || base.contains(lattice.voxel_of(low + cell)))
        count(mask, low + cell, in_brick, points.data(), Ledger::removed, report);
    }
}

void RemovalEditor::count(const RemovalMask& mask, const glm::ivec3& sample, std::size_t in_brick,
                          const std::uint64_t* fresh, Ledger ledger, RemovalReport& report) {
  const std::int64_t units = count_solid(mask, sample, in_brick, fresh);
  if (units == 0) return;
  report.removed_units += units;
  if (ledger == Ledger::freed) return;
  const Volume& base = next_->base();
  const glm::ivec3 voxel = next_->lattice_.voxel_of(sample);
  const std::size_t at = base.index(voxel.x, voxel.y, voxel.z);
  const std::size_t label = base.labels.is_empty() ? 0 : base.labels[at];
  const double intensity = std::max<double>(base.voxels[at], 0);
  report.intensity_sum += static_cast<double>(units) * intensity;
  report.intensity_square_sum += static_cast<double>(units) * intensity * intensity;
  std::vector<std::int64_t>& by_label = next_->ledger_.units_by_label;
  by_label[std::min(label, by_label.size() - 1)] += units;
}

template <std::size_t Words>
bool RemovalEditor::mark(RemovalMask& mask, std::size_t in_brick, std::array<std::uint64_t, Words>& points) {
  std::uint64_t* at = mask.words.data() + in_brick * Words;
  std::uint64_t any = 0, all = k_all;
  for (std::size_t w = 0; w < Words; ++w) {
    points[w] &= ~at[w];
    any |= points[w];
  }
  if (any == 0) return false;
  for (std::size_t w = 0; w < Words; ++w) all &= at[w] |= points[w];
  if (all == k_all) mask.full[in_brick / 64] |= std::uint64_t{1} << (in_brick % 64);
  return true;
}
template bool RemovalEditor::mark<1>(RemovalMask&, std::size_t, std::array<std::uint64_t, 1>&);
template bool RemovalEditor::mark<8>(RemovalMask&, std::size_t, std::array<std::uint64_t, 8>&);

}  // namespace trephine::volume
