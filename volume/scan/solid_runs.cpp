#include "volume/scan/solid_runs.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "volume/base/axes.h"
#include "volume/base/deterministic_math.h"

namespace trephine::volume {

using glm::dvec3;

namespace {

constexpr double k_diploe = 6;  // mm, largest gap between the tables of one bone

/// Returns the first bone between 0 and `reach` mm; empty if there is no bone.
std::optional<Run> first_run(const Field& bone, const dvec3& from, const dvec3& along, double reach) {
  const std::vector<Run> runs = runs_along(bone, from, along, 0, reach, k_diploe);
  if (runs.empty()) return std::nullopt;
  return runs.front();
}

/// Returns the normal of the outer table around a path, against `along`, from parallel paths on a circle.
dvec3 normal_around(const Field& bone, const dvec3& outer, const dvec3& along) {
  constexpr int k_paths = 12;
  constexpr double k_radius = 8, k_behind = 12, k_rise = 10;  // mm
  const dvec3 non_parallel = non_parallel_axis(along);
  const dvec3 right = glm::normalize(glm::cross(along, non_parallel)), up = glm::cross(right, along);
  std::array<dvec3, k_paths> ring;
  for (int i = 0; i < k_paths; ++i) {
    const double angle = 6.283185307179586 * i / k_paths;
    const dvec3 at = outer + k_radius * (deterministic_cos(angle) * right + deterministic_sin(angle) * up);
    const auto run = first_run(bone, at - k_behind * along, along, k_behind + k_rise);
    ring[static_cast<std::size_t>(i)] = at + (run ? run->low - k_behind : 0.0) * along;
  }
  // Area vector of the ring (Newell's method).
  dvec3 sum(0);
  for (std::size_t i = 0; i < ring.size(); ++i)
    sum += glm::cross(ring[i] - outer, ring[(i + 1) % ring.size()] - outer);
  const double length = glm::length(sum);
  if (!(length > 0)) return -along;
  return (glm::dot(sum, along) > 0 ? -1.0 : 1.0) / length * sum;
}

}  // namespace

std::vector<Run> runs_along(const Field& bone, const dvec3& start_world, const dvec3& along, double t0,
                            double t1, double space, const BoneLabels* labels) {
  const Frame& frame = bone.volume().frame;
  const dvec3& h = frame.spacing();
  const double step = std::min(0.2, 0.5 * std::min({h.x, h.y, h.z}));
  const dvec3 start = frame.volume_from_world(start_world),
              direction = frame.volume_from_world(start_world + along) - start;
  const int count = static_cast<int>(std::ceil((t1 - t0) / step));
  const auto is_labelled = [&](double from, double to) {
    if (labels == nullptr || !labels->has_any()) return false;
    for (double t = from; t <= to; t += step)
      if (!labels->contains(start + t * direction)) return false;
    return true;
  };
  std::vector<Run> runs;
  double previous = -1, t_previous = t0;
  for (int i = 0; i <= count; ++i) {
    const double t = t0 + i * step, g = bone.value(start + t * direction);
    const double crossing = (g >= 0) != (previous >= 0) && i > 0 && g != previous
                                ? t_previous + (t - t_previous) * (previous / (previous - g))
                                : t;
    if (g >= 0 && previous < 0) {
      if (!runs.empty() && (crossing - runs.back().high <= space || is_labelled(runs.back().high, crossing)))
        runs.back().high = t;
      else
        runs.push_back({crossing, t});
    }
    if (g >= 0) runs.back().high = t;
    if (g < 0 && previous >= 0) runs.back().high = crossing;
    previous = g, t_previous = t;
  }
  return runs;
}

const Run* nearest_run(const std::vector<Run>& runs, double t, double reach) {
  const Run* best = nullptr;
  for (const Run& run : runs)
    if (std::abs(run.high - t) <= (best ? std::abs(best->high - t) : reach)) best = &run;
  return best;
}

std::optional<SkullCrossing> skull_crossing(const Field& bone, const dvec3& from_world, const dvec3& along,
                                            double reach) {
  const auto run = first_run(bone, from_world, along, reach);
  if (!run) return std::nullopt;
  SkullCrossing result;
  result.outer_world = from_world + run->low * along;
  result.inner_world = from_world + run->high * along;
  result.thickness = run->high - run->low;
  result.normal_world = normal_around(bone, result.outer_world, along);
  return result;
}

}  // namespace trephine::volume
