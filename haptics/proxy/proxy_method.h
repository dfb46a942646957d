// The interface of every way to keep a proxy on a surface.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <glm/vec3.hpp>

#include "haptics/scene/shape_set.h"
#include "haptics/scene/touch_scene.h"
#include "haptics/scene/touch_state.h"

namespace trephine::haptics {

/// Work done in one step; independent of the volume's size.
struct ProxyCounters {
  int voxels = 0;      ///< visited by traversals
  int cells = 0;       ///< read for fields and normals
  int iterations = 0;  ///< collision queries
  int triangles = 0;   ///< made or read
};

/// The plane that method `plane` touches between two looks at the volume.
struct PlaneMemory {
  glm::dvec3 point_world{0.0}, normal_world{0.0};
  double recovery = 0;  ///< mm that are given back over the next ticks
  int shape = -1, age = 0, recovery_left = 0;
};

/// Surroundings of a proxy, touched or not.
struct Surroundings {
  ShapeSet let_through;  ///< shapes that hold nothing now, whatever the scene says; set by the host
  ShapeSet fresh;        ///< models that no step has seen where they are; set by the host
  /// For scenes of many shapes: those within near_radius mm of near_middle; none are known where that is 0.
  ShapeSet near;
  glm::dvec3 near_middle_world{0.0};
  double near_radius = 0;
  bool has_placements = false;
  std::array<Placement, TouchScene::k_max_movers> placements;  ///< of moving meshes, in the last step
  double time = 0;                                             ///< s, of the last step
  std::array<std::uint64_t, TouchScene::k_max_depths> sets{};  ///< of depth images, in the last step
};

/// State of a method between steps. Plain data: copying it saves and restores a method.
struct ProxyState {
  bool has_proxy = false;
  glm::dvec3 proxy_volume{0.0};
  ShapeSet inside;            ///< shapes in whose solid the proxy lies (touched from the back)
  bool had_contact = false;   ///< in the last step
  bool is_sticking = false;   ///< static friction holds
  int touched = -1;           ///< the moving mesh that held the proxy in the last step; -1: none
  std::uint64_t version = 0;  ///< the last one seen, for methods that look for growth only where it may be
  PlaneMemory plane;
  bool has_turn = false;             ///< of a tool of several balls:
  glm::dquat tool_turn{1, 0, 0, 0};  ///< how it is turned
  std::uint32_t balls_inside = 0;    ///< those that lie in a solid, a bit each
  bool has_on_meshes = false;
  glm::dvec3 on_meshes_world{0.0};  ///< the god-object on meshes of method scene-sequential
  Surroundings around;

  /// As if it had never touched; what is around it stays.
  void forget() noexcept {
    const Surroundings kept = around;
    *this = ProxyState{};
    around = kept;
  }
  /// Starts at a place.
  void begin_at(const glm::dvec3& place_volume) noexcept {
    forget();
    has_proxy = true;
    proxy_volume = place_volume;
  }
};

/// Does this side of the shape hold a proxy now?
inline bool holds(const TouchScene& scene, const ShapeSet& let_through, int shape, Side side) noexcept {
  return holds(item_of(scene, shape).sides, side) && !let_through.contains(shape);
}

struct ProxyInput {
  glm::dvec3 hip_world{0.0};  ///< haptic interface point, mm; finite
  std::span<const Placement> movers =
      {};                              ///< where the scene's moving meshes are now; empty: where they start
  glm::dquat orientation{1, 0, 0, 0};  ///< of the hand
  double time = 0;                     ///< s since the operation began
};

/// Longest path a step reports: start, and two points an iteration, and the end.
inline constexpr int k_max_iterations = 8;
inline constexpr int k_max_waypoints = 32;

/// A contact of a tool of several balls.
struct ToolContact {
  glm::dvec3 place_world, normal_world;  ///< toward the tool
  double push;                           ///< mm: times the stiffness the force
  int shape;
  Side side;
};

/// A few of them; a copy takes no longer than there are.
class ToolContacts {
 public:
  static constexpr std::size_t k_most = 8;
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
  /// Keeps the hardest contacts where there are too many.
  void add(const ToolContact& one) noexcept {
    if (count_ < k_most) {
      all_[count_++] = one;
      return;
    }
    auto* least = std::min_element(
        all_.begin(), all_.end(), [](const ToolContact& a, const ToolContact& b) { return a.push < b.push; });
    if (one.push > least->push) *least = one;
  }
  void clear() noexcept { count_ = 0; }

 private:
  std::size_t count_ = 0;
  std::array<ToolContact, k_most> all_;
};

/// Result of a step, without path and contacts.
struct ProxyAnswer {
  glm::dvec3 proxy_world{0.0};
  glm::dvec3 normal_world{0.0};  ///< unit, toward the side of the proxy; 0 without contact
  bool has_contact = false;
  int shape = -1;  ///< the touched item
  Side side = Side::none;
  /// Matter grew over the proxy, which was set free at the HIP, or a mesh that moves passed over it, where
  /// others left it no way out: no force in this step.
  bool is_buried = false;
  glm::dvec3 carried_world{
      0.0};  ///< mm that what is touched moved by, there, since the last step; method `scene`
  glm::dvec3 turn_world{
      0.0};  ///< as turn_between() gives it, from the hand to the tool; of tools of several balls
  int waypoint_count = 0;
  ProxyCounters counters;

  void set_contact(int item, Side touched, const glm::dvec3& normal) noexcept {
    has_contact = true;
    shape = item;
    side = touched;
    normal_world = normal;
  }
};

/// A copy takes no longer than its lists are.
struct ProxyStep : ProxyAnswer {
  std::array<glm::dvec3, k_max_waypoints>
      path_volume;        ///< from the old proxy to the new one, each leg checked
  ToolContacts contacts;  ///< of a tool of several balls; of others what stands above is the only one

  ProxyStep() noexcept = default;
  ProxyStep(const ProxyStep& other) noexcept : ProxyAnswer(other), contacts(other.contacts) {
    std::copy_n(other.path_volume.begin(), waypoint_count, path_volume.begin());
  }
  ProxyStep& operator=(const ProxyStep& other) noexcept {
    ProxyAnswer::operator=(other);
    contacts = other.contacts;
    std::copy_n(other.path_volume.begin(), waypoint_count, path_volume.begin());
    return *this;
  }
  /// There must be room: k_max_waypoints holds the longest path of every method.
  void add_waypoint(const glm::dvec3& p_volume) noexcept {
    path_volume[static_cast<std::size_t>(waypoint_count++)] = p_volume;
  }
};

/// The first step, and one that lets the proxy go: it is where the hand is.
inline void begin_at_hip(const glm::dvec3& hip_volume, const glm::dvec3& hip_world, ProxyState& state,
                         ProxyStep& step) noexcept {
  state.begin_at(hip_volume);
  step.proxy_world = hip_world;
  step.add_waypoint(hip_volume);
}

/// Few enough shapes of one volume, each with its bits: what most methods ask of a scene. Error also for a
/// tool with a radius, or meshes, where the method has none.
volume::Status check_touchable(const TouchScene& scene, bool has_radius = false, bool has_meshes = false);
/// For methods that a point feels cuts by only if they are no narrower than `least` mm: error when the scene
/// is ready for smaller burrs.
volume::Status check_smallest_burr(const TouchScene& scene, double least_mm);
/// Check for methods on whole voxels: a hole as wide as a voxel's diagonal holds a centre everywhere.
volume::Status check_burr_opens_voxels(const TouchScene& scene);
/// For methods that touch what was there at first: error when the scene is ready to be cut.
volume::Status check_stays_whole(const TouchScene& scene, const char* method);
/// Check for methods with fixed models: error when one is touched by depth images that change.
volume::Status check_has_no_depth(const TouchScene& scene);
/// Has a scene whose tool has a radius the offset fields for it? Error also for a tool of several balls,
/// where the method is for one.
volume::Status check_offsets(const TouchScene& scene, bool has_balls = false);

class ProxyMethod {
 public:
  virtual ~ProxyMethod() = default;
  virtual const char* name() const noexcept = 0;
  /// Allocates whatever step() will need. Not for the servo thread.
  virtual volume::Status prepare(const TouchScene& scene) = 0;
  /// One servo step on one immutable state. Servo thread: no allocation, lock or exception; iterations are
  /// bounded.
  virtual ProxyStep step(const TouchScene& scene, const TouchState& seen, ProxyState& state,
                         const ProxyInput& input) const noexcept = 0;
};

}  // namespace trephine::haptics
