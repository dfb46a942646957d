// The surface that depth images show: a net on their crossings, so that what lies between pixels, layers and
// cameras is closed.
#pragma once

#include <bit>

#include "haptics/depth/depth_cube.h"
#include "volume/cell_samples.h"

namespace trephine::haptics::depth {

/// A cube's lattice as a surface net asks for it (volume/cell_samples.h): its places are solid by the rays
/// through them, and between two of them the surface lies where the ray that joins them says. A bit a place.
/// Immutable when made; queries: any thread, no allocation.
class DepthNet {
 public:
  /// Walls of one layer of places that touch by their edges alone.
  enum class Thin : std::uint8_t {
    apart,  ///< as the surface net of a volume has them: a way leads through between them
    held    ///< joined; and matter between two places, thinner than a pixel, is held by both, unless one gets
            ///< around it right there, as at a sharp edge
  };
  explicit DepthNet(DepthCube cube, Thin thin = Thin::held);

  const DepthCube& cube() const noexcept { return cube_; }
  /// By the ray along x. Nothing is solid beyond the lattice.
  bool is_solid(const glm::ivec3& v) const noexcept {
    const glm::ivec3& size = cube_.size();
    if (v.x < 0 || v.y < 0 || v.z < 0 || v.x >= size.x || v.y >= size.y || v.z >= size.z) return false;
    return bits_[row_of(v) + static_cast<std::size_t>(v.x >> 6)] >> (v.x & 63) & 1u;
  }
  /// Configuration of the cell from v on, as volume::config_of() gives it.
  int config(const glm::ivec3& v) const noexcept;
  /// Position of the surface from a solid place to a free neighbour, 0 to 1. Where their ray has no crossing
  /// it is at the place about which that and another one disagree, or which holds what is thin.
  float crossing(const glm::ivec3& in, const glm::ivec3& air) const noexcept;
  /// Calls use(low) for the places of a layer z from which the surface crosses the edge to the next place
  /// along `axis`; both lie in the lattice.
  template <class Use>
  void for_crossed_edges(int axis, int z, const Use& use) const;
  bool joins_solid() const noexcept { return thin_ == Thin::held; }
  /// Edges between two places that hold matter thinner than a pixel.
  std::size_t thin_edges() const noexcept { return thin_edges_; }
  std::size_t bytes() const noexcept { return cube_.bytes() + bits_.capacity() * sizeof(std::uint64_t); }

 private:
  void set_by_rays();
  void set_by_ends();
  void hold_thin_matter();
  /// Does matter lie between v and the next place along the axis that neither of them is in?
  bool is_thin(int axis, const glm::ivec3& v) const noexcept;
  /// Is a way from v to the next place along the axis free?
  bool is_free(int axis, const glm::ivec3& v) const noexcept;
  void set_solid(const glm::ivec3& v) noexcept;
  std::size_t row_of(const glm::ivec3& v) const noexcept {
    return words_ * (static_cast<std::size_t>(v.y) +
                     static_cast<std::size_t>(cube_.size().y) * static_cast<std::size_t>(v.z));
  }

  DepthCube cube_;
  Thin thin_;
  std::size_t words_ = 0;  ///< of a row along x
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
    const std::uint64_t* beside = axis == 0 ? row : row + words_ * (axis == 1 ? 1 : rows);
    for (std::size_t w = 0; w < words_; ++w) {
      std::uint64_t next = beside[w];
      if (axis == 0) next = row[w] >> 1 | (w + 1 < words_ ? row[w + 1] << 63 : 0);
      std::uint64_t crossed = row[w] ^ next;
      for (; crossed != 0; crossed &= crossed - 1)
        if (const int x = static_cast<int>(64 * w) + std::countr_zero(crossed); axis != 0 || x + 1 < size.x)
          use(glm::ivec3(x, y, z));
    }
  }
}

/// Vertices that one step has placed, of any net: neighbours of a cell ask for them four times, and a step
/// goes through the same cells again.
class PlacedCells {
 public:
  PlacedCells() noexcept {
    for (Slot& slot : slots_) slot.of = nullptr;
  }
  struct Slot {
    const DepthNet* of;
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

/// A net as a value. Borrows it, and what was placed.
class DepthSamples {
 public:
  explicit DepthSamples(const DepthNet& net, PlacedCells* placed = nullptr) noexcept
      : net_(net), placed_(placed) {}
  bool is_solid(const glm::ivec3& v) const noexcept { return net_.is_solid(v); }
  int config(const glm::ivec3& cell) const noexcept { return net_.config(cell); }
  bool joins_solid() const noexcept { return net_.joins_solid(); }
  void place(const glm::ivec3& cell, const volume::NetCase& net, glm::vec3* out) const noexcept {
    if (placed_ == nullptr) return volume::place_between_crossings(*this, cell, net, out);
    PlacedCells::Slot& slot = placed_->slot_of(cell);
    if (slot.of != &net_ || slot.net != &net || slot.cell != cell) {
      slot.of = &net_, slot.net = &net, slot.cell = cell;
      volume::place_between_crossings(*this, cell, net, slot.vertices.data());
    }
    std::copy_n(slot.vertices.begin(), net.patch_count, out);
  }
  float crossing(const glm::ivec3& in, const glm::ivec3& air) const noexcept {
    return net_.crossing(in, air);
  }

 private:
  const DepthNet& net_;
  PlacedCells* placed_;
};

/// Found in place of volume::config_of(), which would ask for each corner.
inline int config_of(const DepthSamples& samples, const glm::ivec3& cell) noexcept {
  return samples.config(cell);
}

}  // namespace trephine::haptics::depth
