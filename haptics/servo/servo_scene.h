// ServoScene: all touchable data of a servo, prepared on another thread and adopted by one pointer per tick.
// All other input of a tick is in ServoInput.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "haptics/force/servo_law.h"
#include "haptics/proxy/proxy_method.h"
#include "volume/base/channel.h"
#include "volume/scan/traversal.h"

namespace trephine::haptics {

/// Escape path of a proxy that restored matter covers: some previous positions of the proxy, newest first.
/// The last position is free of the restored matter.
struct EscapePath {
  static constexpr std::size_t k_max_positions = 64;
  std::uint64_t serial = 0;  ///< of the first ServoScene with the restored matter
  std::uint32_t count = 0;   ///< number of positions; 0: no path is known, and a buried proxy is released
  std::array<glm::dvec3, k_max_positions> positions_volume;
};

/// Touchable data of one hand. A value; immutable when published.
struct ServoHand {
  ServoHand(std::shared_ptr<const TouchScene> items, std::shared_ptr<const ProxyMethod> prepared,
            TouchState touch_state, std::shared_ptr<const LawSet> force_laws = nullptr);

  std::shared_ptr<const TouchScene> scene;    ///< items that the hand may touch, and its tool
  std::shared_ptr<const ProxyMethod> method;  ///< prepared for that scene
  std::uint64_t layout = 0;                   ///< changes with the scene or method
  /// Sets other items or another method. The method must be prepared for the items. Requires the same base,
  /// and the same indices for items that stay. For these items, the values set by set_touchable(),
  /// set_ready() and set_placement() stay.
  void set_scene(std::shared_ptr<const TouchScene> items, std::shared_ptr<const ProxyMethod> prepared);
  TouchState state;
  std::shared_ptr<const LawSet> laws;             ///< null: no force in addition to those of surfaces
  std::shared_ptr<const EscapePath> escape_path;  ///< the latest; null: no matter was restored yet
  bool has_pops = false;                          ///< some material of the scene has a pop force

  /// Sets whether an item may block the hand, and whether its data are available; both are true at the start.
  /// A touchable item that is not ready lets the hand through, and the next tick emits an event.
  void set_touchable(int item, bool is_touchable) noexcept { untouchable.set(item, !is_touchable); }
  void set_ready(int item, bool is_ready) noexcept;
  /// Sets the box of voxels in which the data of an item are available (low > high: no voxel). The item is
  /// ready while hand and proxy are in the box, at least a few voxels from its border. At most k_max_parts
  /// items have a box at a time; a further item is not ready.
  void set_ready(int item, const volume::VoxelBox& voxels) noexcept;
  /// Sets the placement of a moving mesh.
  void set_placement(int mover, const Placement& placement) noexcept;

  static constexpr std::size_t k_max_parts = 8;
  struct Part {  ///< available part of an item
    int item;
    volume::VoxelBox voxels;
  };
  ShapeSet untouchable, not_ready;
  ShapeSet passable_items;  ///< items that the instrument of the hand can currently pass
  std::array<Part, k_max_parts> parts;
  std::size_t part_count = 0;
  std::array<Placement, TouchScene::k_max_movers> placements;
  std::size_t placement_count = 0;  ///< number of valid placements; later movers are at TouchItem::placement
  /// A moving mesh that a hand holds. The mesh moves with the pose of that hand in the previous tick. While
  /// that pose is unknown, the mesh is at its set or initial placement.
  struct Held {
    int mover;
    std::uint8_t hand;  ///< index of the hand
    Placement grip;     ///< placement of the mesh in the frame of the hand
  };
  void set_held(int mover, std::uint8_t hand, const Placement& grip) noexcept;
  void release_held() noexcept { held_count = 0; }
  std::array<Held, TouchScene::k_max_movers> held;
  std::size_t held_count = 0;
};

struct ServoScene {
  static constexpr std::size_t k_max_hands = 4;
  std::uint64_t serial = 0;  ///< increases with every published scene; ticks record it
  /// The number of hands is constant. A core without an entry raises fault_stale_scene; its force fades.
  std::vector<ServoHand> hands;
  bool has_held = false;  ///< a hand may touch a mesh that another hand holds
};

using ServoChannel = Channel<ServoScene>;

/// Returns a shared pointer that does not own the value; the value must outlive all copies of the pointer.
template <class T>
std::shared_ptr<const T> borrowed(const T& value) noexcept {
  return {std::shared_ptr<void>(), &value};
}
/// Makes a scene for one hand, with the serial of the version. Borrows scene and method.
ServoScene scene_for_one(const TouchScene& scene, const ProxyMethod& method,
                         std::shared_ptr<const volume::Version> version,
                         std::shared_ptr<const LawSet> laws = nullptr);

}  // namespace trephine::haptics
