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

/// Escape path of a proxy that restored matter covers: some of its previous positions, newest first; the last
/// one is free of the restored matter.
struct EscapePath {
  static constexpr std::size_t k_max_positions = 64;
  std::uint64_t serial = 0;  ///< of the first ServoScene with that matter
  std::uint32_t count = 0;   ///< number of positions; 0: no path is known, and a buried proxy is released
  std::array<glm::dvec3, k_max_positions> positions_volume;
};

/// Touchable data of one hand. A value; immutable when published.
struct ServoHand {
  ServoHand(std::shared_ptr<const TouchScene> items, std::shared_ptr<const ProxyMethod> prepared,
            TouchState touch_state, std::shared_ptr<const LawSet> force_laws = nullptr);

  std::shared_ptr<const TouchScene> scene;    ///< items that it may touch, with its tool's geometry
  std::shared_ptr<const ProxyMethod> method;  ///< prepared for that scene
  std::uint64_t layout = 0;                   ///< changes with the scene or method
  /// Sets other items or another method, prepared for them. Requires the same base, and the same indices for
  /// items that stay. Placements stay, and so does what set_touchable() and set_ready() set for these items.
  void set_scene(std::shared_ptr<const TouchScene> items, std::shared_ptr<const ProxyMethod> prepared);
  TouchState state;
  std::shared_ptr<const LawSet> laws;             ///< null: no force in addition to those of surfaces
  std::shared_ptr<const EscapePath> escape_path;  ///< the newest; null: no path yet
  bool has_pops = false;                          ///< some material of the scene has a pop force

  /// Sets whether an item may block the hand, and whether its data are available; both are true at the start.
  /// A touchable item that is not ready lets the hand through, and the next tick emits an event.
  void set_touchable(int item, bool is_touchable) noexcept { untouchable.set(item, !is_touchable); }
  void set_ready(int item, bool is_ready) noexcept;
  /// Sets the voxels of a shape with available bits (low > high: no voxel): the shape is ready while hand and
  /// proxy are within them, a few voxels off their border. For k_max_parts items at a time; a further one is
  /// not ready at all.
  void set_ready(int item, const volume::VoxelBox& voxels) noexcept;
  /// Sets the placement of a moving mesh.
  void set_placement(int mover, const Placement& placement) noexcept;

  static constexpr std::size_t k_max_parts = 8;
  struct Part {  ///< available part of an item
    int item;
    volume::VoxelBox voxels;
  };
  ShapeSet untouchable, not_ready;
  ShapeSet passable_items;  ///< items that do not block the hand's instrument now
  std::array<Part, k_max_parts> parts;
  std::size_t part_count = 0;
  std::array<Placement, TouchScene::k_max_movers> placements;
  std::size_t placement_count = 0;  ///< number of placements set, from the first on; others are initial
  /// A moving mesh held by a hand, which moves with the hand's pose of the previous tick. It is at its
  /// placement while that pose is unknown.
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
  bool has_held = false;  ///< some hand touches a mesh that another one holds
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
