// Scene that a servo adopts, by one pointer a tick: all touchable data, prepared on another thread. In
// addition a tick gets poses and faults alone.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "haptics/force/servo_law.h"
#include "haptics/proxy/proxy_method.h"
#include "volume/channel.h"
#include "volume/traversal.h"

namespace trephine::haptics {

/// The way back of a proxy over which matter grows: where it had been, newest first, to a place that is free
/// then.
struct WayOut {
  static constexpr std::size_t k_most_places = 64;
  std::uint64_t serial = 0;  ///< of the first ServoScene with that matter
  std::uint32_t count = 0;   ///< of places; 0: none is known, and who is buried is set free
  std::array<glm::dvec3, k_most_places> places_volume;
};

/// Touchable data of one hand. A value; immutable when published.
struct ServoHand {
  ServoHand(std::shared_ptr<const TouchScene> items, std::shared_ptr<const ProxyMethod> prepared,
            TouchState seen, std::shared_ptr<const LawSet> beside = nullptr);

  std::shared_ptr<const TouchScene> scene;    ///< what it may touch, with its tool's geometry
  std::shared_ptr<const ProxyMethod> method;  ///< prepared for that scene
  std::uint64_t layout = 0;                   ///< another number for another scene or method
  /// Other items or another method, prepared for them. The base stays, and items that stay keep their
  /// indices; switches, readiness and places stay too, but for parts of items that are gone.
  void set_scene(std::shared_ptr<const TouchScene> items, std::shared_ptr<const ProxyMethod> prepared);
  TouchState state;
  std::shared_ptr<const LawSet> laws;  ///< null: no force in addition to the surfaces'
  std::shared_ptr<const WayOut> way;   ///< the newest; null: none yet
  bool has_pops = false;               ///< some material of the scene gives way

  /// May this item hold the hand, and are its bits there? One that is wanted and not ready lets the hand
  /// through, and the next tick says so. Both are true at the start.
  void set_touchable(int item, bool is_touchable) noexcept { untouchable.set(item, !is_touchable); }
  void set_ready(int item, bool is_ready) noexcept;
  /// Voxels of a shape whose bits are there (low > high: not a single one): it is ready while
  /// hand and proxy stay within them, a few voxels off their border. Of k_most_parts items at a time; a
  /// further one is not ready at all.
  void set_ready(int item, const volume::VoxelBox& voxels) noexcept;
  /// Place of a moving mesh.
  void set_placement(int mover, const Placement& placement) noexcept;

  static constexpr std::size_t k_most_parts = 8;
  struct Part {  ///< of an item that is ready
    int item;
    volume::VoxelBox voxels;
  };
  ShapeSet untouchable, not_ready;
  std::array<Part, k_most_parts> parts;
  std::size_t part_count = 0;
  std::array<Placement, TouchScene::k_max_movers> placements;
  std::size_t placement_count = 0;  ///< of them set: the first ones; others are where they start
  /// A moving mesh that some hand holds goes with that hand, as it was in the tick before; where the hand is
  /// not known it is at its placement.
  struct Held {
    int mover;
    std::uint8_t by;  ///< hand
    Placement grip;   ///< the mesh seen from the hand
  };
  void set_held(int mover, std::uint8_t by, const Placement& grip) noexcept;
  void let_go() noexcept { held_count = 0; }  ///< of all of them
  std::array<Held, TouchScene::k_max_movers> held;
  std::size_t held_count = 0;
};

struct ServoScene {
  static constexpr std::size_t k_most_hands = 4;
  std::uint64_t serial = 0;      ///< higher in each that is published; ticks record it
  std::vector<ServoHand> hands;  ///< as many in each; a hand without an entry feels nothing, and faults
  bool has_held = false;         ///< some hand feels what another one holds
};

using ServoChannel = volume::Channel<ServoScene>;

/// Shares values that outlive their users.
template <class T>
std::shared_ptr<const T> borrowed(const T& value) noexcept {
  return {std::shared_ptr<void>(), &value};
}
/// For one hand, by the version's serial. Borrows scene and method.
ServoScene scene_for_one(const TouchScene& scene, const ProxyMethod& method,
                         std::shared_ptr<const volume::Version> version,
                         std::shared_ptr<const LawSet> laws = nullptr);

}  // namespace trephine::haptics
