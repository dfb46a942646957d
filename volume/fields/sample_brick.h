// SampleBrick: 8 x 8 x 8 samples of a field, stored only where the field is not uniform.
#pragma once

#include <array>
#include <cstddef>
#include <glm/vec3.hpp>
#include <memory>

#include "volume/fields/quadratic_patch.h"

namespace trephine::volume {

struct SampleBrick {
  static constexpr int k_edge = 8;
  std::array<float, k_edge * k_edge * k_edge> values;

  static constexpr std::size_t index(int x, int y, int z) noexcept {
    return static_cast<std::size_t>((z * k_edge + y) * k_edge + x);
  }
  /// Index of lattice point v in its brick.
  static std::size_t index_of(const glm::ivec3& v) noexcept {
    return index(v.x & (k_edge - 1), v.y & (k_edge - 1), v.z & (k_edge - 1));
  }
  /// Returns true if all 27 samples around v are in the brick of v.
  static bool contains_neighbours(const glm::ivec3& v) noexcept {
    const auto is_inner = [](int s) {
      const int b = s & (k_edge - 1);
      return b >= 1 && b + 1 < k_edge;
    };
    return is_inner(v.x) && is_inner(v.y) && is_inner(v.z);
  }
};

/// Entry of a table of bricks.
struct SampleSlot {
  std::shared_ptr<const SampleBrick> brick;  ///< null: uniform
  bool is_solid = false;                     ///< kind of all samples if `brick` is null
};

/// Loads the 27 samples around v into `patch`: from `brick` (may be null) if it contains them all, else from
/// at(x, y, z).
template <class At>
void load_around(const glm::ivec3& v, const SampleBrick* brick, QuadraticPatch& patch, At&& at) noexcept {
  if (brick && SampleBrick::contains_neighbours(v)) {
    const float* middle = brick->values.data() + SampleBrick::index_of(v);
    for (int k = -1; k <= 1; ++k)
      for (int j = -1; j <= 1; ++j) {
        const float* row = middle + (k * SampleBrick::k_edge + j) * SampleBrick::k_edge;
        patch.set_row(j + 1, k + 1, static_cast<double>(row[-1]), static_cast<double>(row[0]),
                      static_cast<double>(row[1]));
      }
    return;
  }
  for (int k = -1; k <= 1; ++k)
    for (int j = -1; j <= 1; ++j)
      patch.set_row(j + 1, k + 1, at(v.x - 1, v.y + j, v.z + k), at(v.x, v.y + j, v.z + k),
                    at(v.x + 1, v.y + j, v.z + k));
}

}  // namespace trephine::volume
