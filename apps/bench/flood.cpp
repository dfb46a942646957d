#include "apps/bench/flood.h"

#include <algorithm>
#include <bit>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>
#include <unistd.h>

#include "apps/bench/peers.h"
#include "apps/verify/components.h"
#include "data-tools/phantoms/phantoms.h"

namespace trephine::bench {

namespace {

using Clock = std::chrono::steady_clock;
constexpr short k_low = 300;
constexpr int k_flood_runs = 3;  // the fastest counts

double ms_since(Clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

volume::Volume volume_of(const std::string& name, int size) {
  data_tools::PhantomOptions options;
  options.size = glm::ivec3(size);
  options.spacing_mm = glm::dvec3(120.0 / size);
  if (name != "noise") return data_tools::make_phantom(name, options).value();
  // Random noise: a third of the voxels is solid.
  volume::Volume noise = volume::make_volume(glm::ivec3(size), volume::Frame()).value();
  std::mt19937 random(1);
  for (std::size_t i = 0; i < noise.voxels.size(); ++i)
    noise.voxels[i] = static_cast<std::int16_t>(random() % 3 == 0 ? 1000 : -1000);
  return noise;
}

/// Returns a voxel of the largest part: the first in the rows from the middle of the volume on.
glm::ivec3 seed_of(const verify::Components& parts, int size) {
  const std::vector<std::int64_t>& sizes = parts.sizes();
  const int largest = static_cast<int>(std::max_element(sizes.begin(), sizes.end()) - sizes.begin());
  for (int z = size / 2; z < size; ++z)
    for (int y = size / 2; y < size; ++y)
      for (int x = 0; x < size; ++x)
        if (parts.part_of({x, y, z}) == largest) return {x, y, z};
  return glm::ivec3(0);
}

/// Returns the time (ms) of SciPy's label() of the voxels at `k_low` and above, thresholding included. Sets
/// the number of parts.
std::optional<double> scipy_label(const volume::Volume& v, bool has_corners, long long& count) {
  const std::filesystem::path file =
      std::filesystem::temp_directory_path() / ("trephine-flood-" + std::to_string(::getpid()) + ".raw");
  {
    std::ofstream out(file, std::ios::binary);
    out.write(reinterpret_cast<const char*>(v.voxels.data()),
              static_cast<std::streamsize>(v.voxels.size() * sizeof(std::int16_t)));
  }
  char command[1000];
  std::snprintf(command, sizeof command,
                "/usr/bin/python3 -c \"import numpy as n, scipy.ndimage as s, time\n"
                "v = n.fromfile('%s', n.int16).reshape(%d, %d, %d)\n"
                "b = s.generate_binary_structure(3, %d)\n"
                "t = 1e9\n"
                "for i in range(2):\n"
                "  a = time.perf_counter(); c = s.label(v >= %d, b)[1]; t = min(t, time.perf_counter() - a)\n"
                "print(1000 * t, c)\" 2>/dev/null",
                file.c_str(), v.size.z, v.size.y, v.size.x, has_corners ? 3 : 1, k_low);
  std::optional<double> ms;
  if (FILE* pipe = ::popen(command, "r")) {
    double found = 0;
    if (std::fscanf(pipe, "%lf %lld", &found, &count) == 2) ms = found;
    ::pclose(pipe);
  }
  std::error_code ignored;
  std::filesystem::remove(file, ignored);
  return ms;
}

}  // namespace

std::vector<FloodRow> run_flood_benchmark(int size) {
  std::vector<FloodRow> rows;
  const PeerSet& set = peers();
  for (const char* name : {"shell", "gyroid", "noise"}) {
    const volume::Volume v = volume_of(name, size);
    const volume::Shape shape{"bone", k_low};
    for (const bool has_corners : {false, true})
      for (const int threads : {1, 2}) {
        FloodRow row;
        row.volume = name, row.has_corners = has_corners, row.threads = threads;
        row.components_ms = row.flood_ms = 1e300;
        glm::ivec3 seed(-1);
        for (int run = 0; run < k_flood_runs; ++run) {
          const auto begin = Clock::now();
          const verify::Components parts(v, shape,
                                         has_corners ? verify::Components::Connectivity::corners
                                                     : verify::Components::Connectivity::faces,
                                         threads);
          const double components = ms_since(begin);
          row.components_ms = std::min(row.components_ms, components);
          if (seed.x < 0) seed = seed_of(parts, size);
          const auto flood_begin = Clock::now();
          const std::vector<std::uint64_t> flood = parts.flood(seed);
          row.flood_ms = std::min(row.flood_ms, components + ms_since(flood_begin));
          row.count = static_cast<long long>(parts.count());
          row.flooded = 0;
          for (const std::uint64_t word : flood) row.flooded += std::popcount(word);
        }
        long long theirs = 0;
        if (set.itk_flood && has_corners && threads == 1) {
          row.itk_flood_ms = 1e3 * set.itk_flood(v.voxels.data(), size, k_low, &seed.x, theirs);
          row.is_same = row.is_same && theirs == row.flooded;
        }
        if (set.itk_components) {
          row.itk_components_ms =
              1e3 * set.itk_components(v.voxels.data(), size, k_low, has_corners, threads, theirs);
          row.is_same = row.is_same && theirs == row.count;
        }
        if (threads == 1) {
          row.scipy_ms = scipy_label(v, has_corners, theirs);
          if (row.scipy_ms) row.is_same = row.is_same && theirs == row.count;
        }
        rows.push_back(row);
      }
  }
  return rows;
}

}  // namespace trephine::bench
