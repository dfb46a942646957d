#include "modules/bone_flap/kerf.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_access.hpp>
#include <glm/matrix.hpp>
#include <glm/vector_relational.hpp>

namespace trephine::bone_flap {

using glm::dvec2;
using glm::dvec3;
using volume::Field;

namespace {

constexpr double k_inward = 60;         // mm, search depth along lines below the chord between anchors
constexpr double k_jump = 3;            // mm, largest step of a table from line to line
constexpr double k_line_spacing = 0.5;  // mm between lines along the outline, at most; see also make()
constexpr double k_nearest_apex = 5;    // mm from the apex to the nearest bone, at least
constexpr double k_margin = k_overcut;  // mm by which the surface extends beyond the tables

std::uint64_t key_of(const glm::ivec3& brick) {
  return static_cast<std::uint64_t>(brick.x) | static_cast<std::uint64_t>(brick.y) << 21 |
         static_cast<std::uint64_t>(brick.z) << 42;
}
glm::ivec3 brick_of(std::uint64_t key) {
  return {static_cast<int>(key & 0x1fffff), static_cast<int>(key >> 21 & 0x1fffff),
          static_cast<int>(key >> 42)};
}

/// Calls each(key) for the bricks with samples in the box low .. high, extended by `beyond` mm. Extends `box`
/// by these samples.
template <class Each>
void for_bricks(const volume::CutLattice& lattice, const dvec3& low, const dvec3& high, double beyond,
                volume::VoxelBox& box, Each&& each) {
  const glm::dmat3 inverse = glm::inverse(lattice.frame().axes());
  glm::ivec3 first, last;
  for (int a = 0; a < 3; ++a) {
    const double reach = beyond * glm::length(glm::row(inverse, a)), last_index = lattice.size()[a] - 1;
    first[a] = static_cast<int>(std::clamp(std::floor(low[a] - reach), 0.0, last_index));
    last[a] = static_cast<int>(std::clamp(std::ceil(high[a] + reach), 0.0, last_index));
  }
  box = volume::union_of(box, {first, last});
  first /= volume::k_brick, last /= volume::k_brick;
  for (int z = first.z; z <= last.z; ++z)
    for (int y = first.y; y <= last.y; ++y)
      for (int x = first.x; x <= last.x; ++x) each(key_of({x, y, z}));
}

}  // namespace

std::string between_anchors(std::size_t side, std::size_t count) {
  return "between anchors " + std::to_string(side + 1) + " and " + std::to_string((side + 1) % count + 1);
}

LocatedStatus CutSurface::make(const Pyramid& pyramid, const Field& bone, double width,
                               const SawLimits& limits) {
  pyramid_ = pyramid;
  width_ = width;
  lines_.clear();
  const double step = std::min(k_line_spacing, 0.5 * width);
  for (std::size_t i = 0; i < pyramid_.size(); ++i) {
    const dvec3 &a = pyramid_.anchor(i), &b = pyramid_.anchor(i + 1);
    const int count = std::max(2, static_cast<int>(std::ceil(glm::length(b - a) / step)));
    for (int k = 0; k < count; ++k) {
      const dvec3 w = a + static_cast<double>(k) / count * (b - a) - pyramid_.apex_world;
      // Both tables are at the chord until find_tables() sets them.
      const double far = glm::length(w);
      lines_.push_back({i, w / far, far, far, 0, 0, k == 0, false});
    }
  }
  if (auto error = find_tables(bone, limits)) return error;
  if (auto error = check_holes(limits.hole)) return error;
  return check_scan(bone.volume());
}

LocatedStatus CutSurface::find_tables(const Field& bone, const SawLimits& limits) {
  const std::size_t n = lines_.size(), sides = pyramid_.size();
  // Upper bound of the rise of a skull of 60 mm radius above a side, mm.
  const auto rise_of_side = [&](std::size_t side) {
    const double length = glm::length(pyramid_.anchor(side + 1) - pyramid_.anchor(side));
    return 20 + length * length / 300;
  };
  const volume::BoneLabels labels(bone.volume());
  const auto runs_of = [&](const Line& line, double offset) {
    const dvec3 across = glm::normalize(glm::cross(pyramid_.anchor(line.side) - pyramid_.apex_world,
                                                   pyramid_.anchor(line.side + 1) - pyramid_.apex_world));
    return runs_along(bone, pyramid_.apex_world + offset * across, line.along,
                      std::max(k_nearest_apex, line.outer - k_inward), line.outer + rise_of_side(line.side),
                      limits.space, &labels);
  };
  std::vector<std::vector<Run>> central_runs(n);
  std::vector<double> chord(n);
  for (std::size_t i = 0; i < n; ++i) central_runs[i] = runs_of(lines_[i], 0), chord[i] = lines_[i].outer;

  // Follows the tables from both anchors of a side to its middle. The outer table of a line is near that of
  // the previous line.
  const auto follow = [&](std::size_t i, double& rise) {
    const Run* run =
        nearest_run(central_runs[i], chord[i] + rise, lines_[i].is_on_anchor ? k_anchor_reach : k_jump);
    if (run == nullptr) return false;
    rise = run->high - chord[i];
    lines_[i].outer = run->high, lines_[i].inner = run->low, lines_[i].is_bone = true;
    return true;
  };
  for (std::size_t first = 0; first < n;) {
    std::size_t next = first + 1;
    while (next < n && !lines_[next].is_on_anchor) ++next;
    const std::size_t end = next % n;
    double from_first = 0, from_next = 0;
    if (!follow(first, from_first)) {
      const Run* closest = nearest_run(central_runs[first], chord[first], k_inward);
      return LocatedError{"anchor " + std::to_string(lines_[first].side + 1) + " lies off the bone" +
                              (closest ? ": the nearest bone along the saw is " +
                                             rounded(std::abs(closest->high - chord[first])) + " mm away"
                                       : ""),
                          pyramid_.anchor(lines_[first].side)};
    }
    if (const Run* run = nearest_run(central_runs[end], chord[end], k_anchor_reach))
      from_next = run->high - chord[end];
    const std::size_t half = (next - first) / 2;
    for (std::size_t k = 1; k <= half; ++k) follow(first + k, from_first);
    for (std::size_t k = next - 1; k > first + half; --k) follow(k, from_next);
    if (const Line& one = lines_[first + half], &other = lines_[(first + half + 1) % n];
        one.is_bone && other.is_bone && std::abs(one.outer - other.outer) > 2 * k_jump) {
      return LocatedError{"the skull's surface is not continuous " + between_anchors(one.side, sides) +
                              ": it jumps by " + rounded(std::abs(one.outer - other.outer)) + " mm",
                          point_at(one, one.outer)};
    }
    first = next;
  }

  for (std::size_t i = 0; i < n; ++i) {
    Line& line = lines_[i];
    if (!line.is_bone) continue;
    if (line.outer - line.inner > limits.thickest) {
      return LocatedError{"the bone is thicker than " + rounded(limits.thickest) + " mm " +
                              between_anchors(line.side, sides) + ": it is not calvaria",
                          point_at(line, line.outer - limits.thickest)};
    }
    if (line.inner <= k_nearest_apex) {
      return LocatedError{"the apex is less than 5 mm from bone: increase its distance from the outline",
                          pyramid_.apex_world};
    }
    line.from = line.inner, line.to = line.outer;
    for (const double offset : {-0.5 * width_, 0.5 * width_}) {
      Line edge = line;
      edge.outer = chord[i];
      const std::vector<Run> runs = runs_of(edge, offset);
      if (const Run* run = nearest_run(runs, line.outer, k_jump)) {
        line.from = std::min(line.from, std::max(run->low, line.outer - limits.thickest));
        line.to = std::max(line.to, run->high);
      }
    }
  }
  return std::nullopt;
}

/// Bridges gaps in the bone, such as sutures, and extends each line to the ends of its neighbours. Fails if
/// the outline leaves the bone for more than `largest` mm.
LocatedStatus CutSurface::check_holes(double largest) {
  const std::size_t n = lines_.size(), sides = pyramid_.size();
  // Anchors are on bone, so no gap includes the first line.
  for (std::size_t first = 0; first < n; ++first) {
    if (lines_[first].is_bone) continue;
    std::size_t end = first;
    while (end < n && !lines_[end].is_bone) ++end;
    const Line before = lines_[first - 1], after = lines_[end % n];
    const double gap = glm::length(outer_point(end % n) - outer_point(first - 1));
    if (gap > largest) {
      constexpr double k_largest_foramen = 20;
      const dvec3 at = 0.5 * (outer_point(first - 1) + outer_point(end % n));
      return LocatedError{gap <= k_largest_foramen
                              ? "the outline goes through a hole of " + rounded(gap) + " mm in the bone " +
                                    between_anchors(before.side, sides)
                              : "the outline leaves the bone for " + rounded(gap) + " mm " +
                                    between_anchors(before.side, sides),
                          at};
    }
    for (std::size_t i = first; i < end; ++i) {
      const double share = static_cast<double>(i - first + 1) / static_cast<double>(end - first + 1);
      const auto mix = [share](double a, double b) { return a + share * (b - a); };
      Line& line = lines_[i];
      line.outer = mix(before.outer, after.outer), line.inner = mix(before.inner, after.inner);
      line.from = mix(before.from, after.from), line.to = mix(before.to, after.to);
    }
    first = end;
  }
  // Extend each line by its neighbours within half of the width of the saw.
  const double step = std::min(k_line_spacing, 0.5 * width_);
  const auto neighbours = static_cast<std::size_t>(std::ceil(0.5 * width_ / step));
  const std::vector<Line> original = lines_;
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = 0; k <= 2 * neighbours; ++k) {
      const Line& other = original[(i + n * (1 + neighbours / n) + k - neighbours) % n];
      lines_[i].from = std::min(lines_[i].from, other.from);
      lines_[i].to = std::max(lines_[i].to, other.to);
    }
    lines_[i].from = std::max(lines_[i].from - k_margin, k_nearest_apex);
    lines_[i].to += k_margin;
  }
  return std::nullopt;
}

LocatedStatus CutSurface::check_scan(const volume::Volume& scan) const {
  for (const Line& line : lines_)
    for (const double t : {line.from, line.to}) {
      const dvec3 p = scan.frame.volume_from_world(point_at(line, t));
      if (glm::all(glm::greaterThanEqual(p, dvec3(-0.5))) &&
          glm::all(glm::lessThanEqual(p, dvec3(scan.size) - 0.5)))
        continue;
      return LocatedError{"the outline leaves the scan " + between_anchors(line.side, pyramid_.size()),
                          point_at(line, line.outer)};
    }
  return std::nullopt;
}

double CutSurface::wall_mm2(const Field& bone, const volume::Version& before) const {
  const std::size_t n = lines_.size();
  // Area of bone that a line sweeps per radian, without matter that earlier cuts removed.
  constexpr double k_step = 0.1;
  std::vector<double> swept(n, 0);
  for (std::size_t i = 0; i < n; ++i)
    for (const Run& run :
         runs_along(bone, pyramid_.apex_world, lines_[i].along, lines_[i].from, lines_[i].to, 0)) {
      swept[i] += 0.5 * (run.high * run.high - run.low * run.low);
      if (before.is_uncut()) continue;
      const int count = std::max(1, static_cast<int>(std::ceil((run.high - run.low) / k_step)));
      const double step = (run.high - run.low) / count;
      for (int s = 0; s < count; ++s) {
        const double t = run.low + (s + 0.5) * step;
        if (before.distance(bone.volume().frame.volume_from_world(point_at(lines_[i], t))) <= 0)
          swept[i] -= t * step;
      }
    }
  double sum = 0;
  for (std::size_t i = 0; i < n; ++i)
    sum += 0.5 * (swept[i] + swept[(i + 1) % n]) *
           glm::length(glm::cross(lines_[i].along, lines_[(i + 1) % n].along));
  return sum;
}

std::vector<dvec3> CutSurface::outline() const {
  std::vector<dvec3> points;
  for (std::size_t i = 0; i < lines_.size(); ++i) points.push_back(outer_point(i));
  return points;
}
std::vector<dvec3> CutSurface::floor() const {
  std::vector<dvec3> points;
  for (const Line& line : lines_) points.push_back(point_at(line, line.from));
  return points;
}

CutSurface::OuterSurface CutSurface::outer_surface(const Field& bone, double step) const {
  OuterSurface result;
  const auto stride = static_cast<std::size_t>(std::max(1.0, 2 * step));
  std::vector<std::size_t>& rim = result.rim;
  for (std::size_t i = 0; i < lines_.size(); ++i)
    if (lines_[i].is_on_anchor || i % stride == 0) rim.push_back(i);
  double widest = 0;
  for (const std::size_t i : rim)
    widest = std::max(widest, glm::length(outer_point(i) - pyramid_.centre_world));
  const int rings = std::max(8, static_cast<int>(std::ceil(widest / step)));
  const auto at_ring = [&](std::size_t i, int ring, double& t) {
    bool is_ahead = false;
    const dvec2 p = static_cast<double>(ring) / rings * pyramid_.project(outer_point(i), is_ahead);
    const dvec3 along =
        glm::normalize(pyramid_.normal_world + p.x * pyramid_.right_world + p.y * pyramid_.up_world);
    const auto runs = runs_along(bone, pyramid_.apex_world, along, t - k_jump - 1, t + k_jump + 1, k_jump);
    if (const Run* run = nearest_run(runs, t, k_jump); run && run->high < t + k_jump + 0.9) t = run->high;
    return pyramid_.apex_world + t * along;
  };
  std::vector<std::vector<dvec3>>& grid = result.grid;
  grid.resize(rim.size());
  for (std::size_t r = 0; r < rim.size(); ++r) {
    double t = lines_[rim[r]].outer;
    grid[r].resize(static_cast<std::size_t>(rings) + 1);
    for (int ring = rings; ring >= 0; --ring)
      grid[r][static_cast<std::size_t>(ring)] = at_ring(rim[r], ring, t);
  }
  // Each line found its own centre point; all get the mean of these points.
  dvec3 middle(0);
  for (const auto& line : grid) middle += line[0] / static_cast<double>(grid.size());
  for (auto& line : grid) line[0] = middle;
  return result;
}

double CutSurface::outer_mm2(const Field& bone) const {
  const std::vector<std::vector<dvec3>> grid = outer_surface(bone, 1).grid;
  const auto area = [&](const dvec3& a, const dvec3& b, const dvec3& c) {
    const dvec3 twice = glm::cross(b - a, c - a);
    return std::copysign(0.5 * glm::length(twice), glm::dot(twice, pyramid_.normal_world));
  };
  double sum = 0;
  for (std::size_t r = 0; r < grid.size(); ++r) {
    const std::vector<dvec3>&line = grid[r], &next = grid[(r + 1) % grid.size()];
    for (std::size_t k = 0; k + 1 < line.size(); ++k)
      sum += area(line[k], line[k + 1], next[k + 1]) + area(line[k], next[k + 1], next[k]);
  }
  return std::abs(sum);
}

CutSurface::Strip CutSurface::strip(std::size_t i) const noexcept {
  const Line &a = lines_[i], &b = lines_[(i + 1) % lines_.size()];
  Strip strip{{point_at(a, a.from), point_at(a, a.to), point_at(b, b.to), point_at(b, b.from)},
              glm::normalize(glm::cross(a.along, b.along)),
              dvec3(0),
              0,
              a.side};
  for (const dvec3& corner : strip.corners) strip.middle += 0.25 * corner;
  for (const dvec3& corner : strip.corners)
    strip.reach = std::max(strip.reach, glm::length(corner - strip.middle));
  return strip;
}

double CutSurface::distance_square(const Strip& strip, const dvec3& p_world) noexcept {
  const double height = glm::dot(p_world - strip.corners[0], strip.normal);
  double edge_square = 0;
  bool is_inside = true;
  for (int k = 0; k < 4; ++k) {
    const dvec3 &a = strip.corners[k], edge = strip.corners[(k + 1) % 4] - a, w = p_world - a;
    if (glm::dot(glm::cross(strip.normal, edge), w) >= 0) continue;
    const double length = glm::dot(edge, edge), t = std::clamp(glm::dot(w, edge) / length, 0.0, 1.0);
    const dvec3 offset = w - t * edge;
    const double square = glm::dot(offset, offset);
    edge_square = is_inside ? square : std::min(edge_square, square);
    is_inside = false;
  }
  return is_inside ? height * height : edge_square;
}

bool CutSurface::crosses(const Strip& strip, const dvec3& a, const dvec3& b) noexcept {
  const double ha = glm::dot(a - strip.corners[0], strip.normal),
               hb = glm::dot(b - strip.corners[0], strip.normal);
  if ((ha > 0) == (hb > 0)) return false;
  const dvec3 p = a + ha / (ha - hb) * (b - a);
  for (int k = 0; k < 4; ++k)
    if (glm::dot(glm::cross(strip.normal, strip.corners[(k + 1) % 4] - strip.corners[k]),
                 p - strip.corners[k]) < 0)
      return false;
  return true;
}

Kerf::Kerf(const CutSurface& surface, const volume::Version& version, double beyond)
    : surface_(surface), lattice_(version.lattice()), box_{glm::ivec3(0), glm::ivec3(-1)} {
  const double reach = 0.5 * surface.width() + version.band_mm() + beyond;
  for (std::size_t i = 0; i < surface.lines().size(); ++i) {
    strips_.push_back(surface.strip(i));
    dvec3 low(1e30), high(-1e30);
    for (const dvec3& corner : strips_[i].corners) {
      const dvec3 s = lattice_.frame().volume_from_world(corner);
      low = glm::min(low, s), high = glm::max(high, s);
    }
    for_bricks(lattice_, low, high, reach, box_,
               [&](std::uint64_t key) { strips_by_brick_[key].push_back(static_cast<std::uint32_t>(i)); });
  }
}

volume::RemovalField::Reach Kerf::find(const glm::ivec3& low, double band, Distances& mm) {
  const auto entry = strips_by_brick_.find(key_of(low / volume::k_brick));
  if (entry == strips_by_brick_.end()) return Reach::none;
  bool is_any = false, is_all = true;
  std::size_t sample = 0;
  for (int z = -1; z <= volume::k_brick; ++z)
    for (int y = -1; y <= volume::k_brick; ++y)
      for (int x = -1; x <= volume::k_brick; ++x, ++sample) {
        const dvec3 p = lattice_.frame().world_from_volume(dvec3(low + glm::ivec3(x, y, z)));
        double nearest = 0.5 * surface_.width() + band;
        for (const std::uint32_t i : entry->second) {
          const dvec3 w = p - strips_[i].middle;
          const double reach = nearest + strips_[i].reach;
          if (glm::dot(w, w) >= reach * reach) continue;
          const double square = CutSurface::distance_square(strips_[i], p);
          if (square < nearest * nearest) nearest = std::sqrt(square);
        }
        const double d = std::max(nearest - 0.5 * surface_.width(), -band);
        mm[sample] = static_cast<float>(d);
        is_any = is_any || d < band;
        is_all = is_all && d <= -band;
      }
  return is_all ? Reach::all : is_any ? Reach::some : Reach::none;
}

std::int64_t Kerf::count_holes(const Field& bone, const volume::Version& rest) const {
  const auto index = [](const glm::ivec3& s) {
    return static_cast<std::size_t>((s.x + 1) + k_edge * ((s.y + 1) + k_edge * (s.z + 1)));
  };
  std::int64_t holes = 0;
  std::vector<char> is_solid(k_edge * k_edge * k_edge);
  std::vector<double> height(is_solid.size());
  for (const auto& entry : strips_by_brick_) {
    const auto& strips = entry.second;
    const glm::ivec3 low = volume::k_brick * brick_of(entry.first);
    const auto position = [&](const glm::ivec3& offset) {
      return lattice_.frame().world_from_volume(dvec3(low + offset));
    };
    const auto for_samples = [](int from, int to, auto&& each) {
      for (int z = from; z <= to; ++z)
        for (int y = from; y <= to; ++y)
          for (int x = from; x <= to; ++x) each(glm::ivec3(x, y, z));
    };
    for_samples(-1, volume::k_brick, [&](const glm::ivec3& offset) {
      is_solid[index(offset)] = rest.sample_distance(low + offset) > 0 &&
                                bone.value(lattice_.volume_from_lattice(dvec3(low + offset))) >= 0;
    });
    // Handles the strips of one side of the pyramid together: they are in one plane.
    for (std::size_t first = 0; first < strips.size();) {
      std::size_t end = first;
      const CutSurface::Strip& strip = strips_[strips[first]];
      while (end < strips.size() && strips_[strips[end]].side == strip.side) ++end;
      for_samples(-1, volume::k_brick, [&](const glm::ivec3& offset) {
        height[index(offset)] = glm::dot(position(offset) - strip.corners[0], strip.normal);
      });
      for_samples(0, volume::k_brick - 1, [&](const glm::ivec3& offset) {
        if (!is_solid[index(offset)]) return;
        for (int n = 14; n < 27; ++n) {  // each pair once
          const glm::ivec3 other = offset + glm::ivec3(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1);
          if (!is_solid[index(other)] || (height[index(offset)] > 0) == (height[index(other)] > 0)) continue;
          holes += std::any_of(strips.begin() + static_cast<std::ptrdiff_t>(first),
                               strips.begin() + static_cast<std::ptrdiff_t>(end), [&](std::uint32_t i) {
                                 return CutSurface::crosses(strips_[i], position(offset), position(other));
                               });
        }
      });
      first = end;
    }
  }
  return holes;
}

}  // namespace trephine::bone_flap
