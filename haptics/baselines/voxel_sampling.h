// VoxelSampling, DynamicTool: published six-degree-of-freedom contact of a point shell with a VoxMap, and the
// rigid body that it moves.
#pragma once

#include <array>

#include "haptics/baselines/voxmap.h"
#include "haptics/force/coupling.h"
#include "haptics/tool/pose_contact.h"

namespace trephine::haptics::baselines {

/// Tangent-plane forces (McNeely, Puterbaugh and Troy 1999; Kadlecek 2013, master thesis, eq. 3.1 to
/// 3.5): the force on a point is along its inward normal, and proportional to a depth. In a proximity voxel
/// this is the depth below the tangent plane through the voxel's centre, at most half a voxel. In a surface
/// voxel it is half a voxel. In the interior there is no force, so that a tool that is pressed hard passes
/// through. Borrows map and shell.
class VoxelSampling final : public PoseContact {
 public:
  struct Options {
    double stiffness = 0.5;  ///< N/mm per point
    /// From this number of pushing points on, the force is their mean force times this number (eq. 3.5). 0:
    /// the force is always the sum.
    int averaging_threshold = 10;
  };
  VoxelSampling(const VoxMap& map, const PointShell& shell, const Options& options) noexcept
      : map_(map), shell_(shell), options_(options) {}
  VoxelSampling(const VoxMap& map, const PointShell& shell) noexcept : VoxelSampling(map, shell, Options()) {}

  /// Sums the forces in the order of the points. `uses_tree` false: tests all points; the result is the same,
  /// to the bit, except for `tests`.
  PoseForce contact(const Placement& tool, bool uses_tree) const noexcept;
  PoseForce contact(const Placement& tool) const noexcept override { return contact(tool, true); }
  const PointShell& shell() const noexcept override { return shell_; }

 private:
  const VoxMap& map_;
  const PointShell& shell_;
  Options options_;
};

/// Integration of the tool's motion (eq. 3.10 to 3.19; Otaduy and Lin 2006 for the linearised implicit one).
enum class Integrator : std::uint8_t { explicit_euler, semi_implicit, implicit };

/// A tool with mass, tied to the hand by a virtual coupling (Colgate, Stanley and Brown 1995) and pushed by
/// contact. Plain data, except for the borrowed method of contact.
class DynamicTool {
 public:
  struct Options {
    Integrator integrator = Integrator::semi_implicit;
    double mass = 0.025;        ///< kg
    double sphere_radius = 20;  ///< mm, of a sphere with the tool's moment of inertia (eq. 3.7)
    /// Critically damped; passive at 1 kHz on a device with a damping of 0.008 N s/mm.
    Coupling coupling{0.59, 0.00768};
    double turning_stiffness = 300;  ///< N mm/rad; its damping is critical (eq. 3.22)
    /// Reduces the turning stiffness while part of the contact torque has no matching force, as of a lever
    /// between two contacts. A device without torque cannot render that part: the hand would turn the tool
    /// into the matter (Kadlecek 2013, 3.7).
    bool limits_missing_torque = false;
    double least_turning_stiffness = 10;  ///< N mm/rad, while the torque is limited
  };
  DynamicTool(const PoseContact& contact, const Options& options, double dt) noexcept;

  /// Runs one tick. The first tick sets the tool to the placement of the hand.
  void step(const Placement& hand) noexcept;
  const Placement& pose() const noexcept { return tool_; }
  const Wrench& on_hand() const noexcept { return on_hand_; }
  const PoseForce& contact() const noexcept { return force_; }

 private:
  void judge_torque() noexcept;

  const PoseContact& contact_;
  Options options_;
  double dt_, inertia_;  ///< s; kg mm2
  Placement hand_, tool_;
  glm::dvec3 velocity_{0.0}, spin_{0.0};  ///< mm/s, rad/s
  Wrench on_hand_;
  PoseForce force_;
  std::array<double, 32> torques_{};  ///< N mm, of the last ticks, for the moving average
  std::size_t tick_ = 0;
  double forceless_torque_share_ = 0;  ///< 0 to 1, part of the contact's torque that comes without force
};

}  // namespace trephine::haptics::baselines
