// ProxyState, ProxyInput, ProxyStep: state, input and result of a step of a contact method.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <glm/vec3.hpp>

#include "haptics/scene/shape_set.h"
#include "haptics/scene/touch_scene.h"

namespace trephine::haptics {

/// Counts of the work in one step, which does not depend on the volume's size.
struct ProxyCounters {
  int voxels = 0;      ///< voxels visited by traversals; also tested points of a shell
  int cells = 0;       ///< cells read for fields and normals; also tested nodes of a shell
  int iterations = 0;  ///< collision queries, Newton steps or rounds, as the method uses them
  int triangles = 0;   ///< triangles extracted or read
};

/// Plane that method `plane` renders between two searches of the volume.
struct PlaneMemory {
  glm::dvec3 point_world{0.0}, normal_world{0.0};
  double recovery = 0;  ///< mm, jump from the previous plane, reduced to zero over the next ticks
  int shape = -1;
  int age = 0, recovery_left = 0;  ///< ticks since the first search; ticks until the jump is 0
};

/// Data about the items around a proxy, touched or not, that are kept between steps.
struct Surroundings {
  ShapeSet passable;  ///< shapes that do not block now, whatever the scene's sides; set by the host
  /// Models that were added and may overlap the proxy. Set by the host, cleared by a step.
  ShapeSet new_models;
  /// Shapes within near_radius mm of near_middle_world, for scenes of many shapes; not computed while
  /// near_radius is 0.
  ShapeSet nearby;
  glm::dvec3 near_middle_world{0.0};
  double near_radius = 0;
  bool has_placements = false;
  std::array<Placement, TouchScene::k_max_movers> placements;  ///< of moving meshes, in the last step
  double time = 0;                                             ///< s, of the last step
  std::array<std::uint64_t, TouchScene::k_max_depths> sets{};  ///< serials of the last depth images
};

/// State of a method between steps. Plain data: copying it saves and restores a method.
struct ProxyState {
  bool has_proxy = false;
  glm::dvec3 proxy_volume{0.0};
  ShapeSet inside;           ///< shapes with the proxy in their solid (touched from the back)
  bool had_contact = false;  ///< in the last step
  bool is_sticking = false;  ///< static friction holds
  int touched_mover = -1;    ///< moving mesh that stopped the proxy in the last step; -1: no such mesh
  /// Serial of the version in the last step. Methods test for grown matter only after it has changed.
  std::uint64_t version = 0;
  PlaneMemory plane;
  bool has_turn = false;             ///< tool_turn is set, for a tool with six degrees of freedom
  glm::dquat tool_turn{1, 0, 0, 0};  ///< rotation of the tool
  /// Balls in a solid, one bit each. For a shell: number of points in a solid.
  std::uint32_t balls_inside = 0;
  bool has_mesh_proxy = false;
  glm::dvec3 mesh_proxy_world{0.0};  ///< the god-object on meshes of method scene-sequential
  Surroundings around;

  /// Clears all state except the surroundings.
  void reset_except_surroundings() noexcept {
    const Surroundings kept = around;
    *this = ProxyState{};
    around = kept;
  }
  /// Clears all state except the surroundings, and sets the proxy to a point.
  void begin_at(const glm::dvec3& point_volume) noexcept {
    reset_except_surroundings();
    has_proxy = true;
    proxy_volume = point_volume;
  }
};

/// Returns true if this side of the shape blocks a proxy now.
inline bool blocks(const TouchScene& scene, const ShapeSet& passable, int shape, Side side) noexcept {
  return blocks(item_of(scene, shape).sides, side) && !passable.contains(shape);
}

struct ProxyInput {
  glm::dvec3 hip_world{0.0};  ///< haptic interface point, mm; at most 1e6 along each axis
  std::span<const Placement> movers =
      {};  ///< current placements of the scene's moving meshes; empty: the initial ones
  glm::dquat orientation{1, 0, 0, 0};  ///< of the hand
  double time = 0;                     ///< s since the operation began
};

/// Largest number of collision queries in a step of method `implicit`.
inline constexpr int k_max_iterations = 8;
/// Largest number of points on the path of a step, for all methods.
inline constexpr int k_max_waypoints = 32;

/// A contact of a tool with six degrees of freedom.
struct ToolContact {
  glm::dvec3 point_world, normal_world;  ///< mm; unit, toward the tool
  double push;                           ///< mm; the force is the push times the stiffness
  int shape;
  Side side;
};

/// At most k_max contacts. The cost of a copy is that of the contacts in it.
class ToolContacts {
 public:
  static constexpr std::size_t k_max = 8;
  ToolContacts() noexcept = default;
  ToolContacts(const ToolContacts& other) noexcept : count_(other.count_) {
    std::copy_n(other.all_.begin(), count_, all_.begin());
  }
  ToolContacts& operator=(const ToolContacts& other) noexcept {
    count_ = other.count_;
    std::copy_n(other.all_.begin(), count_, all_.begin());
    return *this;
  }
  std::size_t size() const noexcept { return count_; }
  const ToolContact& operator[](std::size_t i) const noexcept { return all_[i]; }
  /// Adds a contact. If there are more than k_max, keeps those with the largest push.
  void add(const ToolContact& contact) noexcept {
    if (count_ < k_max) {
      all_[count_++] = contact;
      return;
    }
    auto* least = std::min_element(
        all_.begin(), all_.end(), [](const ToolContact& a, const ToolContact& b) { return a.push < b.push; });
    if (contact.push > least->push) *least = contact;
  }
  void clear() noexcept { count_ = 0; }

 private:
  std::size_t count_ = 0;
  std::array<ToolContact, k_max> all_;
};

/// Result of a step, without path and contacts.
struct ProxyResult {
  glm::dvec3 proxy_world{0.0};
  glm::dvec3 normal_world{0.0};  ///< unit, toward the side of the proxy; 0 without contact
  bool has_contact = false;
  int shape = -1;  ///< the touched item
  Side side = Side::none;
  /// Restored matter covered the proxy, which then started again at the HIP; or a moving mesh passed over the
  /// proxy, because other walls left no free position. There is no force in this step.
  bool is_buried = false;
  /// Motion of the touched object at the contact since the last step, mm. Only method `scene` sets it.
  glm::dvec3 object_motion_world{0.0};
  /// Rotation from the hand to a tool with six degrees of freedom: axis times 2 sin(angle / 2).
  glm::dvec3 turn_world{0.0};
  int waypoint_count = 0;
  ProxyCounters counters;

  void set_contact(int item, Side touched, const glm::dvec3& normal) noexcept {
    has_contact = true;
    shape = item;
    side = touched;
    normal_world = normal;
  }
};

/// Result of a step. The cost of a copy is that of the points and contacts in it.
struct ProxyStep : ProxyResult {
  /// Points from the old proxy to the new one; each leg between them was checked.
  std::array<glm::dvec3, k_max_waypoints> path_volume;
  /// Contacts of a tool with six degrees of freedom; other tools have only the contact of ProxyResult.
  ToolContacts contacts;

  ProxyStep() noexcept = default;
  ProxyStep(const ProxyStep& other) noexcept : ProxyResult(other), contacts(other.contacts) {
    std::copy_n(other.path_volume.begin(), waypoint_count, path_volume.begin());
  }
  ProxyStep& operator=(const ProxyStep& other) noexcept {
    ProxyResult::operator=(other);
    contacts = other.contacts;
    std::copy_n(other.path_volume.begin(), waypoint_count, path_volume.begin());
    return *this;
  }
  /// Requires fewer than k_max_waypoints points.
  void add_waypoint(const glm::dvec3& p_volume) noexcept {
    path_volume[static_cast<std::size_t>(waypoint_count++)] = p_volume;
  }
};

/// Sets the proxy to the HIP, in the first step or after matter has grown over the proxy.
inline void begin_at_hip(const glm::dvec3& hip_volume, const glm::dvec3& hip_world, ProxyState& state,
                         ProxyStep& step) noexcept {
  state.begin_at(hip_volume);
  step.proxy_world = hip_world;
  step.add_waypoint(hip_volume);
}

}  // namespace trephine::haptics
