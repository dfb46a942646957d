// DepthNet: surface that depth images show. It is a net on the crossings of their rays, and is closed between
// pixels, layers and cameras.
#pragma once

#include <bit>

#include "haptics/depth/depth_cube.h"
#include "volume/surface/cell_samples.h"

namespace trephine::haptics::depth {

/// A cube's lattice with the interface that surface nets use (volume/surface/cell_samples.h): its points are
/// solid by the rays through them, and between two points the surface is at the crossing of the ray that
/// joins them. One bit per point. Immutable when made; queries: any thread, no allocation.
class DepthNet {
 public:
  /// Treatment of walls one lattice point thick that touch at their edges only.
  enum class Thin : std::uint8_t {
    separate,  ///< they are separate, as in the surface net of a volume: a path leads between them
    /// They are joined. Matter between two points that contains neither makes both solid, unless three free
    /// edges next to it lead around it, as at a sharp edge.
    joined
  };
  explicit DepthNet(DepthCube cube, Thin thin = Thin::joined);

  const DepthCube& cube() const noexcept { return cube_; }
  /// Returns true if a lattice point is solid; false beyond the lattice.
  bool is_solid(const glm::ivec3& v) const noexcept {
    const glm::ivec3& size = cube_.size();
    if (v.x < 0 || v.y < 0 || v.z < 0 || v.x >= size.x || v.y >= size.y || v.z >= size.z) return false;
    return bits_[row_of(v) + static_cast<std::size_t>(v.x >> 6)] >> (v.x & 63) & 1u;
  }
  /// Returns the configuration of the cell from v on, as volume::config_of() does.
  int config(const glm::ivec3& v) const noexcept;
  /// Returns the position of the surface from a solid point to a free neighbour, 0 to 1. If their ray has no
  /// crossing, the surface is at the point about which two rays disagree, or at a point that was made solid
  /// for thin matter.
  float crossing(const glm::ivec3& in, const glm::ivec3& air) const noexcept;
  /// Calls use(low) for the points of a layer z whose edge to the next point along `axis` crosses the
  /// surface; both points are in the lattice.
  template <class Use>
  void for_crossed_edges(int axis, int z, const Use& use) const;
  bool joins_solid() const noexcept { return thin_ == Thin::joined; }
  /// Returns the number of edges between two points that were made solid for thin matter.
  std::size_t thin_edges() const noexcept { return thin_edges_; }
  std::size_t bytes() const noexcept { return cube_.bytes() + bits_.capacity() * sizeof(std::uint64_t); }

 private:
  void set_by_rays();
  void set_by_ends();
  void hold_thin_matter();
  /// Returns true if there is matter between v and the next point along the axis that contains neither.
  bool is_thin(int axis, const glm::ivec3& v) const noexcept;
  /// Returns true if the edge from v to the next point along the axis is free.
  bool is_free(int axis, const glm::ivec3& v) const noexcept;
  void set_solid(const glm::ivec3& v) noexcept;
  std::size_t row_of(const glm::ivec3& v) const noexcept {
    return words_ * (static_cast<std::size_t>(v.y) +
                     static_cast<std::size_t>(cube_.size().y) * static_cast<std::size_t>(v.z));
  }

  DepthCube cube_;
  Thin thin_;
  std::size_t words_ = 0;  ///< per row along x
  std::vector<std::uint64_t> bits_;
  std::size_t thin_edges_ = 0;
};

template <class Use>
void DepthNet::for_crossed_edges(int axis, int z, const Use& use) const {
  const glm::ivec3& size = cube_.size();
  if (axis == 2 && z + 1 >= size.z) return;
  const auto rows = static_cast<std::size_t>(size.y);
  for (int y = 0; y < size.y - (axis == 1); ++y) {
    const std::uint64_t* row =
        bits_.data() + words_ * (static_cast<std::size_t>(y) + rows * static_cast<std::size_t>(z));
    const std::uint64_t* next_row = axis == 0 ? row : row + words_ * (axis == 1 ? 1 : rows);
    for (std::size_t w = 0; w < words_; ++w) {
      std::uint64_t next = next_row[w];
      if (axis == 0) next = row[w] >> 1 | (w + 1 < words_ ? row[w + 1] << 63 : 0);
      std::uint64_t crossed = row[w] ^ next;
      for (; crossed != 0; crossed &= crossed - 1)
        if (const int x = static_cast<int>(64 * w) + std::countr_zero(crossed); axis != 0 || x + 1 < size.x)
          use(glm::ivec3(x, y, z));
    }
  }
}

/// Cache of the vertices that one step places, for all nets: a vertex belongs to several quads, and a step
/// visits the same cells again.
class VertexCache {
 public:
  VertexCache() noexcept {
    for (Slot& slot : slots_) slot.owner = nullptr;
  }
  struct Slot {
    const DepthNet* owner;
    const volume::NetCase* net;
    glm::ivec3 cell;
    std::array<glm::vec3, 4> vertices;
  };
  Slot& slot_of(const glm::ivec3& cell) noexcept {
    const auto hash = static_cast<std::uint32_t>(cell.x + 4 * cell.y + 16 * cell.z);
    return slots_[hash % std::tuple_size_v<decltype(slots_)>];
  }

 private:
  std::array<Slot, 64> slots_;
};

/// View of a net, with the interface of samples that surface nets require. Borrows the net and the cache.
class DepthSamples {
 public:
  explicit DepthSamples(const DepthNet& net, VertexCache* placed = nullptr) noexcept
      : net_(net), placed_(placed) {}
  bool is_solid(const glm::ivec3& v) const noexcept { return net_.is_solid(v); }
  int config(const glm::ivec3& cell) const noexcept { return net_.config(cell); }
  bool joins_solid() const noexcept { return net_.joins_solid(); }
  void place(const glm::ivec3& cell, const volume::NetCase& net, glm::vec3* out) const noexcept {
    if (placed_ == nullptr) return volume::place_between_crossings(*this, cell, net, out);
    VertexCache::Slot& slot = placed_->slot_of(cell);
    if (slot.owner != &net_ || slot.net != &net || slot.cell != cell) {
      slot.owner = &net_, slot.net = &net, slot.cell = cell;
      volume::place_between_crossings(*this, cell, net, slot.vertices.data());
    }
    std::copy_n(slot.vertices.begin(), net.patch_count, out);
  }
  float crossing(const glm::ivec3& in, const glm::ivec3& air) const noexcept {
    return net_.crossing(in, air);
  }

 private:
  const DepthNet& net_;
  VertexCache* placed_;
};

/// Replaces volume::config_of(), which would query each corner.
inline int config_of(const DepthSamples& samples, const glm::ivec3& cell) noexcept {
  return samples.config(cell);
}

}  // namespace trephine::haptics::depth
