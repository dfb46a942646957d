#include "modules/bone_flap/outline.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "volume/deterministic_math.h"

namespace trephine::bone_flap {

using glm::dvec2;
using glm::dvec3;

namespace {

double cross(const dvec2& a, const dvec2& b) { return a.x * b.y - a.y * b.x; }

/// Do two segments meet? Touching counts.
bool meet(const dvec2& a, const dvec2& b, const dvec2& c, const dvec2& d) {
  const double ab_c = cross(b - a, c - a), ab_d = cross(b - a, d - a), cd_a = cross(d - c, a - c),
               cd_b = cross(d - c, b - c);
  const auto between = [](const dvec2& p, const dvec2& low, const dvec2& high) {
    return std::min(low.x, high.x) <= p.x && p.x <= std::max(low.x, high.x) &&
           std::min(low.y, high.y) <= p.y && p.y <= std::max(low.y, high.y);
  };
  if (((ab_c > 0) != (ab_d > 0)) && ((cd_a > 0) != (cd_b > 0)) && ab_c != 0 && ab_d != 0 && cd_a != 0 &&
      cd_b != 0)
    return true;
  return (ab_c == 0 && between(c, a, b)) || (ab_d == 0 && between(d, a, b)) ||
         (cd_a == 0 && between(a, c, d)) || (cd_b == 0 && between(b, c, d));
}

std::string named(std::size_t i) { return "anchor " + std::to_string(i + 1); }

/// Checks of the anchors alone.
bool check_loop(const std::vector<dvec3>& anchors, Trouble& trouble) {
  const std::size_t n = anchors.size();
  if (n < 3) {
    trouble = {"the outline is open: it has " + std::to_string(n) + (n == 1 ? " anchor" : " anchors") +
                   ", and three make the smallest",
               n > 0 ? anchors[0] : dvec3(0)};
    return false;
  }
  double longest = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double way = glm::length(anchors[(i + 1) % n] - anchors[i]);
    if (way < 1) {
      trouble = {named(i) + " and " + named((i + 1) % n) + " are at the same place", anchors[i]};
      return false;
    }
    if (i + 1 < n) longest = std::max(longest, way);
  }
  // A drawn line: its continuation is unknown.
  constexpr double k_open = 4;
  if (const double gap = glm::length(anchors[n - 1] - anchors[0]); n > 4 && gap > k_open * longest) {
    trouble = {"the outline is open: its ends are " + whole(gap) + " mm apart, and its other anchors " +
                   whole(longest) + " at most",
               0.5 * (anchors[0] + anchors[n - 1])};
    return false;
  }
  return true;
}

}  // namespace

std::string whole(double value) { return std::to_string(std::lround(value)); }
std::string tenths(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f", value);
  return text;
}

dvec2 Pyramid::seen(const dvec3& p_world, bool& is_ahead) const noexcept {
  const dvec3 w = p_world - apex_world;
  const double far = glm::dot(w, normal_world);
  is_ahead = far > 1e-6;
  return dvec2(glm::dot(w, right_world), glm::dot(w, up_world)) / std::max(far, 1e-6);
}

bool Pyramid::contains(const dvec3& p_world) const noexcept {
  bool is_ahead = false;
  const dvec2 p = seen(p_world, is_ahead);
  return is_ahead && is_within(plan, p);
}

void beside(const dvec3& normal, dvec3& right, dvec3& up) noexcept {
  right = glm::normalize(glm::cross(std::abs(normal.x) < 0.6 ? dvec3(1, 0, 0) : dvec3(0, 1, 0), normal));
  up = glm::cross(normal, right);
}

bool is_within(const std::vector<dvec2>& loop, const dvec2& p) noexcept {
  bool is_in = false;
  for (std::size_t i = 0, j = loop.size() - 1; i < loop.size(); j = i++) {
    const dvec2 &a = loop[j], &b = loop[i];
    if ((a.y > p.y) != (b.y > p.y) && p.x < a.x + (b.x - a.x) * (p.y - a.y) / (b.y - a.y)) is_in = !is_in;
  }
  return is_in;
}

std::vector<Run> runs_along(const volume::Field& bone, const dvec3& start_world, const dvec3& along,
                            double t0, double t1, double space, const volume::BoneLabels* labels) {
  const volume::Frame& frame = bone.volume().frame;
  const dvec3& h = frame.spacing();
  const double step = std::min(0.2, 0.5 * std::min({h.x, h.y, h.z}));
  const dvec3 at = frame.volume_from_world(start_world),
              by = frame.volume_from_world(start_world + along) - at;
  const int count = static_cast<int>(std::ceil((t1 - t0) / step));
  const auto is_labelled = [&](double from, double to) {
    if (labels == nullptr || !labels->has_any()) return false;
    for (double t = from; t <= to; t += step)
      if (!labels->contains(at + t * by)) return false;
    return true;
  };
  std::vector<Run> runs;
  double before = -1, t_before = t0;
  for (int i = 0; i <= count; ++i) {
    const double t = t0 + i * step, g = bone.value(at + t * by);
    const double between = (g >= 0) != (before >= 0) && i > 0 && g != before
                               ? t_before + (t - t_before) * (before / (before - g))
                               : t;
    if (g >= 0 && before < 0) {
      if (!runs.empty() && (between - runs.back().high <= space || is_labelled(runs.back().high, between)))
        runs.back().high = t;
      else
        runs.push_back({between, t});
    }
    if (g >= 0) runs.back().high = t;
    if (g < 0 && before >= 0) runs.back().high = between;
    before = g, t_before = t;
  }
  return runs;
}

const Run* nearest(const std::vector<Run>& runs, double t, double reach) {
  const Run* best = nullptr;
  for (const Run& run : runs)
    if (std::abs(run.high - t) <= (best ? std::abs(best->high - t) : reach)) best = &run;
  return best;
}

bool outward(const volume::Field& bone, const dvec3& p_world, dvec3& normal_world) {
  constexpr int k_steps = 8;  // along a radius
  const volume::Frame& frame = bone.volume().frame;
  dvec3 sum(0);
  for (int z = -k_steps; z <= k_steps; ++z)
    for (int y = -k_steps; y <= k_steps; ++y)
      for (int x = -k_steps; x <= k_steps; ++x) {
        const dvec3 off = k_anchor_reach / k_steps * dvec3(x, y, z);
        if (glm::dot(off, off) > k_anchor_reach * k_anchor_reach) continue;
        if (bone.value(frame.volume_from_world(p_world + off)) >= 0) sum -= off;
      }
  const double length = glm::length(sum);
  normal_world = length > 0 ? sum / length : dvec3(0);
  if (length == 0) return false;
  // From the inner table that leads into the head, where its other side is met.
  const auto bone_beyond = [&](const dvec3& way) {
    double found = 0;
    for (const Run& run : runs_along(bone, p_world, way, 20, 250, 0)) found += run.high - run.low;
    return found;
  };
  if (bone_beyond(normal_world) > bone_beyond(-normal_world)) normal_world = -normal_world;
  return true;
}

std::vector<dvec3> ring_of(const volume::Field& bone, const dvec3& at_world, double diameter, int count) {
  constexpr double k_reach = 30, k_aside = 60;
  const volume::Volume& scan = bone.volume();
  const dvec3 at = scan.frame.volume_from_world(at_world);
  const dvec3 reach = k_reach / scan.frame.spacing();
  const glm::ivec3 low = glm::max(glm::ivec3(glm::floor(at - reach)), glm::ivec3(0)),
                   high = glm::min(glm::ivec3(glm::ceil(at + reach)), scan.size - 1);
  double least = k_reach * k_reach;
  dvec3 middle(0);
  bool is_found = false;
  for (int z = low.z; z <= high.z; ++z)
    for (int y = low.y; y <= high.y; ++y)
      for (int x = low.x; x <= high.x; ++x) {
        if (bone.at(x, y, z) < 0) continue;
        const dvec3 p = scan.frame.world_from_volume(dvec3(x, y, z)), way = p - at_world;
        if (glm::dot(way, way) < least) least = glm::dot(way, way), middle = p, is_found = true;
      }
  dvec3 normal;
  if (!is_found || !outward(bone, middle, normal)) return {};
  dvec3 right, up;
  beside(normal, right, up);
  // A skull's radius: how far its surface lies under the middle's.
  const double fall = diameter * diameter / (8 * 75.0);
  std::vector<dvec3> ring;
  for (int i = 0; i < count; ++i) {
    const double angle = 6.283185307179586 * i / count;
    const dvec2 way(volume::deterministic_cos(angle), volume::deterministic_sin(angle));
    const dvec3 start = middle + 0.5 * diameter * (way.x * right + way.y * up) - k_aside * normal;
    const std::vector<Run> runs = runs_along(bone, start, normal, 0, k_aside + k_reach, 0);
    const Run* run = nearest(runs, k_aside - fall, k_aside);
    ring.push_back(start + (run ? run->high : k_aside - fall) * normal);
  }
  return ring;
}

bool make_pyramid(const std::vector<dvec3>& anchors_world, double distance, const volume::Field& bone,
                  Pyramid& made, Trouble& trouble) {
  if (!check_loop(anchors_world, trouble)) return false;
  made = {};
  made.anchors_world = anchors_world;
  const std::size_t n = made.size();
  dvec3 turn(0);
  double weights = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const dvec3& at = made.anchor(i);
    dvec3 normal;
    if (!outward(bone, at, normal)) {
      trouble = {named(i) + " lies off the bone: no bone within " + whole(k_anchor_reach) + " mm", at};
      return false;
    }
    const double weight =
        0.5 * (glm::length(at - made.anchor(i + n - 1)) + glm::length(made.anchor(i + 1) - at));
    made.centre_world += weight * at;
    turn += weight * normal;
    weights += weight;
  }
  made.centre_world /= weights;
  // Normals in all directions cancel.
  if (glm::length(turn) < 0.2 * weights) {
    trouble = {"the outline goes round the head: its normals look to all sides", made.centre_world};
    return false;
  }
  made.normal_world = glm::normalize(turn);
  beside(made.normal_world, made.right_world, made.up_world);
  made.apex_world = made.centre_world - distance * made.normal_world;
  for (std::size_t i = 0; i < n; ++i) {
    bool is_ahead = false;
    made.plan.push_back(made.seen(made.anchor(i), is_ahead));
    const dvec3 w = made.anchor(i) - made.apex_world;
    if (glm::dot(w, made.normal_world) < 0.2 * glm::length(w)) {
      trouble = {named(i) + " lies level with the apex or behind it", made.anchor(i)};
      return false;
    }
  }
  double twice = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const dvec2 &before = made.plan[(i + n - 1) % n], &at = made.plan[i], &after = made.plan[(i + 1) % n];
    twice += cross(at, after);
    const dvec2 in = at - before, out = after - at;
    if (glm::length(out) * distance > 0.5 &&
        glm::dot(in, out) >= -0.9999 * glm::length(in) * glm::length(out))
      continue;
    trouble = {"the outline goes back on itself at " + named(i), made.anchor(i)};
    return false;
  }
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 2; j < n; ++j) {
      if (i == 0 && j == n - 1) continue;
      if (!meet(made.plan[i], made.plan[i + 1], made.plan[j], made.plan[(j + 1) % n])) continue;
      trouble = {"the outline crosses itself: " + named(i) + " to " + std::to_string(i + 2) + " and " +
                     std::to_string(j + 1) + " to " + std::to_string((j + 1) % n + 1),
                 0.5 * (made.anchor(i) + made.anchor(i + 1))};
      return false;
    }
  constexpr double k_least_mm2 = 30;
  if (0.5 * std::abs(twice) * distance * distance < k_least_mm2) {
    trouble = {"the outline encloses next to nothing", made.centre_world};
    return false;
  }
  return true;
}

}  // namespace trephine::bone_flap
