#include "volume/cuts/shape_choice.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <vector>

#include "volume/base/parallel.h"
#include "volume/cuts/solid_parts.h"

namespace trephine::volume {

namespace {

ShapeParts summary_of(const SolidParts& parts, int& largest) {
  ShapeParts summary;
  summary.count = static_cast<int>(parts.parts().size());
  for (int p = 0; p < summary.count; ++p) {
    const std::int64_t samples = parts.parts()[static_cast<std::size_t>(p)].samples;
    if (samples > summary.largest) {
      summary.others += summary.largest;
      summary.second = summary.largest;
      summary.largest = samples;
      largest = p;
    } else {
      summary.others += samples;
      summary.second = std::max(summary.second, samples);
    }
  }
  return summary;
}

SolidParts find_parts(const std::shared_ptr<const Volume>& volume, const Shape& shape) {
  return {Field(*volume, shape), Occupancy::build(*volume, shape), Version(volume)};
}

}  // namespace

int otsu_threshold(const Volume& volume) {
  std::vector<std::int64_t> count(65536, 0);
  for (const std::int16_t v : volume.voxels.span()) ++count[static_cast<std::size_t>(v + 32768)];
  double total = 0, sum = 0;
  for (std::size_t i = 0; i < count.size(); ++i) {
    total += static_cast<double>(count[i]);
    sum += static_cast<double>(count[i]) * static_cast<double>(i);
  }
  double below = 0, sum_below = 0, best = -1;
  std::size_t threshold = 0, empty_from = 0;
  for (std::size_t i = 0; i + 1 < count.size(); ++i) {
    below += static_cast<double>(count[i]);
    sum_below += static_cast<double>(count[i]) * static_cast<double>(i);
    if (below == 0 || below == total) continue;
    const double difference = sum_below / below - (sum - sum_below) / (total - below);
    const double between = below * (total - below) * difference * difference;
    // All thresholds between two adjacent values of the histogram are equally good. Chooses the middle.
    if (between > best)
      best = between, threshold = i + 1, empty_from = i + 1;
    else if (between == best && count[i] == 0)
      threshold = (empty_from + i + 1) / 2;
  }
  return static_cast<int>(threshold) - 32768;
}

ShapeParts parts_of(const std::shared_ptr<const Volume>& volume, const Shape& shape) {
  int largest = 0;
  return summary_of(find_parts(volume, shape), largest);
}

namespace {

/// Calls use(part, voxel index) for each voxel that belongs to a part.
template <class Use>
void for_each_voxel(const Volume& volume, const SolidParts& parts, const Use& use) {
  const CutLattice lattice(volume);
  std::vector<int> row(static_cast<std::size_t>(volume.size.x));
  for (int z = 0; z < volume.size.z; ++z)
    for (int y = 0; y < volume.size.y; ++y) {
      const glm::ivec3 sample = lattice.centre_of({0, y, z});  // one sample per voxel
      parts.row(sample.x, sample.y, sample.z, volume.size.x, row.data());
      const std::size_t first = volume.index(0, y, z);
      for (std::size_t x = 0; x < row.size(); ++x)
        if (row[x] != SolidParts::k_air) use(row[x], first + x);
    }
}

/// Calls use(voxel) for each voxel of one part, until it returns false.
template <class Use>
void for_voxels_of(const Volume& volume, const SolidParts& parts, int part, const Use& use) {
  const CutLattice lattice(volume);
  const auto& [low, high] = parts.parts()[static_cast<std::size_t>(part)].box;
  std::vector<int> row(static_cast<std::size_t>(high.x - low.x + 1));
  for (int z = low.z; z <= high.z; ++z)
    for (int y = low.y; y <= high.y; ++y) {
      const glm::ivec3 sample = lattice.centre_of({low.x, y, z});  // one sample per voxel
      parts.row(sample.x, sample.y, sample.z, static_cast<int>(row.size()), row.data());
      for (std::size_t x = 0; x < row.size(); ++x)
        if (row[x] == part && !use(glm::ivec3(low.x + static_cast<int>(x), y, z))) return;
    }
}

Error empty_shape_error(const Shape& shape, const Volume& volume) {
  return Error{.what = "no voxel has this shape",
               .found = "no voxel of " + describe(shape, volume.is_hounsfield),
               .expected = "at least one voxel",
               .remedy = "choose another shape"};
}

/// Returns a copy with writable shape voxels: those of `volume` if it has any, else a copy of its scan.
Result<Volume> with_shape_voxels(const Volume& volume) {
  Result<Volume> result = copy_of(volume);
  if (!result || !volume.shape_voxels.is_empty()) return result;
  const Buffer<std::int16_t>& scan = volume.voxels;
  result.value().shape_voxels = Buffer<std::int16_t>(scan.size());
  std::copy_n(scan.data(), scan.size(), result.value().shape_voxels.data());
  return result;
}

/// Returns a copy with only the kept parts.
Result<Volume> with_parts(const Volume& volume, const Shape& shape, const SolidParts& parts,
                          const std::vector<bool>& is_kept) {
  Result<Volume> result = shape.is_label() ? copy_of(volume) : with_shape_voxels(volume);
  if (!result) return result;
  Volume& copy = result.value();
  const std::int16_t lowest = *std::min_element(volume.voxels.span().begin(), volume.voxels.span().end());
  const std::int16_t air = volume.is_hounsfield ? std::max<std::int16_t>(lowest, -1000) : lowest;
  for (std::size_t part = 0; part < is_kept.size(); ++part) {
    if (is_kept[part]) continue;
    for_voxels_of(volume, parts, static_cast<int>(part), [&](const glm::ivec3& v) {
      const std::size_t voxel = volume.index(v.x, v.y, v.z);
      if (shape.is_label())
        copy.labels[voxel] = 0;
      else
        copy.shape_voxels[voxel] = air;
      return true;
    });
  }
  return result;
}

/// One bit per voxel, rows in words; bits beyond a row's end are always 0.
class BitGrid {
 public:
  explicit BitGrid(const glm::ivec3& size)
      : size_(size),
        words_((static_cast<std::size_t>(size.x) + 63) / 64),
        bits_(words_ * static_cast<std::size_t>(size.y) * static_cast<std::size_t>(size.z), 0) {}
  std::uint64_t* row(int y, int z) { return bits_.data() + at(y, z); }
  const std::uint64_t* row(int y, int z) const { return bits_.data() + at(y, z); }
  std::size_t words() const { return words_; }
  const glm::ivec3& size() const { return size_; }
  bool has(int x, int y, int z) const { return (row(y, z)[x / 64] >> (x % 64) & 1) != 0; }
  void invert() {
    const std::uint64_t last = size_.x % 64 == 0 ? ~0ull : (1ull << (size_.x % 64)) - 1;
    for (std::size_t i = 0; i < bits_.size(); ++i)
      bits_[i] = ~bits_[i] & (i % words_ + 1 == words_ ? last : ~0ull);
  }

 private:
  std::size_t at(int y, int z) const {
    return words_ *
           (static_cast<std::size_t>(y) + static_cast<std::size_t>(size_.y) * static_cast<std::size_t>(z));
  }
  glm::ivec3 size_;
  std::size_t words_;
  std::vector<std::uint64_t> bits_;
};

/// Computes to |= from, with `from` shifted by `by` bits along x.
void or_shifted(const std::uint64_t* from, int by, std::size_t words, std::uint64_t* to) {
  const int whole = by >= 0 ? by / 64 : -((-by + 63) / 64), bits = by - 64 * whole;  // bits: 0 to 63
  for (std::size_t w = 0; w < words; ++w) {
    const std::ptrdiff_t source = static_cast<std::ptrdiff_t>(w) - whole;
    const auto word = [&](std::ptrdiff_t i) {
      return i >= 0 && i < static_cast<std::ptrdiff_t>(words) ? from[i] : 0;
    };
    to[w] |= word(source) << bits | (bits > 0 ? word(source - 1) >> (64 - bits) : 0);
  }
}

/// Row of a ball: voxel offsets low .. high along x, at offsets y and z from the centre.
struct BallRow {
  int y, z, low, high;
};
std::vector<BallRow> ball_rows(const Frame& frame, double radius_mm) {
  // Tests all offsets within the extent of the ball along each axis of a grid that may be sheared.
  std::vector<BallRow> rows;
  glm::ivec3 reach(0);
  for (int a = 0; a < 3; ++a) {
    glm::dvec3 e(0);
    e[a] = 1;
    reach[a] = static_cast<int>(radius_mm * glm::length(frame.gradient_world_from_volume(e))) + 1;
  }
  for (int z = -reach.z; z <= reach.z; ++z)
    for (int y = -reach.y; y <= reach.y; ++y) {
      int low = 1, high = 0;
      for (int x = -reach.x; x <= reach.x; ++x)
        if (glm::length(frame.vector_world_from_volume(glm::dvec3(x, y, z))) <= radius_mm) {
          if (low > high) low = x;
          high = x;
        }
      if (low <= high) rows.push_back({y, z, low, high});
    }
  return rows;
}

/// Number of lines through a voxel and two opposite ones of its 26 neighbours.
constexpr int k_lines = 13;
glm::ivec3 line_step(int n) { return {n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1}; }

/// Returns true if one of 13 lines through the voxel meets solid on both sides within reach. Returns false
/// for voxels on an outer surface, even where the voxels of the surface form a staircase.
bool is_between_solids(const BitGrid& solid, const Frame& frame, const glm::ivec3& voxel, double reach_mm) {
  const glm::ivec3& size = solid.size();
  const auto meets_solid = [&](const glm::ivec3& step) {
    const double length = glm::length(frame.vector_world_from_volume(glm::dvec3(step)));
    glm::ivec3 p = voxel;
    for (double distance = length; distance <= reach_mm; distance += length) {
      p += step;
      if (p.x < 0 || p.y < 0 || p.z < 0 || p.x >= size.x || p.y >= size.y || p.z >= size.z) return false;
      if (solid.has(p.x, p.y, p.z)) return true;
    }
    return false;
  };
  for (int n = 0; n < k_lines; ++n) {
    const glm::ivec3 step = line_step(n);
    if (meets_solid(step) && meets_solid(-step)) return true;
  }
  return false;
}

/// Returns true if a voxel is in a wall brighter than both its sides: along at least 3 of 13 lines the
/// intensity drops by `drop` on both sides within reach, before the line meets solid. Returns false in a gap
/// between walls and in uniform matter between two bones.
bool is_in_bright_wall(const BitGrid& solid, const Volume& v, const glm::ivec3& voxel, double drop,
                       double reach_mm) {
  const double below = v.window_voxels()[v.index(voxel.x, voxel.y, voxel.z)] - drop;
  const auto drops = [&](const glm::ivec3& step) {
    const double length = glm::length(v.frame.vector_world_from_volume(glm::dvec3(step)));
    glm::ivec3 p = voxel;
    for (double distance = length; distance <= reach_mm; distance += length) {
      p += step;
      if (!v.contains(p) || solid.has(p.x, p.y, p.z)) return false;
      if (v.window_voxels()[v.index(p.x, p.y, p.z)] <= below) return true;
    }
    return false;
  };
  int lines = 0;
  for (int n = 0; n < k_lines; ++n) {
    const glm::ivec3 step = line_step(n);
    lines += drops(step) && drops(-step);
  }
  return lines >= 3;
}

BitGrid dilated(const BitGrid& from, const std::vector<BallRow>& ball) {
  BitGrid to(from.size());
  const glm::ivec3& size = from.size();
  const std::uint64_t last = size.x % 64 == 0 ? ~0ull : (1ull << (size.x % 64)) - 1;
  parallel_for(size.z, 0, [&](int z) {
    for (int y = 0; y < size.y; ++y) {
      std::uint64_t* out = to.row(y, z);
      for (const BallRow& row : ball) {
        if (y - row.y < 0 || y - row.y >= size.y || z - row.z < 0 || z - row.z >= size.z) continue;
        const std::uint64_t* in = from.row(y - row.y, z - row.z);
        for (int x = row.low; x <= row.high; ++x) or_shifted(in, x, from.words(), out);
      }
      out[from.words() - 1] &= last;
    }
  });
  return to;
}

}  // namespace

Result<Volume> keep_largest_part(const std::shared_ptr<const Volume>& volume, const Shape& shape,
                                 ShapeParts& summary) {
  const SolidParts parts = find_parts(volume, shape);
  int largest = 0;
  summary = summary_of(parts, largest);
  if (summary.count == 0) return empty_shape_error(shape, *volume);
  std::vector<bool> is_kept(parts.parts().size(), false);
  is_kept[static_cast<std::size_t>(largest)] = true;
  return with_parts(*volume, shape, parts, is_kept);
}

namespace {

constexpr double k_tissue = -300;  // HU; the cushions of tables and holders have lower values

/// Returns true if a part of bone lies in air next to the body: 3 mm from its voxels there is mostly air, and
/// from most voxels a row or a column of the slice leads through air out of the scan. Examples are a head
/// holder that touches an ear, and a table under the skin.
bool is_in_open_air(const Volume& v, const SolidParts& parts, int part, double low) {
  constexpr double k_near = 3, k_skipped = 5;  // mm
  constexpr std::int64_t k_tested = 500;       // voxels of the part
  const glm::dvec3 spacing = v.frame.spacing();
  const auto value = [&](const glm::ivec3& p) { return v.window_voxels()[v.index(p.x, p.y, p.z)]; };
  const std::int64_t every =
      std::max<std::int64_t>(1, parts.parts()[static_cast<std::size_t>(part)].samples / k_tested);
  std::int64_t count = 0, tested = 0, open = 0, air = 0, tissue = 0;
  for_voxels_of(v, parts, part, [&](const glm::ivec3& voxel) {
    if (count++ % every != 0) return true;
    ++tested;
    bool is_open = false;
    for (int axis = 0; axis < 3; ++axis)
      for (const int side : {-1, 1}) {
        glm::ivec3 step(0);
        step[axis] = side;
        const glm::ivec3 near = voxel + static_cast<int>(std::lround(k_near / spacing[axis])) * step;
        if (v.contains(near) && value(near) < low) ++(value(near) < k_tissue ? air : tissue);
        if (axis == 2) continue;
        glm::ivec3 p = voxel + static_cast<int>(std::lround(k_skipped / spacing[axis])) * step;
        while (v.contains(p) && value(p) < k_tissue) p += step;
        is_open = is_open || !v.contains(p);
      }
    open += is_open;
    return true;
  });
  return 10 * open >= 9 * tested && air >= 2 * tissue;
}

}  // namespace

Result<std::shared_ptr<const Volume>> omit_parts_outside_body(const std::shared_ptr<const Volume>& volume,
                                                              const Shape& shape, ShapeParts& removed,
                                                              PartSize size) {
  removed = {};
  if (!volume->is_hounsfield || shape.is_label() || shape.low < k_tissue) return volume;
  const SolidParts parts = find_parts(volume, shape);
  int largest = 0;
  const ShapeParts all = summary_of(parts, largest);
  // A long part, such as the thin edge of a table, is visible even if it has few voxels.
  constexpr double k_long = 50, k_short = 20;  // mm
  const auto length_of = [&](const SolidParts::Part& part) {
    const glm::dvec3 sides = glm::dvec3(part.box.high - part.box.low + 1) * volume->frame.spacing();
    return std::max({sides.x, sides.y, sides.z});
  };
  const auto is_large = [&](const SolidParts::Part& part) {
    return size == PartSize::any || 200 * part.samples >= all.largest || length_of(part) >= k_long;
  };
  int large_parts = 0;
  for (const SolidParts::Part& part : parts.parts()) large_parts += is_large(part);
  if (all.count < 2 || large_parts < 2) return volume;  // the largest part counts as one large part
  // Every part of the shape is inside exactly one part of the tissue.
  Shape tissue = shape;
  tissue.low = k_tissue, tissue.high = std::numeric_limits<double>::infinity();
  const SolidParts bodies = find_parts(volume, tissue);
  const CutLattice lattice(*volume);
  const auto body_of = [&](int part) {
    int body = SolidParts::k_air;
    for_voxels_of(*volume, parts, part, [&](const glm::ivec3& v) {
      body = bodies.part_of(lattice.centre_of(v));
      return false;
    });
    return body;
  };
  const int body = body_of(largest);
  // If the tissue has less than twice the voxels of the bone, the scan shows a specimen, not a patient's
  // body.
  if (size == PartSize::large && bodies.parts()[static_cast<std::size_t>(body)].samples < 2 * all.largest)
    return volume;
  std::vector<bool> is_kept(parts.parts().size(), true);
  ShapeParts outside;
  outside.largest = all.largest;
  bool has_large = false;
  for (std::size_t p = 0; p < is_kept.size(); ++p) {
    is_kept[p] = body_of(static_cast<int>(p)) == body;
    if (is_kept[p]) continue;
    has_large = has_large || is_large(parts.parts()[p]);
    outside.others += parts.parts()[p].samples, ++outside.count;
    outside.second = std::max(outside.second, parts.parts()[p].samples);
  }
  if (!has_large) return volume;
  // Tissue may connect a further part of the same table or holder to the body, such as an ear that touches
  // it.
  for (std::size_t p = 0; p < is_kept.size(); ++p) {
    const SolidParts::Part& part = parts.parts()[p];
    if (!is_kept[p] || static_cast<int>(p) == largest || length_of(part) < k_short ||
        !is_in_open_air(*volume, parts, static_cast<int>(p), shape.low))
      continue;
    is_kept[p] = false;
    outside.others += part.samples, ++outside.count;
    outside.second = std::max(outside.second, part.samples);
  }
  Result<Volume> copy = with_parts(*volume, shape, parts, is_kept);
  if (!copy) return copy.error();
  removed = outside;
  return std::shared_ptr<const Volume>(std::make_shared<const Volume>(std::move(copy).value()));
}

Result<Volume> keep_seeded_parts(const std::shared_ptr<const Volume>& volume, const Shape& shape, double seed,
                                 double min_share, ShapeParts& removed) {
  const SolidParts parts = find_parts(volume, shape);
  std::vector<bool> is_kept(parts.parts().size(), false);
  for_each_voxel(*volume, parts, [&](int part, std::size_t voxel) {
    if (volume->window_voxels()[voxel] >= seed) is_kept[static_cast<std::size_t>(part)] = true;
  });
  removed = {};
  for (std::size_t p = 0; p < is_kept.size(); ++p)
    if (is_kept[p]) removed.largest = std::max(removed.largest, parts.parts()[p].samples);
  for (std::size_t p = 0; p < is_kept.size(); ++p) {
    const std::int64_t samples = parts.parts()[p].samples;
    is_kept[p] =
        is_kept[p] && static_cast<double>(samples) >= min_share * static_cast<double>(removed.largest);
    if (!is_kept[p])
      removed.others += samples, removed.second = std::max(removed.second, samples), ++removed.count;
  }
  if (removed.largest == 0) {
    Shape seeds = shape;
    seeds.low = seed;
    return empty_shape_error(seeds, *volume);
  }
  return with_parts(*volume, shape, parts, is_kept);
}

Result<Volume> fill_thin_walls(const Volume& volume, const Shape& shape, double low, double high,
                               double reach_mm, std::int64_t& filled) {
  filled = 0;
  Result<Volume> result = with_shape_voxels(volume);
  if (!result) return result;
  const glm::ivec3& size = volume.size;
  BitGrid solid(size);
  for (int z = 0; z < size.z; ++z)
    for (int y = 0; y < size.y; ++y)
      for (int x = 0; x < size.x; ++x)
        if (shape.is_solid(volume.window_voxels()[volume.index(x, y, z)]))
          solid.row(y, z)[x / 64] |= 1ull << (x % 64);
  const glm::dvec3& spacing = volume.frame.spacing();
  const double half_voxel = 0.5 * std::min({spacing.x, spacing.y, spacing.z});
  // Closing: dilates the solid by a ball, then dilates the remaining outside by a ball. Nothing beyond the
  // border of the grid counts as outside.
  BitGrid closed = dilated(solid, ball_rows(volume.frame, reach_mm));
  closed.invert();
  closed = dilated(closed, ball_rows(volume.frame, std::max(0.0, reach_mm - half_voxel)));
  closed.invert();
  const auto raised = static_cast<std::int16_t>(high);
  for (int z = 0; z < size.z; ++z)
    for (int y = 0; y < size.y; ++y)
      for (int x = 0; x < size.x; ++x) {
        std::int16_t& v = result.value().shape_voxels[volume.index(x, y, z)];
        if (v < low || !closed.has(x, y, z) || solid.has(x, y, z) ||
            !is_between_solids(solid, volume.frame, {x, y, z}, reach_mm) ||
            !is_in_bright_wall(solid, volume, {x, y, z}, 0.5 * (shape.low - low), reach_mm))
          continue;
        v = raised;
        ++filled;
      }
  return result;
}

}  // namespace trephine::volume
