#include "modules/bone_flap/outline.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "volume/base/axes.h"
#include "volume/base/deterministic_math.h"

namespace trephine::bone_flap {

using glm::dvec2;
using glm::dvec3;

namespace {

double cross(const dvec2& a, const dvec2& b) { return a.x * b.y - a.y * b.x; }

/// Returns true if two segments intersect or touch.
bool intersects(const dvec2& a, const dvec2& b, const dvec2& c, const dvec2& d) {
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

std::string anchor_name(std::size_t i) { return "anchor " + std::to_string(i + 1); }

/// Checks an outline without the bone: number, spacing and gaps of its anchors.
LocatedStatus check_loop(const std::vector<dvec3>& anchors) {
  const std::size_t n = anchors.size();
  if (n < 3) {
    return LocatedError{"the outline is open: it has " + std::to_string(n) +
                            (n == 1 ? " anchor" : " anchors") + "; at least three are required",
                        n > 0 ? anchors[0] : dvec3(0)};
  }
  double longest = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double length = glm::length(anchors[(i + 1) % n] - anchors[i]);
    if (length < k_anchor_spacing) {
      return LocatedError{
          anchor_name(i) + " and " + anchor_name((i + 1) % n) + " are less than 1 mm apart: remove one",
          anchors[i]};
    }
    if (i + 1 < n) longest = std::max(longest, length);
  }
  // A large gap between the last and the first anchor: the user has not finished the outline.
  constexpr double k_open = 4;
  if (const double gap = glm::length(anchors[n - 1] - anchors[0]); n > 4 && gap > k_open * longest) {
    return LocatedError{"the outline is open: its ends are " + rounded(gap) +
                            " mm apart, and its other anchors at most " + rounded(longest) + " mm",
                        0.5 * (anchors[0] + anchors[n - 1])};
  }
  return std::nullopt;
}

}  // namespace

std::string rounded(double value) { return std::to_string(std::lround(value)); }
std::string tenths(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f", value);
  return text;
}

dvec2 Pyramid::project(const dvec3& p_world, bool& is_ahead) const noexcept {
  const dvec3 w = p_world - apex_world;
  const double far = glm::dot(w, normal_world);
  is_ahead = far > 1e-6;
  return dvec2(glm::dot(w, right_world), glm::dot(w, up_world)) / std::max(far, 1e-6);
}

bool Pyramid::contains(const dvec3& p_world) const noexcept {
  bool is_ahead = false;
  const dvec2 p = project(p_world, is_ahead);
  return is_ahead && is_within(plan, p);
}

void set_orthogonal_axes(const dvec3& normal, dvec3& right, dvec3& up) noexcept {
  right = glm::normalize(glm::cross(volume::non_parallel_axis(normal), normal));
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

bool outward(const volume::Field& bone, const dvec3& p_world, dvec3& normal_world) {
  constexpr int k_steps = 8;  // along a radius
  const volume::Frame& frame = bone.volume().frame;
  dvec3 sum(0);
  for (int z = -k_steps; z <= k_steps; ++z)
    for (int y = -k_steps; y <= k_steps; ++y)
      for (int x = -k_steps; x <= k_steps; ++x) {
        const dvec3 offset = k_anchor_reach / k_steps * dvec3(x, y, z);
        if (glm::dot(offset, offset) > k_anchor_reach * k_anchor_reach) continue;
        if (bone.value(frame.volume_from_world(p_world + offset)) >= 0) sum -= offset;
      }
  const double length = glm::length(sum);
  normal_world = length > 0 ? sum / length : dvec3(0);
  if (length == 0) return false;
  // At a point on the inner table, the direction found points into the head, to the other side of the skull.
  const auto bone_beyond = [&](const dvec3& direction) {
    double thickness = 0;
    for (const Run& run : runs_along(bone, p_world, direction, 20, 250, 0)) thickness += run.high - run.low;
    return thickness;
  };
  if (bone_beyond(normal_world) > bone_beyond(-normal_world)) normal_world = -normal_world;
  return true;
}

std::vector<dvec3> ring_of(const volume::Field& bone, const dvec3& at_world, double diameter, int count) {
  constexpr double k_reach = 30, k_depth = 60;  // mm: search radius, and start of the rays below the surface
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
        const dvec3 p = scan.frame.world_from_volume(dvec3(x, y, z)), offset = p - at_world;
        if (glm::dot(offset, offset) < least) least = glm::dot(offset, offset), middle = p, is_found = true;
      }
  dvec3 normal;
  if (!is_found || !outward(bone, middle, normal)) return {};
  dvec3 right, up;
  set_orthogonal_axes(normal, right, up);
  // mm by which the surface of a sphere of 75 mm radius, about that of a skull, falls from the centre to the
  // ring.
  const double drop = diameter * diameter / (8 * 75.0);
  std::vector<dvec3> ring;
  for (int i = 0; i < count; ++i) {
    const double angle = 6.283185307179586 * i / count;
    const dvec2 direction(deterministic_cos(angle), deterministic_sin(angle));
    const dvec3 start = middle + 0.5 * diameter * (direction.x * right + direction.y * up) - k_depth * normal;
    const std::vector<Run> runs = runs_along(bone, start, normal, 0, k_depth + k_reach, 0);
    const Run* run = nearest_run(runs, k_depth - drop, k_depth);
    ring.push_back(start + (run ? run->high : k_depth - drop) * normal);
  }
  return ring;
}

Result<Pyramid, LocatedError> make_pyramid(const std::vector<dvec3>& anchors_world, double distance,
                                           const volume::Field& bone) {
  if (auto error = check_loop(anchors_world)) return *std::move(error);
  Pyramid result;
  result.anchors_world = anchors_world;
  const std::size_t n = result.size();
  dvec3 normal_sum(0);
  double weights = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const dvec3& at = result.anchor(i);
    dvec3 normal;
    if (!outward(bone, at, normal)) {
      return LocatedError{
          anchor_name(i) + " lies off the bone: no bone within " + rounded(k_anchor_reach) + " mm", at};
    }
    const double weight =
        0.5 * (glm::length(at - result.anchor(i + n - 1)) + glm::length(result.anchor(i + 1) - at));
    result.centre_world += weight * at;
    normal_sum += weight * normal;
    weights += weight;
  }
  result.centre_world /= weights;
  // Normals in all directions cancel.
  if (glm::length(normal_sum) < 0.2 * weights) {
    return LocatedError{"the outline encircles the head: its normals point in all directions",
                        result.centre_world};
  }
  result.normal_world = glm::normalize(normal_sum);
  set_orthogonal_axes(result.normal_world, result.right_world, result.up_world);
  result.apex_world = result.centre_world - distance * result.normal_world;
  for (std::size_t i = 0; i < n; ++i) {
    bool is_ahead = false;
    result.plan.push_back(result.project(result.anchor(i), is_ahead));
    const dvec3 w = result.anchor(i) - result.apex_world;
    if (glm::dot(w, result.normal_world) < 0.2 * glm::length(w)) {
      return LocatedError{anchor_name(i) + " lies level with the apex or behind it", result.anchor(i)};
    }
  }
  double twice_area = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const dvec2 &before = result.plan[(i + n - 1) % n], &at = result.plan[i],
                &after = result.plan[(i + 1) % n];
    twice_area += cross(at, after);
    const dvec2 incoming = at - before, outgoing = after - at;
    if (glm::length(outgoing) * distance > 0.5 &&
        glm::dot(incoming, outgoing) >= -0.9999 * glm::length(incoming) * glm::length(outgoing))
      continue;
    return LocatedError{"the outline reverses its direction at " + anchor_name(i), result.anchor(i)};
  }
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 2; j < n; ++j) {
      if (i == 0 && j == n - 1) continue;
      if (!intersects(result.plan[i], result.plan[i + 1], result.plan[j], result.plan[(j + 1) % n])) continue;
      return LocatedError{"the outline crosses itself: " + anchor_name(i) + " to " + std::to_string(i + 2) +
                              " and " + std::to_string(j + 1) + " to " + std::to_string((j + 1) % n + 1),
                          0.5 * (result.anchor(i) + result.anchor(i + 1))};
    }
  constexpr double k_min_mm2 = 30;
  if (0.5 * std::abs(twice_area) * distance * distance < k_min_mm2) {
    return LocatedError{"the outline encloses almost no area", result.centre_world};
  }
  return result;
}

}  // namespace trephine::bone_flap
