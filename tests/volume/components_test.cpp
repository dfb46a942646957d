#include "apps/verify/components.h"

#include <cmath>
#include <deque>
#include <functional>
#include <gtest/gtest.h>
#include <random>

namespace trephine::volume {
namespace {

Volume volume_of(const glm::ivec3& size, const std::function<bool(const glm::ivec3&)>& is_solid) {
  Volume v = make_volume(size, Frame()).value();
  for (int z = 0; z < size.z; ++z)
    for (int y = 0; y < size.y; ++y)
      for (int x = 0; x < size.x; ++x)
        v.voxels[v.index(x, y, z)] = static_cast<std::int16_t>(is_solid({x, y, z}) ? 1000 : -1000);
  return v;
}

/// Labels parts voxel by voxel with a queue; part numbers follow the order of first voxels.
std::vector<int> by_queue(const Volume& v, bool has_corners) {
  std::vector<int> part(v.voxels.size(), -2);
  int next = 0;
  for (std::size_t i = 0; i < part.size(); ++i) {
    if (part[i] != -2) continue;
    if (v.voxels[i] < 300) {
      part[i] = -1;
      continue;
    }
    std::deque<glm::ivec3> waiting;
    const auto place = [&](std::size_t at) {
      const int x = static_cast<int>(at) % v.size.x, y = static_cast<int>(at) / v.size.x % v.size.y;
      return glm::ivec3(x, y, static_cast<int>(at) / (v.size.x * v.size.y));
    };
    waiting.push_back(place(i));
    part[i] = next;
    while (!waiting.empty()) {
      const glm::ivec3 at = waiting.front();
      waiting.pop_front();
      for (int n = 0; n < 27; ++n) {
        const glm::ivec3 step(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1), to = at + step;
        const int far = std::abs(step.x) + std::abs(step.y) + std::abs(step.z);
        if (far == 0 || (!has_corners && far > 1) || !v.contains(to)) continue;
        const std::size_t index = v.index(to.x, to.y, to.z);
        if (part[index] != -2 || v.voxels[index] < 300) continue;
        part[index] = next;
        waiting.push_back(to);
      }
    }
    ++next;
  }
  return part;
}

TEST(Components, EqualVoxelwiseQueueFlood) {
  std::mt19937 random(5);
  const auto noise = [&random](double share) {
    return
        [&random, share](const glm::ivec3&) { return static_cast<double>(random()) < share * 4294967296.0; };
  };
  const auto gyroid = [](const glm::ivec3& v) {
    const glm::dvec3 p = 0.35 * glm::dvec3(v);
    return std::sin(p.x) * std::cos(p.y) + std::sin(p.y) * std::cos(p.z) + std::sin(p.z) * std::cos(p.x) >
           0.9;
  };
  std::vector<Volume> volumes;
  for (const glm::ivec3& size : {glm::ivec3(70, 23, 37), glm::ivec3(64, 9, 16), glm::ivec3(130, 5, 18),
                                 glm::ivec3(1, 40, 33), glm::ivec3(63, 1, 1)}) {
    for (const double share : {0.02, 0.1, 0.3, 0.5, 0.9}) volumes.push_back(volume_of(size, noise(share)));
    volumes.push_back(volume_of(size, gyroid));
    volumes.push_back(volume_of(size, [](const glm::ivec3&) { return false; }));
    volumes.push_back(volume_of(size, [](const glm::ivec3&) { return true; }));
    // Voxels that touch others only at edges, and only at corners.
    volumes.push_back(volume_of(size, [](const glm::ivec3& v) { return (v.x + v.y + v.z) % 2 == 0; }));
    volumes.push_back(volume_of(
        size, [](const glm::ivec3& v) { return v.x % 2 == v.y % 2 && v.y % 2 == v.z % 2 && v.x % 3 != 2; }));
  }
  std::size_t compared = 0, differing = 0;
  for (const Volume& v : volumes) {
    const Occupancy bits = Occupancy::build(v, Shape{"bone", 300});
    std::vector<int> parts[2];
    for (const bool has_corners : {false, true}) {
      const std::vector<int> expected = parts[has_corners] = by_queue(v, has_corners);
      for (const int threads : {1, 3}) {
        const verify::Components found(
            bits,
            has_corners ? verify::Components::Connectivity::corners : verify::Components::Connectivity::faces,
            threads);
        const verify::Components from_voxels(
            v, Shape{"bone", 300},
            has_corners ? verify::Components::Connectivity::corners : verify::Components::Connectivity::faces,
            threads);
        EXPECT_EQ(from_voxels.sizes(), found.sizes());
        std::vector<std::int64_t> sizes(found.count(), 0);
        for (std::size_t i = 0; i < expected.size(); ++i) {
          const glm::ivec3 at(static_cast<int>(i) % v.size.x, static_cast<int>(i) / v.size.x % v.size.y,
                              static_cast<int>(i) / (v.size.x * v.size.y));
          ASSERT_EQ(found.part_of(at), expected[i]);
          if (expected[i] >= 0) ++sizes[static_cast<std::size_t>(expected[i])];
          ++compared;
        }
        EXPECT_EQ(found.sizes(), sizes);
        // A flood from a voxel returns the part of that voxel.
        if (threads == 1 && found.count() > 0) {
          const auto seed = static_cast<std::size_t>(random() % expected.size());
          const glm::ivec3 at(static_cast<int>(seed) % v.size.x, static_cast<int>(seed) / v.size.x % v.size.y,
                              static_cast<int>(seed) / (v.size.x * v.size.y));
          const std::vector<std::uint64_t> flood = found.flood(at);
          EXPECT_EQ(flood.empty(), expected[seed] < 0);
          const auto words = static_cast<std::size_t>(bits.words_per_row());
          for (std::size_t i = 0; i < expected.size() && !flood.empty(); ++i) {
            const std::size_t x = i % static_cast<std::size_t>(v.size.x),
                              row = i / static_cast<std::size_t>(v.size.x);
            ASSERT_EQ((flood[words * row + x / 64] >> (x % 64) & 1) != 0, expected[i] == expected[seed]);
          }
        }
      }
    }
    differing += parts[0] != parts[1];
  }
  EXPECT_GT(compared, 1000000u);
  EXPECT_GT(differing, 10u);  // 6- and 26-connectivity give different parts
}

}  // namespace
}  // namespace trephine::volume
