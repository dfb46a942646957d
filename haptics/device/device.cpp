#include "haptics/device/device.h"

#include <cmath>
#include <glm/geometric.hpp>

namespace trephine::haptics {

void SimulatedHand::rest_at(const glm::dvec3& position) noexcept {
  position_ = position;
  velocity_ = yield_ = yield_rate_ = glm::dvec3(0);
}

void SimulatedHand::step(const Pose& request, const glm::dvec3& request_velocity, const Wrench& wrench,
                         double dt) noexcept {
  // 1 N = 1000 kg mm/s^2. Damping and stiffness are integrated implicitly, so that a stiff hand stays
  // stable at low rates.
  const double unit = 1000 / model_.mass;
  const glm::dvec3 drive = wrench.force_world + model_.stiffness * (request.position_world - position_) +
                           model_.damping * request_velocity;
  velocity_ = (velocity_ + unit * dt * drive) /
              (1 + unit * dt * (model_.damping + model_.device_damping + dt * model_.stiffness));
  position_ += dt * velocity_;
  const glm::dvec3 turning = wrench.torque_world / (model_.grip * model_.grip) - model_.stiffness * yield_;
  yield_rate_ =
      (yield_rate_ + unit * dt * turning) / (1 + unit * dt * (model_.damping + dt * model_.stiffness));
  yield_ += dt * yield_rate_;
}

Pose SimulatedHand::pose(const Pose& request) const noexcept {
  Pose pose = request;
  pose.position_world = position_;
  if (yield_ != glm::dvec3(0))
    pose.orientation = glm::normalize(glm::dquat(1, 0.5 * yield_) * unit_of(request.orientation));
  if (model_.encoder_step > 0)
    for (int a = 0; a < 3; ++a)
      pose.position_world[a] = model_.encoder_step * std::floor(position_[a] / model_.encoder_step + 0.5);
  return pose;
}

double SimulatedHand::kinetic_energy() const noexcept {
  return 0.5 * model_.mass * glm::dot(velocity_, velocity_) / 1000;
}

VirtualDevice::VirtualDevice(PosePath request, const HandModel& hand)
    : request_(std::move(request)), hand_(hand), simulated_(hand) {
  simulated_.rest_at(request_.samples().front().pose.position_world);
}

Status VirtualDevice::open() {
  simulated_.rest_at(request_.samples().front().pose.position_world);
  wrench_ = Wrench();
  time_ = 0;
  return std::nullopt;
}

bool VirtualDevice::read(double t, Pose& pose) noexcept {
  if (t >= lost_from_) return false;
  const double dt = t - time_;
  const Pose request = request_.at(request_.start_time() + t);
  if (dt > 0) {
    const glm::dvec3 previous = request_.at(request_.start_time() + time_).position_world;
    simulated_.step(request, (request.position_world - previous) / dt, wrench_, dt);
    time_ = t;
  }
  pose = simulated_.pose(request);
  return true;
}

bool Recorder::read(double t, Pose& pose) noexcept {
  if (!device_->read(t, pose)) return false;
  if (samples_.size() == samples_.capacity() || (!samples_.empty() && t <= samples_.back().t))
    ++dropped_;
  else
    samples_.push_back({t, pose});
  return true;
}

}  // namespace trephine::haptics
