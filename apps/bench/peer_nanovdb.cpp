// NanoVDB's HDDA (hierarchical ray traversal) with an accessor. This file is C++17 and includes only one
// header of ours, because NanoVDB's grid builder does not compile as C++20.
#include "apps/bench/peer_nanovdb.h"

#include <chrono>
#include <memory>
#include <nanovdb/util/GridBuilder.h>
#include <nanovdb/util/HDDA.h>
#include <nanovdb/util/Ray.h>

namespace trephine::bench {

struct NanoGrid {
  nanovdb::GridHandle<> handle;
};

NanoGrid* make_nano_grid(const unsigned long long* words, int words_per_row, const int size[3]) {
  nanovdb::GridBuilder<float> builder(0.0f);
  const auto row = [&](int y, int z) {
    return words + static_cast<std::size_t>(words_per_row) *
                       (static_cast<std::size_t>(y) +
                        static_cast<std::size_t>(size[1]) * static_cast<std::size_t>(z));
  };
  builder(
      [&](const nanovdb::Coord& c) { return row(c[1], c[2])[c[0] >> 6] >> (c[0] & 63) & 1 ? 1.0f : 0.0f; },
      nanovdb::CoordBBox(nanovdb::Coord(0), nanovdb::Coord(size[0] - 1, size[1] - 1, size[2] - 1)));
  return new NanoGrid{builder.getHandle<>(1.0)};
}

void free_nano_grid(NanoGrid* grid) { delete grid; }

double run_nano_rays(const NanoGrid& grid, const double* rays, int count, int* voxels, float epsilon) {
  using Ray = nanovdb::Ray<float>;
  using Coord = nanovdb::Coord;
  auto accessor = grid.handle.grid<float>()->tree().getAccessor();
  const auto start = std::chrono::steady_clock::now();
  for (int i = 0; i < count; ++i) {
    const double* r = rays + 6 * i;
    // Voxels of NanoVDB are [i, i + 1).
    const nanovdb::Vec3<float> origin(static_cast<float>(r[0] + 0.5), static_cast<float>(r[1] + 0.5),
                                      static_cast<float>(r[2] + 0.5));
    nanovdb::Vec3<float> direction(static_cast<float>(r[3] - r[0]), static_cast<float>(r[4] - r[1]),
                                   static_cast<float>(r[5] - r[2]));
    const float length = direction.length();
    direction /= length;
    Ray ray(origin, direction, 0.0f, length);
    int* voxel = voxels + 3 * i;
    voxel[0] = -1;
    if (!ray.clip(accessor.root().bbox())) continue;
    Coord at = nanovdb::RoundDown<Coord>(ray.start());
    bool is_hit = true;
    for (nanovdb::HDDA<Ray, Coord> hdda(ray, accessor.getDim(at, ray)); !accessor.isActive(at);
         hdda.update(ray, accessor.getDim(at, ray))) {
      if (!hdda.step()) {
        is_hit = false;
        break;
      }
      at = nanovdb::RoundDown<Coord>(ray(hdda.time() + epsilon));
    }
    for (int a = 0; is_hit && a < 3; ++a) voxel[a] = at[a];
  }
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace trephine::bench
