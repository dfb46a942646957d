#include "haptics/depth/depth_net.h"

#include <algorithm>
#include <cmath>

namespace trephine::haptics::depth {

using glm::ivec3;

DepthNet::DepthNet(DepthCube cube) : cube_(std::move(cube)) {
  const ivec3 size = cube_.size();
  words_ = static_cast<std::size_t>(size.x + 63) / 64;
  bits_.assign(words_ * static_cast<std::size_t>(size.y) * static_cast<std::size_t>(size.z), 0);
  std::uint64_t* row = bits_.data();
  for (int z = 0; z < size.z; ++z)
    for (int y = 0; y < size.y; ++y, row += words_) {
      const std::span<const float> crossings = cube_.ray(0, y, z);
      for (std::size_t k = 0; k + 1 < crossings.size(); k += 2) {
        // Both ends belong to matter, as a voxel does whose value is the threshold.
        const auto within = [&](float at) { return std::clamp(static_cast<int>(at), 0, size.x); };
        const int end = within(std::floor(crossings[k + 1]) + 1);
        for (int x = within(std::ceil(crossings[k])); x < end;) {
          // As much of a word as there is.
          const int count = std::min(64 - (x & 63), end - x);
          const std::uint64_t run = count == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << count) - 1;
          row[x >> 6] |= run << (x & 63);
          x += count;
        }
      }
    }
}

int DepthNet::config(const ivec3& v) const noexcept {
  const ivec3& size = cube_.size();
  int bits = 0;
  for (int k = 0; k < 4; ++k) {
    const int y = v.y + (k & 1), z = v.z + (k >> 1);
    if (y < 0 || z < 0 || y >= size.y || z >= size.z) continue;
    const std::uint64_t* row =
        bits_.data() + words_ * (static_cast<std::size_t>(y) +
                                 static_cast<std::size_t>(size.y) * static_cast<std::size_t>(z));
    const auto bit = [&](int x) {
      return x < 0 || x >= size.x ? 0 : static_cast<int>(row[x >> 6] >> (x & 63) & 1u);
    };
    bits |= (bit(v.x) | bit(v.x + 1) << 1) << (2 * k);
  }
  return bits;
}

float DepthNet::crossing(const ivec3& in, const ivec3& air) const noexcept {
  const int axis = in.x != air.x ? 0 : in.y != air.y ? 1 : 2, low = std::min(in[axis], air[axis]);
  const auto [u, v] = across(axis);
  const std::span<const float> ray = cube_.ray(axis, in[u], in[v]);
  // Rising, of those that leave matter, or of those that enter it.
  for (std::size_t k = in[axis] < air[axis] ? 1 : 0; k < ray.size(); k += 2) {
    if (ray[k] < static_cast<float>(low)) continue;
    if (ray[k] > static_cast<float>(low + 1)) break;
    return std::abs(ray[k] - static_cast<float>(in[axis]));
  }
  return 0.5F;
}

}  // namespace trephine::haptics::depth
