#include "volume/anatomy/vertebra.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <optional>
#include <span>

#include "volume/base/deterministic_math.h"
#include "volume/base/parallel.h"
#include "volume/scan/traversal.h"

namespace trephine::volume {

using glm::dvec2;
using glm::dvec3;

namespace {

constexpr int k_right_angle = k_canal_rays / 4;
constexpr int k_roof = 35 * k_canal_rays / 360;  ///< rays to either side of straight back

int around(int ray) { return (ray % k_canal_rays + k_canal_rays) % k_canal_rays; }

const std::array<dvec2, k_canal_rays>& directions() {
  static const std::array<dvec2, k_canal_rays> all = [] {
    std::array<dvec2, k_canal_rays> result;
    for (int i = 0; i < k_canal_rays; ++i) {
      const double angle = 2 * 3.14159265358979323846 * i / k_canal_rays;
      result[static_cast<std::size_t>(i)] = {deterministic_sin(angle), deterministic_cos(angle)};
    }
    return result;
  }();
  return all;
}

/// Line of the world frame through the bone, with a parameter in mm.
class Line {
 public:
  Line(const dvec3& from, const dvec3& along, const Field& bone, const Version* version)
      : bone_(bone),
        version_(version),
        from_(bone.volume().frame.volume_from_world(from)),
        along_(bone.volume().frame.vector_volume_from_world(along)) {}

  dvec3 at(double t) const { return from_ + t * along_; }
  bool is_bone(double t) const {
    const dvec3 p = at(t);
    return bone_.value(p) >= 0 && (version_ == nullptr || version_->distance(p) > 0);
  }
  /// Returns the parameter of the surface between `a` and `b`. Exactly one of them must be in bone.
  double crossing(double a, double b) const {
    const bool is_first = is_bone(a);
    for (int i = 0; i < 20; ++i) {
      const double between = 0.5 * (a + b);
      (is_bone(between) == is_first ? a : b) = between;
    }
    return 0.5 * (a + b);
  }
  /// Returns the parameter at which the intensity is half way between the matter in front of the surface at t
  /// and the bone behind it. This position of the surface does not depend on the window of the bone. `step`:
  /// mm between samples. Returns t if there is no such parameter, or if the shape is a label.
  double half_way(double t, double step) const {
    if (bone_.shape().is_label()) return t;
    constexpr double k_before = 2, k_behind = 3.5;  // voxels, range of the search, by the blur of scans
    const double voxel = std::max(1.0 / glm::length(along_), step);
    const auto intensity = [this](double s) { return bone_.value(at(s)) + bone_.shape().low; };
    double lowest = intensity(t), highest = lowest, low_at = t, high_at = t;
    for (double s = t - k_before * voxel; s < t; s += step)
      if (const double i = intensity(s); i < lowest) lowest = i, low_at = s;
    for (double s = t + step; s <= t + k_behind * voxel; s += step)
      if (const double i = intensity(s); i > highest) highest = i, high_at = s;
    const double level = 0.5 * (lowest + highest);
    double near = low_at, far = high_at;
    if (!(intensity(near) < level && intensity(far) > level)) return t;
    for (int i = 0; i < 20; ++i) {
      const double between = 0.5 * (near + far);
      (intensity(between) < level ? near : far) = between;
    }
    return 0.5 * (near + far);
  }

 private:
  const Field& bone_;
  const Version* version_;
  dvec3 from_, along_;
};

/// Returns the distance between samples along a ray, mm: a quarter of the smallest voxel spacing, from 0.05
/// to 0.25 mm.
double ray_step(const Field& bone) {
  const dvec3& h = bone.volume().frame.spacing();
  return std::clamp(0.25 * std::min({h.x, h.y, h.z}), 0.05, 0.25);
}

bool is_of_label(const Volume& scan, int label, const dvec3& world) {
  const glm::ivec3 v = voxel_of(scan.frame.volume_from_world(world));
  return scan.contains(v) && scan.labels[scan.index(v.x, v.y, v.z)] == label;
}

/// Returns evenly spaced points in a label's voxels, at most k_apart from each other along each axis.
std::vector<dvec3> points_in_label(const Volume& scan, int label) {
  constexpr double k_apart = 0.6;  // mm
  std::vector<dvec3> points;
  if (scan.labels.is_empty()) return points;
  const glm::ivec3 parts(glm::ceil(scan.frame.spacing() / k_apart));
  for (int z = 0; z < scan.size.z; ++z)
    for (int y = 0; y < scan.size.y; ++y)
      for (int x = 0; x < scan.size.x; ++x) {
        if (scan.labels[scan.index(x, y, z)] != label) continue;
        for (int n = 0; n < parts.x * parts.y * parts.z; ++n) {
          const dvec3 part(n % parts.x, n / parts.x % parts.y, n / (parts.x * parts.y));
          points.push_back(scan.frame.world_from_volume(dvec3(x, y, z) - 0.5 + (part + 0.5) / dvec3(parts)));
        }
      }
  return points;
}

/// Returns a voxel of a label that extends farther along an axis of the scan than any vertebra, if it does.
/// Ignores 1 % of the voxels at each end, such as stray voxels of a segmentation.
std::optional<dvec3> voxel_of_large_label(const Volume& scan, int label) {
  constexpr double k_largest = 150;  // mm; a lumbar vertebra is at most 120 mm wide
  if (scan.labels.is_empty()) return std::nullopt;
  std::array<std::vector<std::size_t>, 3> counts;  // voxels of the label per index along an axis
  for (int a = 0; a < 3; ++a)
    counts[static_cast<std::size_t>(a)].resize(static_cast<std::size_t>(scan.size[a]));
  std::size_t all = 0;
  glm::ivec3 last(0);
  for (int z = 0; z < scan.size.z; ++z)
    for (int y = 0; y < scan.size.y; ++y)
      for (int x = 0; x < scan.size.x; ++x) {
        if (scan.labels[scan.index(x, y, z)] != label) continue;
        ++all, last = {x, y, z};
        for (int a = 0; a < 3; ++a) ++counts[static_cast<std::size_t>(a)][static_cast<std::size_t>(last[a])];
      }
  if (all == 0) return std::nullopt;
  const dvec3 spacing = scan.frame.spacing();
  for (int a = 0; a < 3; ++a) {
    const std::vector<std::size_t>& along = counts[static_cast<std::size_t>(a)];
    std::size_t low = 0, high = along.size() - 1, below = along[low], above = along[high];
    while (below <= all / 100) below += along[++low];
    while (above <= all / 100) above += along[--high];
    if (static_cast<double>(high - low) * spacing[a] > k_largest)
      return scan.frame.world_from_volume(dvec3(last));
  }
  return std::nullopt;
}

/// Finds a point in the hole of the label's ring: rays from there in at least k_enough of k_directions
/// directions in the axial plane meet the label. Returns false if there is no such hole.
bool find_hole(const Volume& scan, int label, const std::vector<dvec3>& points, dvec3& hole) {
  constexpr double k_grid = 2, k_step = 1, k_far = 25;  // mm
  constexpr int k_directions = 16, k_enough = 14;
  dvec3 low = points.front(), high = low;
  for (const dvec3& p : points) low = glm::min(low, p), high = glm::max(high, p);
  std::array<std::vector<dvec3>, k_directions + 1> by_count;
  for (double z = low.z; z <= high.z; z += k_grid)
    for (double y = low.y; y <= high.y; y += k_grid)
      for (double x = low.x; x <= high.x; x += k_grid) {
        const dvec3 p(x, y, z);
        if (is_of_label(scan, label, p)) continue;
        int count = 0;
        for (int direction = 0; direction < k_directions && direction - count <= k_directions - k_enough;
             ++direction) {
          const dvec2 to = directions()[static_cast<std::size_t>(direction * k_canal_rays / k_directions)];
          for (double t = k_step; t <= k_far; t += k_step)
            if (is_of_label(scan, label, p + t * dvec3(to, 0))) {
              ++count;
              break;
            }
        }
        if (count >= k_enough) by_count[static_cast<std::size_t>(count)].push_back(p);
      }
  // Prefers points from which more directions meet the label, and returns the median of these points.
  for (int count = k_directions; count >= k_enough; --count) {
    std::vector<dvec3>& candidates = by_count[static_cast<std::size_t>(count)];
    if (candidates.size() < 4) continue;
    for (int a = 0; a < 3; ++a) {
      const auto middle = candidates.begin() + static_cast<std::ptrdiff_t>(candidates.size() / 2);
      std::nth_element(candidates.begin(), middle, candidates.end(),
                       [a](const dvec3& p, const dvec3& q) { return p[a] < q[a]; });
      hole[a] = (*middle)[a];
    }
    return true;
  }
  return false;
}

/// Sets `middle` to the centroid of a section, in its plane (x to the left, y to the back, mm). Returns false
/// if less than 80 % of the rays are closed, or if the area is out of the range of canals.
bool find_centroid(const CanalSection& section, dvec2& middle) {
  double twice = 0;
  dvec2 sum(0);
  int closed = 0, last = -1;
  const auto corner = [&](int ray) {
    return section.before[static_cast<std::size_t>(around(ray))] *
           directions()[static_cast<std::size_t>(around(ray))];
  };
  int first = 0;
  while (first < k_canal_rays && !section.is_closed(first, false)) ++first;
  if (first == k_canal_rays) return false;
  for (int i = first; i <= first + k_canal_rays; ++i) {
    if (!section.is_closed(i, false)) continue;
    if (last >= 0) {
      const dvec2 a = corner(last), b = corner(i);
      const double area =
          b.x * a.y - a.x * b.y;  // twice the area; positive, since rays turn from back to left
      twice += area, sum += area / 3 * (a + b);
    }
    last = i, ++closed;
  }
  constexpr double k_min = 40, k_max = 900;  // mm2, range of spinal canals
  if (closed < k_canal_rays * 8 / 10 || twice < 2 * k_min || twice > 2 * k_max) return false;
  middle = sum / twice;
  return true;
}

/// Returns the sections of the uncut canal at `heights` (mm along `up`). Uses all cores.
std::vector<CanalSection> sections_at(const VertebraFrame& frame, std::span<const double> heights,
                                      const CanalWalls& walls) {
  std::vector<CanalSection> sections(heights.size());
  parallel_for(static_cast<int>(heights.size()), 0, [&](int i) {
    const auto index = static_cast<std::size_t>(i);
    sections[index] = canal_section(frame, heights[index], walls, nullptr);
  });
  return sections;
}

/// Returns the median distance from the centre of the canal to its wall, mm, at mid-height, over the rays
/// within 20 degrees of `middle_ray`. Returns half of k_canal_reach without a wall.
double median_wall(const VertebraFrame& frame, const CanalWalls& walls, int middle_ray) {
  constexpr int k_spread = 20 * k_canal_rays / 360;
  std::vector<double> distances;
  for (const CanalSection& section : sections_at(frame, std::array{-4.0, 0.0, 4.0}, walls))
    for (int ray = -k_spread; ray <= k_spread; ++ray)
      if (const double r = section.before[static_cast<std::size_t>(around(middle_ray + ray))]; r >= 0)
        distances.push_back(r);
  if (distances.empty()) return 0.5 * k_canal_reach;
  const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
  std::nth_element(distances.begin(), middle, distances.end());
  return *middle;
}

/// Returns the inclination of the vertebra's body: shift of the centres of its cross-sections to the left and
/// to the back, mm per mm up; 0 if the body is too small. Both ends of the body are left out, since oblique
/// ends would bias the result.
dvec2 lean_of(const VertebraFrame& frame, const std::vector<dvec3>& points, double front) {
  constexpr double k_spared = 0.2;  // share of the body's points that is left out at each end
  constexpr double k_behind = 4;    // mm in front of the canal; bone nearer to the canal may be pedicle
  std::vector<dvec3> body;
  for (const dvec3& p : points)
    if (const dvec3 q = frame.local(p); q.y < -front - k_behind) body.push_back(q);
  if (body.size() < 20) return dvec2(0);
  std::vector<double> heights;
  for (const dvec3& q : body) heights.push_back(q.z);
  const auto at = [&](double share) {
    const auto rank = static_cast<std::ptrdiff_t>(share * static_cast<double>(heights.size() - 1));
    std::nth_element(heights.begin(), heights.begin() + rank, heights.end());
    return heights[static_cast<std::size_t>(rank)];
  };
  const double low = at(k_spared), high = at(1 - k_spared);
  dvec3 mean(0);
  double count = 0;
  for (const dvec3& q : body)
    if (q.z >= low && q.z <= high) mean += q, ++count;
  mean /= count;
  dvec2 sum(0);
  double square = 0;
  for (const dvec3& q : body)
    if (q.z >= low && q.z <= high) {
      sum += (q.z - mean.z) * dvec2(q - mean);
      square += (q.z - mean.z) * (q.z - mean.z);
    }
  return square > 0 ? sum / square : dvec2(0);
}

/// Moves the frame to the centre of the canal's sections, and aligns it with the vertebra's body. Returns
/// false if no section is that of a canal.
bool align(const CanalWalls& walls, const std::vector<dvec3>& points, VertebraFrame& frame) {
  constexpr std::array k_heights{-10.0, -8.0, -6.0, -4.0, -2.0, 0.0, 2.0, 4.0, 6.0, 8.0, 10.0};  // mm
  constexpr double k_steepest = 0.82;  // cosine of the largest inclination, about 35 degrees
  constexpr int k_rounds = 6;
  const dvec3 upright = frame.up;
  for (int round = 0; round < k_rounds; ++round) {
    dvec2 sum(0);
    int count = 0;
    for (const CanalSection& section : sections_at(frame, k_heights, walls))
      if (dvec2 middle; find_centroid(section, middle)) sum += middle, ++count;
    if (count == 0) return false;
    const dvec2 middle = sum / static_cast<double>(count);
    frame.middle = frame.world({middle.x, middle.y, 0});
    if (points.empty()) continue;
    const double front = canal_front(frame, walls);
    const dvec2 lean = lean_of(frame, points, front);
    const dvec3 up = glm::normalize(frame.up + lean.x * frame.left + lean.y * frame.back);
    if (glm::dot(up, upright) > k_steepest) frame.up = up;
    dvec3 body(0);
    for (const dvec3& p : points)
      if (const dvec3 q = p - frame.middle; glm::dot(q, frame.back) < -front) body += q;
    body -= glm::dot(body, frame.up) * frame.up;
    if (glm::length(body) > 0) frame.back = -body;
    frame.back = glm::normalize(frame.back - glm::dot(frame.back, frame.up) * frame.up);
    frame.left = glm::cross(frame.back, frame.up);
  }
  return true;
}

}  // namespace

dvec3 VertebraFrame::local(const dvec3& w) const noexcept {
  const dvec3 p = w - middle;
  return {glm::dot(p, left), glm::dot(p, back), glm::dot(p, up)};
}

dvec2 canal_ray_direction(int ray) noexcept { return directions()[static_cast<std::size_t>(around(ray))]; }

bool CanalSection::is_closed(int ray, bool is_after) const noexcept {
  return (is_after ? after : before)[static_cast<std::size_t>(around(ray))] >= 0;
}

bool CanalSection::has_roof(bool is_after) const noexcept {
  for (int ray = -k_roof; ray <= k_roof; ++ray)
    if (!is_closed(ray, is_after) || !is_own[static_cast<std::size_t>(around(ray))]) return false;
  return true;
}

double CanalSection::area(bool is_after) const noexcept {
  // Distances along each ray to the wall, or to the line across an opening.
  const auto find_distances = [this](bool is_operated, std::array<double, k_canal_rays>& out) {
    const std::vector<double>& wall = is_operated ? after : before;
    int first = 0, closed = 0;
    for (int i = 0; i < k_canal_rays; ++i) closed += is_closed(i, is_operated);
    if (2 * closed < k_canal_rays) return false;
    while (!is_closed(first, is_operated)) ++first;
    for (int i = first; i < first + k_canal_rays;) {
      int next = i + 1;
      while (!is_closed(next, is_operated)) ++next;
      const auto at = [](int ray) { return static_cast<std::size_t>(around(ray)); };
      out[at(i)] = wall[at(i)];
      const dvec2 a = wall[at(i)] * canal_ray_direction(i), b = wall[at(next)] * canal_ray_direction(next),
                  side = b - a;
      for (int ray = i + 1; ray < next; ++ray) {
        // a + s side = r to: the cross product with `side` eliminates s.
        const dvec2 to = canal_ray_direction(ray);
        const double across = to.x * side.y - to.y * side.x, twice = a.x * side.y - a.y * side.x;
        out[at(ray)] = across != 0 ? std::clamp(twice / across, 0.0, k_canal_reach) : 0.0;
      }
      i = next;
    }
    return true;
  };
  std::array<double, k_canal_rays> r_before, r_after;
  if (!find_distances(false, r_before)) return -1;
  if (!is_after)
    r_after = r_before;
  else if (!find_distances(true, r_after))
    return -1;
  double twice = 0;
  for (std::size_t i = 0; i < k_canal_rays; ++i) {
    const double r = std::max(r_before[i], r_after[i]);
    twice += r * r;
  }
  return 0.5 * twice * (2 * 3.14159265358979323846 / k_canal_rays);
}

double CanalSection::opening() const noexcept {
  // Openings are searched from rays of the roof that were closed before the operation.
  double widest = 0;
  for (int ray = -k_roof; ray <= k_roof; ++ray) {
    if (is_closed(ray, true) || !is_closed(ray, false)) continue;
    int first_ray = ray, last_ray = ray;
    while (first_ray > ray - k_canal_rays / 2 && !is_closed(first_ray, true)) --first_ray;
    while (last_ray < ray + k_canal_rays / 2 && !is_closed(last_ray, true)) ++last_ray;
    if (!is_closed(first_ray, true) || !is_closed(last_ray, true)) continue;
    const dvec2 a = after[static_cast<std::size_t>(around(first_ray))] * canal_ray_direction(first_ray),
                b = after[static_cast<std::size_t>(around(last_ray))] * canal_ray_direction(last_ray);
    widest = std::max(widest, glm::length(b - a));
  }
  return widest;
}

CanalSection canal_section(const VertebraFrame& frame, double z, const CanalWalls& walls,
                           const Version* version) {
  constexpr double k_pores = 4;   // mm; bone behind a longer gap belongs to another wall
  constexpr double k_before = 3;  // mm; bone that begins this far in front of the label is another structure
  constexpr double k_wall = 10;   // mm; bone farther behind the inner surface is not part of the wall
  const std::vector<double> no_wall(k_canal_rays, -1);
  CanalSection section{z, no_wall, no_wall, no_wall, std::vector<char>(k_canal_rays, walls.label < 0)};
  const dvec3 from = frame.world({0, 0, z});
  const Volume& scan = walls.bone.volume();
  const Field own(scan, {"vertebra", 0, 0, walls.label});
  const double step = ray_step(walls.bone);
  for (int i = 0; i < k_canal_rays; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const dvec2 to = canal_ray_direction(i);
    const dvec3 along = to.x * frame.left + to.y * frame.back;
    const auto first_hit = [&](const Line& line) {
      for (double t = 0; t <= k_canal_reach; t += step)
        if (line.is_bone(t)) return t > 0 ? line.crossing(t - step, t) : 0.0;
      return -1.0;
    };
    const Line bone(from, along, walls.bone, nullptr);
    double hit = first_hit(bone);
    const Field* field = &walls.bone;
    section.before[at] = hit < 0 ? -1 : bone.half_way(hit, step);
    if (walls.label >= 0)
      if (const double own_hit = first_hit(Line(from, along, own, nullptr));
          own_hit >= 0 && (hit < 0 || section.before[at] > own_hit - k_before))
        hit = section.before[at] = own_hit, field = &own, section.is_own[at] = 1;
    if (hit < 0) continue;
    const Line line_before(from, along, *field, nullptr);
    double last = hit;
    for (double t = hit + step; t <= std::min(last + k_pores, 2 * k_canal_reach); t += step)
      if (line_before.is_bone(t)) last = t;
    section.wall_end[at] = last + step;
    section.after[at] = section.before[at];
    if (version == nullptr || version->is_uncut()) continue;
    const Line line_after(from, along, *field, version);
    double t_after = -1;
    for (double t = hit + 1e-3; t <= std::min(section.wall_end[at], hit + k_wall) && t_after < 0; t += step)
      if (line_after.is_bone(t)) t_after = t;
    if (t_after < 0)
      section.after[at] = -1;
    else if (t_after > hit + step)
      section.after[at] = std::max(section.before[at], line_after.crossing(t_after - step, t_after));
  }
  return section;
}

double canal_front(const VertebraFrame& frame, const CanalWalls& walls) {
  return median_wall(frame, walls, k_canal_rays / 2);
}
double canal_back(const VertebraFrame& frame, const CanalWalls& walls) {
  return median_wall(frame, walls, 0);
}

std::optional<Pedicles> find_pedicles(const VertebraFrame& frame, const CanalWalls& walls,
                                      std::span<const CanalSection> sections) {
  constexpr double k_step = 0.3;  // mm
  const Volume& scan = walls.bone.volume();
  // A pedicle closes one side of the canal: by the label if there is one, else by bone.
  const auto is_closed = [&](double z, double sign) {
    for (double x = 0; x < k_canal_reach; x += k_step) {
      const dvec3 world = frame.world({sign * x, 0, z});
      if (walls.label >= 0 ? is_of_label(scan, walls.label, world)
                           : walls.bone.value(scan.frame.volume_from_world(world)) >= 0)
        return true;
    }
    return false;
  };
  std::size_t best = 0, best_count = 0, count = 0;
  for (std::size_t i = 0; i < sections.size(); ++i) {
    count = is_closed(sections[i].z, 1) && is_closed(sections[i].z, -1) ? count + 1 : 0;
    if (count > best_count) best_count = count, best = i + 1 - count;
  }
  std::vector<double> widths;
  for (std::size_t i = best; i < best + best_count; ++i)
    for (const int side : {k_right_angle, k_canal_rays - k_right_angle})
      if (const double wide = sections[i].before[static_cast<std::size_t>(side)]; wide >= 0)
        widths.push_back(wide);
  if (widths.empty()) return std::nullopt;
  const auto middle = widths.begin() + static_cast<std::ptrdiff_t>(widths.size() / 2);
  std::nth_element(widths.begin(), middle, widths.end());
  return Pedicles{sections[best].z, sections[best + best_count - 1].z, *middle};
}

Result<VertebraFrame, LocatedError> find_vertebra(const CanalWalls& walls, const dvec3* canal_world) {
  const Volume& scan = walls.bone.volume();
  const int label = walls.label;
  VertebraFrame frame;
  if (label >= 0 && !canal_world)
    if (const std::optional<dvec3> voxel = voxel_of_large_label(scan, label))
      return LocatedError{"the label is larger than a vertebra: set a position in its canal", *voxel};
  const std::vector<dvec3> points = label >= 0 ? points_in_label(scan, label) : std::vector<dvec3>();
  if (label >= 0 && points.empty()) {
    return LocatedError{"the label of the vertebra has no voxels: choose another label", {}};
  }
  if (canal_world) {
    frame.middle = *canal_world;
  } else if (label < 0) {
    return LocatedError{"no vertebra selected: set its label, or a position in its canal", {}};
  } else if (!find_hole(scan, label, points, frame.middle)) {
    return LocatedError{"the vertebra's label encloses no canal: set a position in the canal",
                        points[points.size() / 2]};
  }
  if (!align(walls, points, frame)) {
    return LocatedError{"the position is not in a canal with bone around it: set a position in the canal",
                        frame.middle};
  }
  if (points.empty()) return frame;
  std::vector<double> heights;
  for (const dvec3& p : points) heights.push_back(glm::dot(p - frame.middle, frame.up));
  std::sort(heights.begin(), heights.end());
  frame.low = heights.front(), frame.high = heights.back();
  return frame;
}

}  // namespace trephine::volume
