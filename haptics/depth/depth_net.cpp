#include "haptics/depth/depth_net.h"

#include <algorithm>
#include <cmath>

namespace trephine::haptics::depth {

using glm::ivec3;

DepthNet::DepthNet(DepthCube cube, Thin thin) : cube_(std::move(cube)), thin_(thin) {
  const ivec3 size = cube_.size();
  words_ = static_cast<std::size_t>(size.x + 63) / 64;
  bits_.assign(words_ * static_cast<std::size_t>(size.y) * static_cast<std::size_t>(size.z), 0);
  set_by_rays();
  if (thin != Thin::joined) return;
  set_by_ends();
  hold_thin_matter();
}

void DepthNet::set_by_rays() {
  const ivec3 size = cube_.size();
  std::uint64_t* row = bits_.data();
  for (int z = 0; z < size.z; ++z)
    for (int y = 0; y < size.y; ++y, row += words_) {
      const std::span<const float> crossings = cube_.ray(0, y, z);
      for (std::size_t k = 0; k + 1 < crossings.size(); k += 2) {
        // Both ends belong to matter, as does a voxel whose value is the threshold.
        const auto within = [&](float at) { return std::clamp(static_cast<int>(at), 0, size.x); };
        const int end = within(std::floor(crossings[k + 1]) + 1);
        for (int x = within(std::ceil(crossings[k])); x < end;) {
          // Fills the bits of the run in one word.
          const int count = std::min(64 - (x & 63), end - x);
          const std::uint64_t run = count == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << count) - 1;
          row[x >> 6] |= run << (x & 63);
          x += count;
        }
      }
    }
}

namespace {
/// Returns true if an interval of matter contains no lattice point. Both ends belong to matter.
bool is_between_points(float begin, float end) noexcept { return std::ceil(begin) > std::floor(end); }
}  // namespace

bool DepthNet::is_thin(int axis, const ivec3& v) const noexcept {
  const auto [i, j] = across(axis);
  const std::span<const float> ray = cube_.ray(axis, v[i], v[j]);
  const auto low = static_cast<float>(v[axis]);
  for (std::size_t k = 0; k + 1 < ray.size() && ray[k] < low + 1; k += 2)
    if (ray[k] > low && is_between_points(ray[k], ray[k + 1])) return true;
  return false;
}

bool DepthNet::is_free(int axis, const ivec3& v) const noexcept {
  ivec3 next = v;
  ++next[axis];
  return !is_solid(v) && !is_solid(next) && !is_thin(axis, v);
}

void DepthNet::set_solid(const ivec3& v) noexcept {
  bits_[row_of(v) + static_cast<std::size_t>(v.x >> 6)] |= std::uint64_t{1} << (v.x & 63);
}

/// Makes a lattice point solid if matter on any of its three rays contains it, or ends within k_graze of it.
/// A ray that grazes an edge or a corner of a model may miss the adjacent triangles, which would leave a hole
/// in a thin wall. Only the points near the ends of an interval are tested, since the rays of a point
/// disagree only there.
void DepthNet::set_by_ends() {
  constexpr float k_graze = 0x1p-10F;  // share of a pixel, above the rounding of corners and crossings
  constexpr int k_near = 3;            // lattice points
  for (int axis = 0; axis < 3; ++axis) {
    const auto [i, j] = across(axis);
    const int end = cube_.size()[axis];
    for (int row = 0; row < cube_.size()[j]; ++row)
      for (int column = 0; column < cube_.size()[i]; ++column) {
        const std::span<const float> ray = cube_.ray(axis, column, row);
        for (std::size_t k = 0; k + 1 < ray.size(); k += 2) {
          const int first = std::max(static_cast<int>(std::ceil(std::max(ray[k], -1.0F) - k_graze)), 0),
                    last = std::min(
                        static_cast<int>(std::floor(std::min(ray[k + 1], static_cast<float>(end)) + k_graze)),
                        end - 1);
          ivec3 v;
          v[i] = column, v[j] = row;
          for (v[axis] = first; v[axis] <= last; ++v[axis]) {
            if (v[axis] == first + k_near) v[axis] = std::max(v[axis], last - k_near + 1);
            if (!is_solid(v)) set_solid(v);
          }
        }
      }
  }
}

/// Makes both ends of edges through thin matter solid, so that no path between free points leads through that
/// matter. An edge is left out if three free edges lead around it, since its matter separates no points.
void DepthNet::hold_thin_matter() {
  const ivec3 size = cube_.size();
  std::vector<ivec3> held;
  for (int axis = 0; axis < 3; ++axis) {
    const auto [i, j] = across(axis);
    const auto is_around_free = [&, i = i, j = j](const ivec3& v) {
      for (const int side : {i, j})
        for (const int step : {-1, 1}) {
          ivec3 neighbour = v;
          neighbour[side] += step;
          if (neighbour[side] < 0 || neighbour[side] >= size[side]) continue;  // unknown beyond the lattice
          const ivec3& low = step < 0 ? neighbour : v;
          ivec3 far = low;
          ++far[axis];
          if (is_free(side, low) && is_free(axis, neighbour) && is_free(side, far)) return true;
        }
      return false;
    };
    for (int row = 0; row < size[j]; ++row)
      for (int column = 0; column < size[i]; ++column) {
        const std::span<const float> ray = cube_.ray(axis, column, row);
        for (std::size_t k = 0; k + 1 < ray.size(); k += 2) {
          if (!is_between_points(ray[k], ray[k + 1])) continue;
          ivec3 v;
          v[i] = column, v[j] = row, v[axis] = static_cast<int>(std::floor(ray[k]));
          if (v[axis] < 0 || v[axis] + 1 >= size[axis] || is_around_free(v)) continue;
          ++thin_edges_;
          held.push_back(v);
          ++v[axis];
          held.push_back(v);
        }
      }
  }
  for (const ivec3& v : held) set_solid(v);
}

int DepthNet::config(const ivec3& v) const noexcept {
  const ivec3& size = cube_.size();
  int bits = 0;
  for (int k = 0; k < 4; ++k) {
    const int y = v.y + (k & 1), z = v.z + (k >> 1);
    if (y < 0 || z < 0 || y >= size.y || z >= size.z) continue;
    const std::uint64_t* row = bits_.data() + row_of({0, y, z});
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
  // Searches the crossings that leave matter if `in` is the lower point, otherwise those that enter it; both
  // in increasing order.
  for (std::size_t k = in[axis] < air[axis] ? 1 : 0; k < ray.size(); k += 2) {
    if (ray[k] < static_cast<float>(low)) continue;
    if (ray[k] > static_cast<float>(low + 1)) break;
    return std::abs(ray[k] - static_cast<float>(in[axis]));
  }
  const float middle = static_cast<float>(low) + 0.5F;
  std::size_t passed = 0;
  while (passed < ray.size() && ray[passed] <= middle) ++passed;
  return passed % 2 == 1 ? 1.0F : 0.0F;
}

}  // namespace trephine::haptics::depth
