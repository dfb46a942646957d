// Separations by a cut: compared with the parts of the whole volume, which solid_parts_test.cpp tests.
#include "volume/cuts/separation.h"

#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <random>

#include "tests/volume/odd_frames.h"
#include "volume/cuts/removal.h"
#include "volume/cuts/solid_parts.h"

namespace trephine::volume {
namespace {

struct Cut {
  std::shared_ptr<Volume> volume;
  Field field;
  Occupancy bits;
  std::shared_ptr<const Version> start;

  Cut(Volume result, double burr) : volume(std::make_shared<Volume>(std::move(result))) {
    const Shape shape{"", 0};
    field = Field(*volume, shape);
    bits = Occupancy::build(*volume, shape);
    const auto lattice = burr > 0 ? CutLattice::for_burr(*volume, burr).value() : CutLattice(*volume);
    start = std::make_shared<const Version>(volume, lattice);
  }
  bool has_disconnected_part(const Version& version) const {
    const SolidParts parts(field, bits, version);
    for (const SolidParts::Part& part : parts.parts())
      if (part.is_detached) return true;
    return false;
  }
  /// Removes disconnected parts until all matter is connected.
  void remove_disconnected(RemovalEditor& editor) const {
    for (int round = 0; round < 5; ++round) {
      const auto version = editor.freeze();
      const SolidParts parts(field, bits, *version);
      std::vector<std::uint8_t> goes;
      VoxelBox box{glm::ivec3(1 << 20), glm::ivec3(-1)};
      for (const SolidParts::Part& part : parts.parts()) {
        goes.push_back(part.is_detached);
        if (part.is_detached) box = {glm::min(box.low, part.box.low), glm::max(box.high, part.box.high)};
      }
      if (box.high.x < 0) return;
      editor.remove_parts(parts, goes, box);
    }
  }
};

/// Returns lumps of noise, slightly more than half of them solid. `lump`: width of a lump in voxels.
Volume lumps(const Frame& frame, unsigned seed, int lump) {
  std::mt19937 random(seed);
  const auto between = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(random()) / 4294967296.0;
  };
  auto result = make_volume({43, 37, 30}, frame).value();
  std::vector<double> coarse(44 * 38 * 31);
  for (double& value : coarse) value = between(-900, 1000);
  for (int z = 0; z < result.size.z; ++z)
    for (int y = 0; y < result.size.y; ++y)
      for (int x = 0; x < result.size.x; ++x)
        result.voxels[result.index(x, y, z)] = static_cast<std::int16_t>(
            coarse[static_cast<std::size_t>(x / lump + 44 * (y / lump) + 44 * 38 * (z / lump))] +
            between(-300, 300));
  return result;
}

TEST(Separation, AgreesWithPartsOfTheWholeVolume) {
  std::array<int, 3> kinds{};  // number of results by Separation::Kind, on lattices with one sample per voxel
  int fine_held = 0, fine_pending = 0, fine_needless = 0;
  for (const Frame& frame : odd_frames())
    for (unsigned seed = 1; seed <= 4; ++seed) {
      const bool is_fine = seed > 3;
      const Cut cut(lumps(frame, seed, seed % 2 ? 3 : 5), is_fine ? 3.0 : 0);
      std::mt19937 random(seed + 100);
      const auto between = [&](double low, double high) {
        return low + (high - low) * static_cast<double>(random()) / 4294967296.0;
      };
      RemovalEditor editor(cut.start, {cut.field});
      for (int stroke = 0; stroke < (is_fine ? 8 : 20); ++stroke) {
        const auto before = editor.freeze();
        glm::dvec3 at(between(-1, 43), between(-1, 37), between(-1, 30));
        for (int leg = 0; leg < 3; ++leg) {
          const glm::dvec3 next = at + glm::dvec3(between(-9, 9), between(-9, 9), between(-9, 9));
          editor.remove(
              {frame.world_from_volume(at), frame.world_from_volume(next), between(1.5, 2.5), false});
          at = next;
        }
        const auto after = editor.freeze();
        const Separation verdict =
            detect_detachment(cut.field, cut.bits, *before, *after, {.max_bricks = 1 << 20});
        const bool has_detached = cut.has_disconnected_part(*after);
        if (is_fine) {
          ASSERT_NE(verdict.kind, Separation::Kind::detached);
          if (verdict.kind == Separation::Kind::connected) {
            ASSERT_FALSE(has_detached) << seed << " stroke " << stroke;
            ++fine_held;
          } else {
            ++fine_pending, fine_needless += !has_detached;
          }
        } else {
          ASSERT_EQ(verdict.kind, has_detached ? Separation::Kind::detached : Separation::Kind::connected)
              << seed << " stroke " << stroke;
          ++kinds[static_cast<std::size_t>(verdict.kind)];
        }
        // With a smaller budget the search gives up or returns the same result.
        for (const std::int64_t most : {1, 10, 40}) {
          const Separation cheaper =
              detect_detachment(cut.field, cut.bits, *before, *after, {.max_bricks = most});
          if (cheaper.kind != Separation::Kind::pending) {
            ASSERT_EQ(cheaper.kind, verdict.kind);
          }
        }
        cut.remove_disconnected(editor);
      }
    }
  EXPECT_GT(kinds[0], 40);
  EXPECT_GT(kinds[1], 40);
  EXPECT_GT(fine_held, 5);
  EXPECT_GT(fine_pending, 3);
  EXPECT_LE(fine_needless, fine_pending / 2);
}

/// A saw cuts along a ring through a plate of bone. No part is detached until the ring closes; then the disk
/// is detached.
TEST(Separation, FindsADiskWhenItsRingCloses) {
  for (const double burr : {0.0, 2.2}) {
    auto result = make_volume({90, 90, 24}, Frame::from_spacing({0, 0, 0}, glm::dvec3(0.6)).value()).value();
    for (int z = 0; z < 24; ++z)
      for (int y = 0; y < 90; ++y)
        for (int x = 0; x < 90; ++x) result.voxels[result.index(x, y, z)] = z >= 7 && z < 17 ? 500 : -1000;
    const Cut cut(std::move(result), burr);
    RemovalEditor editor(cut.start, {cut.field});
    constexpr int k_steps = 40;
    for (int i = 0; i < k_steps; ++i) {
      const auto before = editor.freeze();
      const auto at = [&](double step, double z) {
        const double a = 2 * 3.14159265358979 * step / k_steps;
        return glm::dvec3(27 + 14 * std::cos(a), 27 + 14 * std::sin(a), z);
      };
      // One stroke: a step along the ring, through the whole plate.
      for (double z = 10.6; z > 3; z -= 0.7) editor.remove({at(i, z), at(i + 1, z), 1.2, false});
      const auto after = editor.freeze();
      const Separation verdict = detect_detachment(cut.field, cut.bits, *before, *after);
      const bool has_detached = cut.has_disconnected_part(*after);
      EXPECT_EQ(verdict.kind, !has_detached ? Separation::Kind::connected
                              : burr == 0.0 ? Separation::Kind::detached
                                            : Separation::Kind::pending)
          << i;
      // The saw is 2.4 mm wide, and a step is 2.2 mm long, so that the last step but one closes the ring.
      EXPECT_EQ(has_detached, i >= k_steps - 2) << i;
      if (has_detached) {
        // Planted fault: if both versions are the cut one, no separation is found.
        EXPECT_EQ(detect_detachment(cut.field, cut.bits, *after, *after).kind, Separation::Kind::connected);
        break;
      }
      EXPECT_LT(verdict.bricks, burr == 0.0 ? 250 : 800) << i;
    }
  }
}

}  // namespace
}  // namespace trephine::volume
