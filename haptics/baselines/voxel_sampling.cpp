#include "haptics/baselines/voxel_sampling.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "haptics/device/pose_path.h"
#include "volume/scan/traversal.h"

namespace trephine::haptics::baselines {

using glm::dvec3;
using glm::ivec3;

PoseForce VoxelSampling::contact(const Placement& tool, bool uses_tree) const noexcept {
  PoseForce contact;
  const glm::dmat3 rotation = glm::mat3_cast(tool.rotation);
  const double voxel = map_.voxel_mm();
  const volume::Frame& frame = map_.frame();
  dvec3 force(0), torque(0);
  const auto for_points = [&](auto&& use) {
    const auto use_point = [&](std::uint32_t i) {
      ++contact.tests;
      const PointShell::Point& point = shell_.points()[i];
      const dvec3 arm = rotation * point.position, p = frame.volume_from_world(tool.position_world + arm);
      const ivec3 v = volume::voxel_of(p);
      const VoxMap::Voxel type = map_.at(v);
      if (type == VoxMap::Voxel::interior) ++contact.interior;
      if (type != VoxMap::Voxel::proximity && type != VoxMap::Voxel::surface) return true;
      const dvec3 inward = rotation * point.inward;
      const double depth =
          type == VoxMap::Voxel::surface
              ? 0.5 * voxel
              : std::clamp(glm::dot(inward, frame.vector_world_from_volume(dvec3(v) - p)), 0.0, 0.5 * voxel);
      if (depth > 0) use(arm, (options_.stiffness * depth) * inward);
      return true;
    };
    if (!uses_tree) {
      for (std::uint32_t i = 0; i < shell_.points().size(); ++i) use_point(i);
      return;
    }
    shell_.visit(
        [&](const PointShell::Node& node) {
          ++contact.tests;
          const dvec3 p = frame.volume_from_world(tool.position_world + rotation * node.centre);
          const double reach = node.radius / voxel + 1e-9;
          return map_.is_free(volume::voxel_of(p - reach), volume::voxel_of(p + reach));
        },
        use_point);
  };
  for_points([&](const dvec3& arm, const dvec3& push) {
    ++contact.points;
    force += push;
    torque += glm::cross(arm, push);
  });
  const double scale = options_.averaging_threshold > 0 && contact.points >= options_.averaging_threshold
                           ? static_cast<double>(options_.averaging_threshold) / contact.points
                           : 1;
  contact.set(scale * force, scale * torque);
  return contact;
}

DynamicTool::DynamicTool(const PoseContact& contact, const Options& options, double dt) noexcept
    : contact_(contact),
      options_(options),
      dt_(dt),
      inertia_(0.4 * options.mass * options.sphere_radius * options.sphere_radius) {}

/// Computes the share of the contact's mean torque that its force could not cause, even if it acted at the
/// end of the tool. Such a torque arises if the tool is a lever between two contacts.
void DynamicTool::judge_torque() noexcept {
  torques_[tick_++ % torques_.size()] = glm::length(force_.on_tool.torque_world);
  double mean = 0;
  for (const double torque : torques_) mean += torque / static_cast<double>(torques_.size());
  const double good = glm::length(force_.perpendicular) * contact_.shell().arm();
  forceless_torque_share_ = mean > 0 ? std::clamp(1 - good / mean, 0.0, 1.0) : 0;
}

void DynamicTool::step(const Placement& hand) noexcept {
  if (tick_ == 0) tool_ = hand_ = hand;
  force_ = contact_.contact(tool_);
  judge_torque();
  const dvec3 hand_velocity = (hand.position_world - hand_.position_world) / dt_,
              hand_spin = turn_between(hand_.rotation, hand.rotation) / dt_;
  hand_ = hand;
  const double share = options_.limits_missing_torque ? forceless_torque_share_ : 0;
  const double k = options_.coupling.stiffness, b = options_.coupling.damping,
               k_turn = (1 - share) * options_.turning_stiffness + share * options_.least_turning_stiffness,
               b_turn = 2 * std::sqrt(k_turn * inertia_ / k_mm_s2_per_n_kg);
  const double h = k_mm_s2_per_n_kg * dt_ / options_.mass, h_turn = k_mm_s2_per_n_kg * dt_ / inertia_;
  const dvec3 force = k * (hand.position_world - tool_.position_world) + b * (hand_velocity - velocity_),
              torque = k_turn * turn_between(tool_.rotation, hand.rotation) + b_turn * (hand_spin - spin_);
  on_hand_ = Wrench(-force, -torque);
  const dvec3 change = h * (force + force_.on_tool.force_world),
              change_turn = h_turn * (torque + force_.on_tool.torque_world);
  const dvec3 old_velocity = velocity_, old_spin = spin_;
  if (options_.integrator == Integrator::implicit) {
    // (M - dt dF/dv - dt^2 dF/dx) dv = dt (F + dt dF/dx v), for the coupling alone.
    velocity_ += (change - h * k * dt_ * velocity_) / (1 + h * (b + k * dt_));
    spin_ += (change_turn - h_turn * k_turn * dt_ * spin_) / (1 + h_turn * (b_turn + k_turn * dt_));
  } else {
    velocity_ += change;
    spin_ += change_turn;
  }
  const bool is_explicit = options_.integrator == Integrator::explicit_euler;
  tool_.position_world += dt_ * (is_explicit ? old_velocity : velocity_);
  const dvec3 turn = (0.5 * dt_) * (is_explicit ? old_spin : spin_);
  tool_.rotation = glm::normalize(glm::dquat(1, turn.x, turn.y, turn.z) * tool_.rotation);
}

}  // namespace trephine::haptics::baselines
