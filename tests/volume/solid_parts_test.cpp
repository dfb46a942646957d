#include "volume/cuts/solid_parts.h"

#include <algorithm>
#include <array>
#include <gtest/gtest.h>
#include <map>
#include <random>
#include <set>
#include <vector>

#include "tests/volume/odd_frames.h"
#include "volume/cuts/removal.h"

namespace trephine::volume {
namespace {

/// Parts by definition: floods over the whole lattice, sample by sample.
struct Flooded {
  glm::ivec3 size;
  std::vector<int> state;  ///< 0 air, 1 kept, 2 removed
  std::vector<int> part;   ///< per sample: number of its part in the kept matter, -1: no part
  std::vector<int> whole;  ///< per sample: number of its part in the kept and removed matter, -1: no part

  std::size_t at(const glm::ivec3& s) const {
    return static_cast<std::size_t>(s.x + size.x * (s.y + size.y * s.z));
  }
  Flooded(const Field& field, const Version& version) : size(version.lattice().size()) {
    find_parts(field, version, {});
    if (version.lattice().has_voxel_resolution()) return;
    // Around detached parts, up to two voxels outside the part's box, each sample of a surface voxel is
    // evaluated. A surface voxel differs from one of its 26 neighbours: one is solid and one is air.
    const Volume& volume = version.base();
    const int count = part.empty() ? 0 : *std::max_element(part.begin(), part.end()) + 1;
    std::vector<std::int64_t> samples(static_cast<std::size_t>(count));
    std::vector<VoxelBox> boxes(static_cast<std::size_t>(count), {glm::ivec3(1 << 20), glm::ivec3(-1)});
    std::vector<int> whole_of(static_cast<std::size_t>(count));
    for (std::size_t i = 0; i < part.size(); ++i) {
      if (part[i] < 0) continue;
      const auto p = static_cast<std::size_t>(part[i]);
      const int s = static_cast<int>(i);
      const glm::ivec3 v =
          version.lattice().voxel_of({s % size.x, s / size.x % size.y, s / (size.x * size.y)});
      ++samples[p];
      whole_of[p] = whole[i];
      boxes[p] = {glm::min(boxes[p].low, v), glm::max(boxes[p].high, v)};
    }
    std::set<std::array<int, 3>> asked;
    const auto is_solid = [&](const glm::ivec3& v) {
      return volume.contains(v) && field.at(v.x, v.y, v.z) >= 0;
    };
    for (std::size_t p = 0; p < samples.size(); ++p) {
      bool is_detached = false;
      for (std::size_t q = 0; q < samples.size(); ++q)
        is_detached = is_detached || (whole_of[q] == whole_of[p] &&
                                      (samples[q] > samples[p] || (samples[q] == samples[p] && q < p)));
      for (int z = boxes[p].low.z - 2; is_detached && z <= boxes[p].high.z + 2; ++z)
        for (int y = boxes[p].low.y - 2; y <= boxes[p].high.y + 2; ++y)
          for (int x = boxes[p].low.x - 2; x <= boxes[p].high.x + 2; ++x)
            for (int n = 0; n < 27; ++n)
              if (is_solid({x, y, z}) !=
                  is_solid(glm::ivec3(x, y, z) + glm::ivec3(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1)))
                asked.insert({x, y, z});
    }
    if (!asked.empty()) find_parts(field, version, asked);
  }
  void find_parts(const Field& field, const Version& version, const std::set<std::array<int, 3>>& asked) {
    const CutLattice& lattice = version.lattice();
    const Volume& volume = version.base();
    state.clear();
    for (int z = 0; z < size.z; ++z)
      for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) {
          const glm::ivec3 s(x, y, z), v = lattice.voxel_of(s);
          int what = 0;
          if (volume.contains(v)) {
            if (!version.has_brick(lattice.low_of(v), lattice.high_of(v)) && !asked.contains({v.x, v.y, v.z}))
              what = field.at(v.x, v.y, v.z) >= 0;
            else if (field.value(lattice.volume_from_lattice(glm::dvec3(s))) >= 0)
              what = version.sample_distance(s) > 0 ? 1 : 2;
          }
          state.push_back(what);
        }
    part = flood([](int what) { return what == 1; });
    whole = flood([](int what) { return what != 0; });
  }
  template <class Is>
  std::vector<int> flood(Is&& is) const {
    std::vector<int> all(state.size(), -1);
    int next = 0;
    std::vector<glm::ivec3> open;
    for (int z = 0; z < size.z; ++z)
      for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) {
          if (!is(state[at({x, y, z})]) || all[at({x, y, z})] >= 0) continue;
          open.push_back({x, y, z});
          all[at({x, y, z})] = next;
          while (!open.empty()) {
            const glm::ivec3 s = open.back();
            open.pop_back();
            for (int i = 0; i < 27; ++i) {
              const glm::ivec3 n = s + glm::ivec3(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
              if (n.x < 0 || n.y < 0 || n.z < 0 || n.x >= size.x || n.y >= size.y || n.z >= size.z) continue;
              if (!is(state[at(n)]) || all[at(n)] >= 0) continue;
              all[at(n)] = next;
              open.push_back(n);
            }
          }
          ++next;
        }
    return all;
  }
};

TEST(SolidParts, EqualPartsOfAFlood) {
  int off = 0, more = 0;
  for (const Frame& frame : odd_frames())
    for (unsigned seed = 1; seed <= 4; ++seed) {
      std::mt19937 random(seed);
      const auto between = [&](double low, double high) {
        return low + (high - low) * static_cast<double>(random()) / 4294967296.0;
      };
      auto result = make_volume({19, 17, 12}, frame).value();
      // Lumps of noise: slightly more than half are solid.
      std::array<double, 343> coarse;
      for (double& value : coarse) value = between(-900, 1100);
      for (int z = 0; z < 12; ++z)
        for (int y = 0; y < 17; ++y)
          for (int x = 0; x < 19; ++x)
            result.voxels[result.index(x, y, z)] = static_cast<std::int16_t>(
                coarse[static_cast<std::size_t>(x / 3 + 7 * (y / 3) + 49 * (z / 3))] + between(-300, 300));
      const auto volume = std::make_shared<Volume>(std::move(result));
      const Shape shape{"", 0};
      const Field field(*volume, shape);
      const Occupancy bits = Occupancy::build(*volume, shape);
      const auto lattice = seed % 2 ? CutLattice(*volume) : CutLattice::for_burr(*volume, 2.5).value();
      RemovalEditor editor(std::make_shared<const Version>(volume, lattice), {field});
      for (int cut = 0; cut < 9; ++cut) {
        const auto place = [&] {
          return volume->frame.world_from_volume({between(-1, 19), between(-1, 17), between(-1, 12)});
        };
        editor.remove({place(), place(), 1.3, false});
      }
      const auto version = editor.publish();
      const SolidParts parts(field, bits, *version);
      const Flooded judge(field, *version);

      // Both must find the same parts, numbered in the order of their first samples.
      std::map<int, int> part_of;
      std::vector<std::int64_t> samples(parts.parts().size());
      for (int z = 0; z < judge.size.z; ++z)
        for (int y = 0; y < judge.size.y; ++y) {
          std::vector<int> row(static_cast<std::size_t>(judge.size.x));
          parts.row(0, y, z, judge.size.x, row.data());
          for (int x = 0; x < judge.size.x; ++x) {
            const int part = row[static_cast<std::size_t>(x)], wanted = judge.part[judge.at({x, y, z})];
            ASSERT_EQ(part == SolidParts::k_air, wanted < 0) << x << ' ' << y << ' ' << z;
            if (part == SolidParts::k_air) continue;
            ASSERT_EQ(parts.part_of({x, y, z}), part);
            ASSERT_EQ(part, wanted) << seed;  // both number parts by first samples
            ASSERT_EQ(part_of.emplace(part, judge.whole[judge.at({x, y, z})]).first->second,
                      judge.whole[judge.at({x, y, z})]);
            ++samples[static_cast<std::size_t>(part)];
            const VoxelBox& box = parts.parts()[static_cast<std::size_t>(part)].box;
            const glm::ivec3 v = version->lattice().voxel_of({x, y, z});
            ASSERT_TRUE(glm::all(glm::lessThanEqual(box.low, v)) &&
                        glm::all(glm::lessThanEqual(v, box.high)));
          }
        }
      ASSERT_EQ(part_of.size(), parts.parts().size());
      for (std::size_t p = 0; p < samples.size(); ++p) {
        EXPECT_EQ(parts.parts()[p].samples, samples[p]);
        bool is_detached = false;
        for (std::size_t q = 0; q < samples.size(); ++q)
          is_detached = is_detached || (part_of[static_cast<int>(q)] == part_of[static_cast<int>(p)] &&
                                        (samples[q] > samples[p] || (samples[q] == samples[p] && q < p)));
        EXPECT_EQ(parts.parts()[p].is_detached, is_detached);
        off += is_detached;
      }
      more += static_cast<int>(samples.size()) - 1;
    }
  EXPECT_GT(off, 10);    // the cuts detached some parts
  EXPECT_GT(more, off);  // other parts were separate before the cuts
}

TEST(SolidParts, NoPartIsSeparatedWithoutACut) {
  const auto volume = std::make_shared<Volume>(make_volume({9, 9, 9}, Frame()).value());
  for (auto& x : volume->voxels.span()) x = -1000;
  volume->voxels[volume->index(2, 2, 2)] = volume->voxels[volume->index(6, 6, 6)] = 1000;
  const Shape shape{"", 300};
  const Field field(*volume, shape);
  const Occupancy bits = Occupancy::build(*volume, shape);
  const SolidParts parts(field, bits, Version(volume));
  ASSERT_EQ(parts.parts().size(), 2u);
  EXPECT_FALSE(parts.parts()[0].is_detached || parts.parts()[1].is_detached);
}

}  // namespace
}  // namespace trephine::volume
