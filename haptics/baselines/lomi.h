// find_rest(): finds the proxy by look-ups of single points in depth images. This is the local occupancy map
// instance (LOMI) of Kim et al. 2009, reproduced with its faults as a baseline.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

namespace trephine::haptics::baselines {

struct LomiOptions {
  double resolution = 0.2;   ///< mm, of a voxel, and of the search along the motion
  int voxels = 11;           ///< along an edge of the map; odd
  int levels = 4;            ///< number of times that the proxy's voxel is divided into 27 parts
  bool is_physical = false;  ///< the whole map is filled first, two bits per voxel
};

/// Position of the HIP relative to matter on the motion: the published cases 1 to 3.
enum class HipCase : std::uint8_t {
  stays_inside,      ///< 1: the motion ends in matter
  moves_out,         ///< 2: nothing was met; no force
  passes_thin_part,  ///< 3: the motion ends in free space behind matter; the first collision counts
};

/// Result and cost of a search.
struct LomiRest {
  glm::dvec3 before{0.0};    ///< mm, the temporary position: the last free position of the motion
  glm::dvec3 position{0.0};  ///< mm, the final position
  HipCase hip_case = HipCase::moves_out;
  int queries = 0;  ///< collision queries
  int stored = 0;   ///< voxels in memory

  bool is_blocked() const noexcept { return hip_case != HipCase::moves_out; }
};

// `inside(p)` returns true if p (mm) is in matter, by the nearest pixels or smoothly between them. No
// function here allocates.

inline constexpr int k_max_steps =
    4096;                                ///< queries along a motion; a longer motion is sampled more coarsely
inline constexpr int k_max_voxels = 31;  ///< along an edge of the map

/// Finds the last free position of a motion in steps of the resolution. Returns false if all of it is free.
template <class Inside>
bool preliminary_collision(const glm::dvec3& from, const glm::dvec3& hip, double resolution,
                           const Inside& inside, LomiRest& rest) noexcept {
  const double length = glm::length(hip - from);
  const int steps = static_cast<int>(std::clamp(std::ceil(length / resolution), 1.0, 1.0 * k_max_steps));
  rest.before = from;
  for (int i = 1; i <= steps; ++i) {
    const glm::dvec3 p = from + (static_cast<double>(i) / steps) * (hip - from);
    ++rest.queries;
    if (inside(p)) return true;
    rest.before = p;
  }
  return false;
}

/// Walks through free voxels of the map: from each voxel to its free neighbour (of 26) that is nearest to the
/// HIP, until no neighbour is nearer than the voxel itself. No voxel is queried twice, and no result is
/// stored: the walk skips the neighbours of earlier voxels, which were queried at those voxels.
template <class Inside>
glm::dvec3 walk_abstract_lomi(const glm::dvec3& middle, const glm::dvec3& hip, const LomiOptions& options,
                              const Inside& inside, LomiRest& rest) noexcept {
  const int reach = options.voxels / 2;
  std::array<glm::ivec3, 2 * k_max_voxels> visited;
  int count = 0;
  const auto position_of = [&](const glm::ivec3& v) { return middle + options.resolution * glm::dvec3(v); };
  const auto is_queried = [&](const glm::ivec3& v, int visited_count) {
    for (int k = 0; k < visited_count; ++k) {
      const glm::ivec3 off = glm::abs(v - visited[static_cast<std::size_t>(k)]);
      if (off.x <= 1 && off.y <= 1 && off.z <= 1) return true;
    }
    return false;
  };
  glm::ivec3 current(0);
  double nearest = glm::distance(middle, hip);
  while (count < static_cast<int>(visited.size())) {
    visited[static_cast<std::size_t>(count++)] = current;
    glm::ivec3 best = current;
    for (int z = -1; z <= 1; ++z)
      for (int y = -1; y <= 1; ++y)
        for (int x = -1; x <= 1; ++x) {
          const glm::ivec3 v = current + glm::ivec3(x, y, z);
          const glm::ivec3 off = glm::abs(v);
          if (v == current || off.x > reach || off.y > reach || off.z > reach || is_queried(v, count - 1))
            continue;
          ++rest.queries;
          if (inside(position_of(v))) continue;
          if (const double d = glm::distance(position_of(v), hip); d < nearest) nearest = d, best = v;
        }
    if (best == current) break;
    current = best;
  }
  return position_of(current);
}

/// Returns the free voxel of the whole map that is nearest to the HIP. All voxels are queried and stored
/// first. A free voxel behind a thin wall counts as well.
template <class Inside>
glm::dvec3 search_physical_lomi(const glm::dvec3& middle, const glm::dvec3& hip, const LomiOptions& options,
                                const Inside& inside, LomiRest& rest) noexcept {
  enum Type : std::uint8_t { free_space, surface, interior };
  constexpr std::size_t k_cells = static_cast<std::size_t>(k_max_voxels) * k_max_voxels * k_max_voxels;
  std::array<std::uint8_t, (k_cells + 3) / 4> map;  // two bits per voxel
  const int n = options.voxels, reach = n / 2;
  const auto index = [n](int x, int y, int z) { return static_cast<std::size_t>(x + n * (y + n * z)); };
  const auto type = [&](std::size_t i) { return (map[i / 4] >> (2 * (i % 4))) & 3; };
  const auto set = [&](std::size_t i, Type t) {
    map[i / 4] = static_cast<std::uint8_t>((map[i / 4] & ~(3 << (2 * (i % 4)))) | (t << (2 * (i % 4))));
  };
  const auto position_of = [&](int x, int y, int z) {
    return middle + options.resolution * glm::dvec3(x - reach, y - reach, z - reach);
  };
  for (int z = 0; z < n; ++z)
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x) {
        ++rest.queries, ++rest.stored;
        set(index(x, y, z), inside(position_of(x, y, z)) ? interior : free_space);
      }
  // Marks matter next to free space as surface.
  for (int z = 0; z < n; ++z)
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x) {
        if (type(index(x, y, z)) != interior) continue;
        const bool is_surface = (x > 0 && type(index(x - 1, y, z)) == free_space) ||
                                (x + 1 < n && type(index(x + 1, y, z)) == free_space) ||
                                (y > 0 && type(index(x, y - 1, z)) == free_space) ||
                                (y + 1 < n && type(index(x, y + 1, z)) == free_space) ||
                                (z > 0 && type(index(x, y, z - 1)) == free_space) ||
                                (z + 1 < n && type(index(x, y, z + 1)) == free_space);
        if (is_surface) set(index(x, y, z), surface);
      }
  glm::dvec3 best = middle;
  double nearest = glm::distance(middle, hip);
  for (int z = 0; z < n; ++z)
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x)
        if (type(index(x, y, z)) == free_space)
          if (const double d = glm::distance(position_of(x, y, z), hip); d < nearest)
            nearest = d, best = position_of(x, y, z);
  return best;
}

/// Divides the proxy's voxel into 27 parts, then the free part nearest to the HIP, `levels` times in all.
template <class Inside>
glm::dvec3 sub_voxelize(glm::dvec3 position, const glm::dvec3& hip, double voxel, int levels,
                        const Inside& inside_smoothly, LomiRest& rest) noexcept {
  for (int level = 0; level < levels; ++level) {
    voxel /= 3;
    glm::dvec3 best = position;
    double nearest = 1e300;
    for (int z = -1; z <= 1; ++z)
      for (int y = -1; y <= 1; ++y)
        for (int x = -1; x <= 1; ++x) {
          const glm::dvec3 p = position + voxel * glm::dvec3(x, y, z);
          ++rest.queries;
          if (inside_smoothly(p)) continue;
          if (const double d = glm::distance(p, hip); d < nearest) nearest = d, best = p;
        }
    position = best;
  }
  return position;
}

/// Runs the whole search from `from`, which is free, toward `hip`.
template <class Inside, class InsideSmoothly>
LomiRest find_rest(const glm::dvec3& from, const glm::dvec3& hip, const LomiOptions& options,
                   const Inside& inside, const InsideSmoothly& inside_smoothly) noexcept {
  LomiRest rest;
  rest.position = hip;
  if (!preliminary_collision(from, hip, options.resolution, inside, rest)) return rest;
  ++rest.queries;
  rest.hip_case = inside(hip) ? HipCase::stays_inside : HipCase::passes_thin_part;
  rest.position = options.is_physical ? search_physical_lomi(rest.before, hip, options, inside, rest)
                                      : walk_abstract_lomi(rest.before, hip, options, inside, rest);
  rest.position = sub_voxelize(rest.position, hip, options.resolution, options.levels, inside_smoothly, rest);
  return rest;
}

}  // namespace trephine::haptics::baselines
