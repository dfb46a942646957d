// The surface that depth images show: a net on their crossings, so that what lies between pixels, layers and
// cameras is closed.
#pragma once

#include "haptics/depth/depth_cube.h"
#include "volume/cell_samples.h"

namespace trephine::haptics::depth {

/// A cube's lattice as a surface net asks for it (volume/cell_samples.h): its places are solid by the rays
/// through them, and between two of them the surface lies where the ray that joins them says. A bit a place.
/// Immutable when made; queries: any thread, no allocation.
class DepthNet {
 public:
  explicit DepthNet(DepthCube cube);

  const DepthCube& cube() const noexcept { return cube_; }
  /// By the ray along x. Nothing is solid beyond the lattice.
  bool is_solid(const glm::ivec3& v) const noexcept {
    const glm::ivec3& size = cube_.size();
    if (v.x < 0 || v.y < 0 || v.z < 0 || v.x >= size.x || v.y >= size.y || v.z >= size.z) return false;
    const std::size_t row =
        static_cast<std::size_t>(v.y) + static_cast<std::size_t>(size.y) * static_cast<std::size_t>(v.z);
    return bits_[row * words_ + static_cast<std::size_t>(v.x >> 6)] >> (v.x & 63) & 1u;
  }
  /// How far from a solid place to a free one beside it the surface lies, 0 to 1; the middle where their ray
  /// knows none.
  float crossing(const glm::ivec3& in, const glm::ivec3& air) const noexcept;
  std::size_t bytes() const noexcept { return cube_.bytes() + bits_.capacity() * sizeof(std::uint64_t); }

 private:
  DepthCube cube_;
  std::size_t words_ = 0;  ///< of a row along x
  std::vector<std::uint64_t> bits_;
};

/// A net as a value. Borrows it.
class DepthSamples {
 public:
  explicit DepthSamples(const DepthNet& net) noexcept : net_(net) {}
  bool is_solid(const glm::ivec3& v) const noexcept { return net_.is_solid(v); }
  void place(const glm::ivec3& cell, const volume::NetCase& net, glm::vec3* out) const noexcept {
    volume::place_between_crossings(*this, cell, net, out);
  }
  float crossing(const glm::ivec3& in, const glm::ivec3& air) const noexcept {
    return net_.crossing(in, air);
  }

 private:
  const DepthNet& net_;
};

}  // namespace trephine::haptics::depth
