#include "modules/laminectomy/vertebra.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

#include "volume/deterministic_math.h"
#include "volume/traversal.h"

namespace trephine::laminectomy {

using glm::dvec2;
using glm::dvec3;

namespace {

constexpr int k_right_angle = k_rays / 4;
constexpr int k_roof = 35 * k_rays / 360;  ///< rays to either side of straight back

int around(int ray) { return (ray % k_rays + k_rays) % k_rays; }

const std::array<dvec2, k_rays>& directions() {
  static const std::array<dvec2, k_rays> all = [] {
    std::array<dvec2, k_rays> made;
    for (int i = 0; i < k_rays; ++i) {
      const double angle = 2 * 3.14159265358979323846 * i / k_rays;
      made[static_cast<std::size_t>(i)] = {volume::deterministic_sin(angle),
                                           volume::deterministic_cos(angle)};
    }
    return made;
  }();
  return all;
}

/// A line of the world through the bone, mm along it.
class Line {
 public:
  Line(const dvec3& from, const dvec3& along, const volume::Field& bone, const volume::Version* version)
      : bone_(bone),
        version_(version),
        from_(bone.volume().frame.volume_from_world(from)),
        along_(bone.volume().frame.vector_volume_from_world(along)) {}

  dvec3 at(double t) const { return from_ + t * along_; }
  bool is_bone(double t) const {
    const dvec3 p = at(t);
    return bone_.value(p) >= 0 && (version_ == nullptr || version_->distance(p) > 0);
  }
  /// Between a place without bone and one with it, or the other way round.
  double crossing(double one, double other) const {
    const bool is_first = is_bone(one);
    for (int i = 0; i < 20; ++i) {
      const double between = 0.5 * (one + other);
      (is_bone(between) == is_first ? one : other) = between;
    }
    return 0.5 * (one + other);
  }
  /// Finds where the scan is half way between what lies before the surface at t and the bone behind it; that
  /// is where the surface is, whatever the window. `step`: mm. t itself where the scan does not show it.
  double half_way(double t, double step) const {
    if (bone_.shape().is_label()) return t;
    constexpr double k_before = 2, k_behind = 3.5;  // voxels, as blurred as scans are
    const double voxel = std::max(1.0 / glm::length(along_), step);
    const auto intensity = [this](double s) { return bone_.value(at(s)) + bone_.shape().low; };
    double least = intensity(t), most = least, low_at = t, high_at = t;
    for (double s = t - k_before * voxel; s < t; s += step)
      if (const double i = intensity(s); i < least) least = i, low_at = s;
    for (double s = t + step; s <= t + k_behind * voxel; s += step)
      if (const double i = intensity(s); i > most) most = i, high_at = s;
    const double level = 0.5 * (least + most);
    double near = low_at, far = high_at;
    if (!(intensity(near) < level && intensity(far) > level)) return t;
    for (int i = 0; i < 20; ++i) {
      const double between = 0.5 * (near + far);
      (intensity(between) < level ? near : far) = between;
    }
    return 0.5 * (near + far);
  }

 private:
  const volume::Field& bone_;
  const volume::Version* version_;
  dvec3 from_, along_;
};

double finest(const volume::Field& bone) {
  const dvec3& h = bone.volume().frame.spacing();
  return std::clamp(0.25 * std::min({h.x, h.y, h.z}), 0.05, 0.25);
}

bool is_of_label(const volume::Volume& scan, int label, const dvec3& world) {
  const glm::ivec3 v = volume::voxel_of(scan.frame.volume_from_world(world));
  return scan.contains(v) && scan.labels[scan.index(v.x, v.y, v.z)] == label;
}

/// Places in a label's voxels, evenly, no farther apart than thin slices are.
std::vector<dvec3> places_of(const volume::Volume& scan, int label) {
  constexpr double k_apart = 0.6;  // mm
  std::vector<dvec3> places;
  if (scan.labels.is_empty()) return places;
  const glm::ivec3 parts(glm::ceil(scan.frame.spacing() / k_apart));
  for (int z = 0; z < scan.size.z; ++z)
    for (int y = 0; y < scan.size.y; ++y)
      for (int x = 0; x < scan.size.x; ++x) {
        if (scan.labels[scan.index(x, y, z)] != label) continue;
        for (int n = 0; n < parts.x * parts.y * parts.z; ++n) {
          const dvec3 part(n % parts.x, n / parts.x % parts.y, n / (parts.x * parts.y));
          places.push_back(scan.frame.world_from_volume(dvec3(x, y, z) - 0.5 + (part + 0.5) / dvec3(parts)));
        }
      }
  return places;
}

/// Finds the place from which most directions across meet the label: the hole in its ring. False: no hole.
bool find_hole(const volume::Volume& scan, int label, const std::vector<dvec3>& places, dvec3& hole) {
  constexpr double k_grid = 2, k_step = 1, k_far = 25;  // mm
  constexpr int k_ways = 16, k_enough = 14;
  dvec3 low = places.front(), high = low;
  for (const dvec3& p : places) low = glm::min(low, p), high = glm::max(high, p);
  std::array<std::vector<dvec3>, k_ways + 1> by_count;
  for (double z = low.z; z <= high.z; z += k_grid)
    for (double y = low.y; y <= high.y; y += k_grid)
      for (double x = low.x; x <= high.x; x += k_grid) {
        const dvec3 p(x, y, z);
        if (is_of_label(scan, label, p)) continue;
        int count = 0;
        for (int way = 0; way < k_ways && way - count <= k_ways - k_enough; ++way) {
          const dvec2 to = directions()[static_cast<std::size_t>(way * k_rays / k_ways)];
          for (double t = k_step; t <= k_far; t += k_step)
            if (is_of_label(scan, label, p + t * dvec3(to, 0))) {
              ++count;
              break;
            }
        }
        if (count >= k_enough) by_count[static_cast<std::size_t>(count)].push_back(p);
      }
  // A whole ring where there is one; the middle of what it holds.
  for (int count = k_ways; count >= k_enough; --count) {
    std::vector<dvec3>& found = by_count[static_cast<std::size_t>(count)];
    if (found.size() < 4) continue;
    for (int a = 0; a < 3; ++a) {
      const auto middle = found.begin() + static_cast<std::ptrdiff_t>(found.size() / 2);
      std::nth_element(found.begin(), middle, found.end(),
                       [a](const dvec3& p, const dvec3& q) { return p[a] < q[a]; });
      hole[a] = (*middle)[a];
    }
    return true;
  }
  return false;
}

/// The middle of a section, in its plane; false where too little of it is closed, or it is no canal.
bool middle_of(const CanalSection& section, dvec2& middle) {
  double twice = 0;
  dvec2 sum(0);
  int closed = 0, last = -1;
  const auto corner = [&](int ray) {
    return section.before[static_cast<std::size_t>(around(ray))] *
           directions()[static_cast<std::size_t>(around(ray))];
  };
  int first = 0;
  while (first < k_rays && !section.is_closed(first, false)) ++first;
  if (first == k_rays) return false;
  for (int i = first; i <= first + k_rays; ++i) {
    if (!section.is_closed(i, false)) continue;
    if (last >= 0) {
      const dvec2 a = corner(last), b = corner(i);
      const double area = b.x * a.y - a.x * b.y;  // from the back to the left
      twice += area, sum += area / 3 * (a + b);
    }
    last = i, ++closed;
  }
  constexpr double k_least = 40, k_most = 900;  // mm2: less is no canal of a spine, nor is more
  if (closed < k_rays * 8 / 10 || twice < 2 * k_least || twice > 2 * k_most) return false;
  middle = sum / twice;
  return true;
}

/// mm from the middle of the canal to the wall before it, in the middle of the vertebra.
double front_of(const VertebraFrame& frame, const Walls& walls) {
  constexpr int k_beside = 20 * k_rays / 360;
  std::vector<double> found;
  for (const double z : {-4.0, 0.0, 4.0}) {
    const CanalSection section = section_at(frame, z, walls, nullptr);
    for (int ray = -k_beside; ray <= k_beside; ++ray)
      if (const double r = section.before[static_cast<std::size_t>(around(k_rays / 2 + ray))]; r >= 0)
        found.push_back(r);
  }
  if (found.empty()) return 0.5 * k_reach;
  const auto middle = found.begin() + static_cast<std::ptrdiff_t>(found.size() / 2);
  std::nth_element(found.begin(), middle, found.end());
  return *middle;
}

/// Lean of the middles of the body's cuts across, mm to the left and to the back a mm up; 0 where there is
/// too little of a body. Its ends are left out: where they are not at right angles they would bias it.
dvec2 lean_of(const VertebraFrame& frame, const std::vector<dvec3>& places, double front) {
  constexpr double k_spared = 0.2;  // of its height at either end
  constexpr double k_behind = 4;    // mm, where pedicles begin
  std::vector<dvec3> body;
  for (const dvec3& p : places)
    if (const dvec3 q = frame.local(p); q.y < -front - k_behind) body.push_back(q);
  if (body.size() < 20) return dvec2(0);
  std::vector<double> heights;
  for (const dvec3& q : body) heights.push_back(q.z);
  std::sort(heights.begin(), heights.end());
  const auto at = [&](double share) {
    return heights[static_cast<std::size_t>(share * static_cast<double>(heights.size() - 1))];
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

/// Puts the middle into that of the canal's sections, and turns the frame as the vertebra's body lies.
bool align(const Walls& walls, const std::vector<dvec3>& places, VertebraFrame& frame) {
  constexpr double k_half = 10, k_step = 2;  // mm of canal
  constexpr double k_steepest = 0.82;        // cosine of 35 degrees, about
  constexpr int k_rounds = 6;
  const dvec3 upright = frame.up;
  for (int round = 0; round < k_rounds; ++round) {
    dvec2 sum(0);
    int count = 0;
    for (double z = -k_half; z <= k_half; z += k_step)
      if (dvec2 middle; middle_of(section_at(frame, z, walls, nullptr), middle)) sum += middle, ++count;
    if (count == 0) return false;
    const dvec2 middle = sum / static_cast<double>(count);
    frame.middle = frame.world({middle.x, middle.y, 0});
    if (places.empty()) continue;
    const double front = front_of(frame, walls);
    const dvec2 lean = lean_of(frame, places, front);
    const dvec3 up = glm::normalize(frame.up + lean.x * frame.left + lean.y * frame.back);
    if (glm::dot(up, upright) > k_steepest) frame.up = up;
    dvec3 body(0);
    for (const dvec3& p : places)
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

dvec2 ray_direction(int ray) noexcept { return directions()[static_cast<std::size_t>(around(ray))]; }

bool CanalSection::is_closed(int ray, bool of_after) const noexcept {
  return (of_after ? after : before)[static_cast<std::size_t>(around(ray))] >= 0;
}

bool CanalSection::has_roof(bool of_after) const noexcept {
  for (int ray = -k_roof; ray <= k_roof; ++ray)
    if (!is_closed(ray, of_after) || !is_own[static_cast<std::size_t>(around(ray))]) return false;
  return true;
}

double CanalSection::area(bool of_after) const noexcept {
  // Along each ray as far as the wall, or the line across an opening.
  const auto reaches = [this](bool is_after, std::array<double, k_rays>& out) {
    const std::vector<double>& wall = is_after ? after : before;
    int first = 0, closed = 0;
    for (int i = 0; i < k_rays; ++i) closed += is_closed(i, is_after);
    if (2 * closed < k_rays) return false;
    while (!is_closed(first, is_after)) ++first;
    for (int i = first; i < first + k_rays;) {
      int next = i + 1;
      while (!is_closed(next, is_after)) ++next;
      const auto at = [](int ray) { return static_cast<std::size_t>(around(ray)); };
      out[at(i)] = wall[at(i)];
      const dvec2 a = wall[at(i)] * ray_direction(i), b = wall[at(next)] * ray_direction(next), side = b - a;
      for (int ray = i + 1; ray < next; ++ray) {
        // a + s side = r to: crossed with the side, only r is left.
        const dvec2 to = ray_direction(ray);
        const double across = to.x * side.y - to.y * side.x, twice = a.x * side.y - a.y * side.x;
        out[at(ray)] = across != 0 ? std::clamp(twice / across, 0.0, k_reach) : 0.0;
      }
      i = next;
    }
    return true;
  };
  std::array<double, k_rays> was, is;
  if (!reaches(false, was)) return -1;
  if (!of_after)
    is = was;
  else if (!reaches(true, is))
    return -1;
  double twice = 0;
  for (std::size_t i = 0; i < k_rays; ++i) {
    const double r = std::max(was[i], is[i]);
    twice += r * r;
  }
  return 0.5 * twice * (2 * 3.14159265358979323846 / k_rays);
}

double CanalSection::opening() const noexcept {
  // The widest of those that were closed before.
  double widest = 0;
  for (int ray = -k_roof; ray <= k_roof; ++ray) {
    if (is_closed(ray, true) || !is_closed(ray, false)) continue;
    int one = ray, other = ray;
    while (one > ray - k_rays / 2 && !is_closed(one, true)) --one;
    while (other < ray + k_rays / 2 && !is_closed(other, true)) ++other;
    if (!is_closed(one, true) || !is_closed(other, true)) continue;
    const dvec2 a = after[static_cast<std::size_t>(around(one))] * ray_direction(one),
                b = after[static_cast<std::size_t>(around(other))] * ray_direction(other);
    widest = std::max(widest, glm::length(b - a));
  }
  return widest;
}

CanalSection section_at(const VertebraFrame& frame, double z, const Walls& walls,
                        const volume::Version* version) {
  constexpr double k_pores = 4;   // mm without bone: farther on it is another wall
  constexpr double k_before = 3;  // mm: bone so far before the vertebra's own is not its blurred edge
  constexpr double k_wall = 10;   // mm: what stands farther behind the canal is no wall of it any more
  const std::vector<double> none(k_rays, -1);
  CanalSection section{z, none, none, none, std::vector<char>(k_rays, walls.label < 0)};
  const dvec3 from = frame.world({0, 0, z});
  const volume::Volume& scan = walls.bone.volume();
  const volume::Field own(scan, {"vertebra", 0, 0, walls.label});
  const double step = finest(walls.bone);
  for (int i = 0; i < k_rays; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const dvec2 to = ray_direction(i);
    const dvec3 along = to.x * frame.left + to.y * frame.back;
    const auto first_hit = [&](const Line& line) {
      for (double t = 0; t <= k_reach; t += step)
        if (line.is_bone(t)) return t > 0 ? line.crossing(t - step, t) : 0.0;
      return -1.0;
    };
    const Line bone(from, along, walls.bone, nullptr);
    double hit = first_hit(bone);
    const volume::Field* field = &walls.bone;
    section.before[at] = hit < 0 ? -1 : bone.half_way(hit, step);
    if (walls.label >= 0)
      if (const double of_own = first_hit(Line(from, along, own, nullptr));
          of_own >= 0 && (hit < 0 || section.before[at] > of_own - k_before))
        hit = section.before[at] = of_own, field = &own, section.is_own[at] = 1;
    if (hit < 0) continue;
    const Line was(from, along, *field, nullptr);
    double last = hit;
    for (double t = hit + step; t <= std::min(last + k_pores, 2 * k_reach); t += step)
      if (was.is_bone(t)) last = t;
    section.wall_end[at] = last + step;
    section.after[at] = section.before[at];
    if (version == nullptr || version->is_untouched()) continue;
    const Line is(from, along, *field, version);
    double now = -1;
    for (double t = hit + 1e-3; t <= std::min(section.wall_end[at], hit + k_wall) && now < 0; t += step)
      if (is.is_bone(t)) now = t;
    if (now < 0)
      section.after[at] = -1;
    else if (now > hit + step)
      section.after[at] = std::max(section.before[at], is.crossing(now - step, now));
  }
  return section;
}

bool find_vertebra(const Walls& walls, const dvec3* canal_world, VertebraFrame& frame, Trouble& trouble) {
  const volume::Volume& scan = walls.bone.volume();
  const int label = walls.label;
  frame = {};
  const std::vector<dvec3> places = label >= 0 ? places_of(scan, label) : std::vector<dvec3>();
  if (label >= 0 && places.empty()) {
    trouble = {"the vertebra has no voxels", {}};
    return false;
  }
  if (canal_world) {
    frame.middle = *canal_world;
  } else if (label < 0) {
    trouble = {"without a vertebra's label a place in its canal must be named", {}};
    return false;
  } else if (!find_hole(scan, label, places, frame.middle)) {
    trouble = {"the vertebra's label closes around no canal: name a place in it", places[places.size() / 2]};
    return false;
  }
  if (!align(walls, places, frame)) {
    trouble = {"there is no canal with bone around it", frame.middle};
    return false;
  }
  if (places.empty()) return true;
  std::vector<double> heights;
  for (const dvec3& p : places) heights.push_back(glm::dot(p - frame.middle, frame.up));
  std::sort(heights.begin(), heights.end());
  frame.low = heights.front(), frame.high = heights.back();
  return true;
}

}  // namespace trephine::laminectomy
