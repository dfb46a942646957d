// CreaseSheets: a separate field for each flank of the concave creases of an offset surface.
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

/// In a groove narrower than a tool, the gradient of the distance to the nearest flank changes abruptly. A
/// spline of the samples rounds this crease, so that the tool would hover. A *sheet* has the distances only
/// to surface points whose normals are within one cone; the cones cover all directions. In a *creased* cube
/// the solid is the union of the solids of its sheets; in all other cubes the field itself bounds the solid.
/// Immutable after a build.
class CreaseSheets {
 public:
  /// The sheets of a cube or of a lattice point, one bit each.
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
    const Brick* brick = brick_of(v);
    return brick == nullptr ? 0 : brick->cubes.at(SampleBrick::index_of(v));
  }
  /// Returns the sample of a sheet of a creased cube at one of the 27 lattice points around it. The cube must
  /// have the sheet.
  float sample(int sheet, const glm::ivec3& cube, const glm::ivec3& v) const noexcept;
  /// Loads all samples of a sheet of the creased cube around v. The cube must have the sheet.
  void load(int sheet, const glm::ivec3& v, Samples& samples) const noexcept;
  std::size_t bytes() const noexcept;

  /// Table of masks for some of the indices 0 .. Count - 1.
  template <std::size_t Count>
  class MaskTable {
   public:
    /// Returns 0 for an index without a mask.
    Mask at(std::size_t i) const noexcept {
      return (present_[i >> 6] >> (i & 63) & 1) == 0 ? 0 : masks_[rank(i)];
    }
    /// Returns the number of present indices below i.
    std::size_t rank(std::size_t i) const noexcept {
      return before_[i >> 6] +
             static_cast<std::size_t>(std::popcount(present_[i >> 6] & ((Mask{1} << (i & 63)) - 1)));
    }
    /// Adds a mask; indices must increase.
    void add(std::size_t i, Mask mask) {
      present_[i >> 6] |= Mask{1} << (i & 63);
      masks_.push_back(mask);
      for (std::size_t word = (i >> 6) + 1; word < k_words; ++word) ++before_[word];
    }
    std::size_t bytes() const noexcept { return masks_.capacity() * sizeof(Mask); }
    void shrink() { masks_.shrink_to_fit(); }

   private:
    static constexpr std::size_t k_words = (Count + 63) / 64;
    std::array<std::uint64_t, k_words> present_{};
    std::array<std::uint16_t, k_words> before_{};
    std::vector<Mask> masks_;
  };
  /// The creased cubes of a brick, and the samples at the points that they read, which extend one point
  /// beyond the brick on each side.
  struct Brick {
    static constexpr int k_reach = SampleBrick::k_edge + 2;
    MaskTable<SampleBrick::k_edge * SampleBrick::k_edge * SampleBrick::k_edge> cubes;
    MaskTable<k_reach * k_reach * k_reach> points;
    std::vector<std::uint32_t> first;  ///< by point: index of its first sample
    std::vector<float> samples;        ///< by point, in the order of its sheets
    /// Returns the sample of a sheet at the point with index `point`.
    float sample(int sheet, std::size_t point) const noexcept {
      const auto below = static_cast<std::size_t>(std::popcount(points.at(point) & ((Mask{1} << sheet) - 1)));
      return samples[first[points.rank(point)] + below];
    }
    /// Returns the index of a lattice point read by the cubes of the brick that begins at `low`.
    static std::size_t point_index(const glm::ivec3& v, const glm::ivec3& low) noexcept {
      const glm::ivec3 p = v - low + 1;
      return static_cast<std::size_t>((p.z * k_reach + p.y) * k_reach + p.x);
    }
  };
  /// Returns the slot of a brick, for a build. Different threads may write the slots of different bricks.
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
  glm::ivec3 bricks_;
  std::vector<std::unique_ptr<Brick>> table_;
};

}  // namespace trephine::volume
