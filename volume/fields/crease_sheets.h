// CreaseSheets: fields of the flanks of an offset surface's concave creases, one by one.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <vector>

#include "volume/fields/sample_brick.h"

namespace trephine::volume {

/// In a groove narrower than a tool, samples of the distance to the nearest flank change abruptly, and a
/// spline of them is rounded: the tool would hover. A *sheet* has distances to those surface points only
/// whose normals are within a cone; the cones cover all directions. In a *creased* cube the solid is the
/// union of the solids of its sheets; in all other cubes the field itself bounds the solid. Immutable after a
/// build.
class CreaseSheets {
 public:
  /// The sheets of a cube, a bit each.
  using Mask = std::uint64_t;
  /// Samples of a sheet around a lattice point, x fastest, mm.
  using Samples = std::array<float, 27>;

  /// `bricks`: number of bricks along each axis.
  explicit CreaseSheets(const glm::ivec3& bricks)
      : bricks_(bricks),
        table_(static_cast<std::size_t>(bricks.x) * static_cast<std::size_t>(bricks.y) *
               static_cast<std::size_t>(bricks.z)) {}

  /// Returns the sheets of the cube around lattice point v; 0 if it is not creased.
  Mask sheets_at(const glm::ivec3& v) const noexcept {
    const Cube* cube = find(v);
    return cube == nullptr ? 0 : cube->sheets;
  }
  /// Returns the samples of a sheet of a creased cube; null if the cube does not have it.
  const Samples* samples(int sheet, const glm::ivec3& v) const noexcept {
    const Cube* cube = find(v);
    if (cube == nullptr || (cube->sheets >> sheet & 1) == 0) return nullptr;
    const auto before = static_cast<std::size_t>(std::popcount(cube->sheets & ((Mask{1} << sheet) - 1)));
    return &brick_of(v)->samples[cube->first + before];
  }
  std::size_t bytes() const noexcept;

  /// The creased cubes of a brick, in the order of their indices. A build writes the bricks of a tile from
  /// one thread, cube by cube in that order.
  struct Cube {
    Mask sheets;
    std::uint32_t first;  ///< of its samples in Brick::samples, in the order of its sheets
  };
  struct Brick {
    std::array<std::uint64_t, 8> creased{};  ///< a bit per cube
    std::vector<Cube> cubes;
    std::vector<Samples> samples;
  };
  std::unique_ptr<Brick>& slot(const glm::ivec3& brick) noexcept { return table_[index_of(brick)]; }

 private:
  std::size_t index_of(const glm::ivec3& b) const noexcept {
    return static_cast<std::size_t>(b.x) +
           static_cast<std::size_t>(bricks_.x) *
               (static_cast<std::size_t>(b.y) +
                static_cast<std::size_t>(bricks_.y) * static_cast<std::size_t>(b.z));
  }
  const Brick* brick_of(const glm::ivec3& v) const noexcept {
    const glm::ivec3 b(v.x >> 3, v.y >> 3, v.z >> 3);
    const bool is_inside =
        b.x >= 0 && b.y >= 0 && b.z >= 0 && b.x < bricks_.x && b.y < bricks_.y && b.z < bricks_.z;
    return is_inside ? table_[index_of(b)].get() : nullptr;
  }
  const Cube* find(const glm::ivec3& v) const noexcept {
    const Brick* brick = brick_of(v);
    if (brick == nullptr) return nullptr;
    const std::size_t cube = SampleBrick::index_of(v), word = cube >> 6;
    if ((brick->creased[word] >> (cube & 63) & 1) == 0) return nullptr;
    int before = std::popcount(brick->creased[word] & ((std::uint64_t{1} << (cube & 63)) - 1));
    for (std::size_t w = 0; w < word; ++w) before += std::popcount(brick->creased[w]);
    return &brick->cubes[static_cast<std::size_t>(before)];
  }
  glm::ivec3 bricks_;
  std::vector<std::unique_ptr<Brick>> table_;
};

}  // namespace trephine::volume
