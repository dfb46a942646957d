#include "apps/bench/rays.h"

#include <glm/geometric.hpp>

#include "apps/bench/measure.h"
#include "apps/bench/peers.h"
#include "apps/bench/scenes/scenes.h"
#include "apps/verify/exact_traversal.h"
#include "volume/base/deterministic_math.h"
#include "volume/cuts/rays.h"

namespace trephine::bench {

using glm::dvec3;

namespace {

constexpr int k_count = 65536, k_side = 256;
constexpr std::size_t k_judge_every = 16;  // rays

std::vector<volume::Ray> random_rays(const dvec3& size) {
  std::uint64_t n = 0;
  const auto uniform = [&n] { return static_cast<double>(hash_bits(++n) >> 11) * 0x1p-53; };
  const auto point = [&uniform] {
    const double x = uniform(), y = uniform(), z = uniform();
    return dvec3(x, y, z);
  };
  std::vector<volume::Ray> rays;
  while (rays.size() < k_count) {
    const dvec3 direction = glm::normalize(point() - 0.5), middle = size * (0.5 + 0.3 * (point() - 0.5));
    rays.push_back({middle - 0.9 * size.x * direction, middle + 0.9 * size.x * direction});
  }
  return rays;
}

/// Rays through a camera position, row by row of the picture.
std::vector<volume::Ray> image_rays(const dvec3& size) {
  std::vector<volume::Ray> rays;
  const dvec3 camera_position = size * dvec3(0.53, -0.9, 0.61);
  for (int y = 0; y < k_side; ++y)
    for (int x = 0; x < k_side; ++x) {
      const dvec3 through = size * dvec3(0.1 + 0.8 * (x + 0.5) / k_side, 0.5, 0.1 + 0.8 * (y + 0.5) / k_side);
      rays.push_back({camera_position, camera_position + 2.0 * (through - camera_position)});
    }
  return rays;
}

}  // namespace

std::vector<RayRow> run_ray_benchmark(int size) {
  std::vector<RayRow> rows;
  const PeerSet& set = peers();
  for (const char* name : {"sphere", "gyroid", "shell"}) {
    data_tools::PhantomOptions o;
    o.size = glm::ivec3(size);
    o.psf_sigma_voxels = 1;
    const haptics::TouchScene scene = scenes::phantom_scene(name, o);
    const volume::Occupancy& bits = *scene.items[0].bits;
    const int extent[3] = {bits.size().x, bits.size().y, bits.size().z};
    NanoGrid* grid = set.make_nano_grid
                         ? set.make_nano_grid(reinterpret_cast<const unsigned long long*>(bits.row(0, 0)),
                                              bits.words_per_row(), extent)
                         : nullptr;
    for (const bool is_image : {false, true}) {
      const std::vector<volume::Ray> rays =
          is_image ? image_rays(dvec3(bits.size())) : random_rays(dvec3(bits.size()));
      RayRow row{name, is_image ? "image" : "random", size, static_cast<long>(rays.size())};
      std::vector<volume::RayHit> one(rays.size());
      std::vector<double> flat;
      for (const volume::Ray& r : rays)
        for (const dvec3* p : {&r.start, &r.end})
          for (int a = 0; a < 3; ++a) flat.push_back((*p)[a]);
      std::vector<int> theirs(3 * rays.size());
      row.ns_per_ray = row.peer_ns = 1e300;
      const double ns = 1e9 / static_cast<double>(rays.size());
      for (int run = 0; run < 5; ++run) {
        const auto start = Clock::now();
        for (std::size_t i = 0; i < rays.size(); ++i) one[i] = volume::first_hit(bits, rays[i]);
        row.ns_per_ray = std::min(row.ns_per_ray, ns * seconds_since(start));
        if (grid)
          row.peer_ns =
              std::min(row.peer_ns, ns * set.run_nano_rays(*grid, flat.data(), static_cast<int>(rays.size()),
                                                           theirs.data(), 1e-3f));
      }
      if (!grid) row.peer_ns = 0;
      for (std::size_t i = 0; i < rays.size(); ++i) {
        row.hits += one[i].is_hit;
        if (i % k_judge_every == 0) {
          const volume::Ray& r = rays[i];
          const auto exact =
              verify::first_solid({r.start.x, r.start.y, r.start.z}, {r.end.x, r.end.y, r.end.z},
                                  {extent[0], extent[1], extent[2]}, [&bits](int x, int y, int z) {
                                    return bits.is_solid({x, y, z});
                                  });
          ++row.judged;
          row.mismatches += exact.has_value() != one[i].is_hit ||
                            (exact && glm::ivec3((*exact)[0], (*exact)[1], (*exact)[2]) != one[i].voxel);
        }
        if (grid)
          row.peer_differs +=
              one[i].is_hit ? one[i].voxel != glm::ivec3(theirs[3 * i], theirs[3 * i + 1], theirs[3 * i + 2])
                            : theirs[3 * i] >= 0;
      }
      rows.push_back(row);
    }
    if (grid) set.free_nano_grid(grid);
  }
  return rows;
}

}  // namespace trephine::bench
