#include "apps/workbench/virtual_device.h"

#include <chrono>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numeric>

#include "haptics/servo/servo_loop.h"

namespace trephine::workbench {

namespace {

using Clock = std::chrono::steady_clock;

/// Returns the mean of values, and the mean plus their standard deviation.
std::pair<double, double> mean_and_noise(const std::vector<double>& values) {
  const auto n = static_cast<double>(values.size());
  const double mean = std::accumulate(values.begin(), values.end(), 0.0) / n;
  double squares = 0;
  for (const double value : values) squares += (value - mean) * (value - mean);
  return {mean, mean + std::sqrt(squares / n)};
}

bool is_finite(const haptics::Wrench& wrench) {
  for (int a = 0; a < 3; ++a)
    if (!std::isfinite(wrench.force_world[a]) || !std::isfinite(wrench.torque_world[a])) return false;
  return true;
}

}  // namespace

VirtualDeviceHost::VirtualDeviceHost(const VirtualDeviceOptions& options)
    : options_(options), hand_(options.hand) {}

Result<std::unique_ptr<VirtualDeviceHost>> VirtualDeviceHost::open(const VirtualDeviceOptions& options) {
  std::unique_ptr<VirtualDeviceHost> host(new VirtualDeviceHost(options));
  auto memory = haptics::SharedDeviceMemory::create(options.index);
  if (!memory) return memory.error();
  host->memory_ = std::move(memory).value();
  host->user_.buttons = 0;
  if (options.motion) host->user_ = options.motion->at(options.motion->start_time());
  host->state_.request = host->state_.pose = host->user_;
  host->hand_.rest_at(host->user_.position_world);
  host->is_recording_ = options.record_seconds > 0;
  if (host->is_recording_)
    host->recording_.reserve(static_cast<std::size_t>(1000 * options.record_seconds) + 1);
  host->thread_ = std::thread([raw = host.get()] { raw->run(); });
  return host;
}

VirtualDeviceHost::~VirtualDeviceHost() {
  {
    const std::lock_guard guard(lock_);
    is_stopping_ = true;
  }
  if (thread_.joinable()) thread_.join();
  if (options_.attached) options_.attached->write({});
}

void VirtualDeviceHost::request(const haptics::Pose& pose) {
  const std::lock_guard guard(lock_);
  user_ = pose;
}

VirtualDeviceHost::State VirtualDeviceHost::state() const {
  const std::lock_guard guard(lock_);
  return state_;
}

std::vector<WrenchInterval> VirtualDeviceHost::intervals() const {
  const std::lock_guard guard(lock_);
  return {intervals_.begin(), intervals_.end()};
}

Result<haptics::PosePath> VirtualDeviceHost::recording() {
  const std::lock_guard guard(lock_);
  is_recording_ = false;
  return haptics::PosePath::from_samples(recording_, "recording");
}

void VirtualDeviceHost::run() {
  constexpr int k_priority = 70;  // below a servo's
  haptics::request_realtime(k_priority);
  constexpr auto k_period = std::chrono::milliseconds(1);
  const auto begin = Clock::now();
  auto next = begin;
  double last = 0;
  for (;;) {
    const double t = std::chrono::duration<double>(Clock::now() - begin).count();
    {
      const std::lock_guard guard(lock_);
      if (is_stopping_) return;
      constexpr double k_longest_step = 0.01;  // s, after a pause of the process
      if (t > last) step(t, std::min(t - last, k_longest_step));
      last = t;
    }
    next = std::max(next + k_period, Clock::now() - k_period);
    std::this_thread::sleep_until(next);
  }
}

/// Advances to time t. Requires the lock.
void VirtualDeviceHost::step(double t, double dt) {
  constexpr double k_silent = 0.05;  // s
  if (const auto shared = memory_->wrench(); shared && shared->count != wrench_count_) {
    wrench_count_ = shared->count, wrench_time_ = t;
    state_.wrench = haptics::Wrench({shared->force[0], shared->force[1], shared->force[2]},
                                    {shared->torque[0], shared->torque[1], shared->torque[2]});
  }
  state_.is_connected = t - wrench_time_ <= k_silent;
  if (!state_.is_connected || !is_finite(state_.wrench)) state_.wrench = {};

  // Poses of the user change with each event of the mouse; the request follows them smoothly.
  constexpr double k_smoothing = 0.03;  // s
  haptics::Pose request = user_;
  const double share = dt / (dt + k_smoothing);
  request.position_world = glm::mix(state_.request.position_world, user_.position_world, share);
  request.orientation =
      glm::slerp(haptics::unit_of(state_.request.orientation), haptics::unit_of(user_.orientation), share);
  state_.is_playing = options_.motion && t < options_.motion->end_time() - options_.motion->start_time();
  if (options_.motion) request = options_.motion->at(options_.motion->start_time() + t);
  if (options_.attached) {
    // The hand that holds the real device yields to its forces; nothing is simulated.
    options_.attached->read(t, request);
    options_.attached->write(state_.wrench);
    state_.pose = request;
  } else {
    const glm::dvec3 velocity = (request.position_world - state_.request.position_world) / dt;
    hand_.step(request, velocity, state_.wrench, dt);
    state_.pose = hand_.pose(request);
  }
  state_.request = request;
  state_.seconds = t;
  haptics::SharedPose shared{++pose_count_, {}, {}, state_.pose.buttons};
  const glm::dquat& q = state_.pose.orientation;
  for (int a = 0; a < 3; ++a) shared.position[a] = state_.pose.position_world[a];
  shared.orientation[0] = q.w, shared.orientation[1] = q.x, shared.orientation[2] = q.y,
  shared.orientation[3] = q.z;
  memory_->set_pose(shared);
  if (is_recording_ && recording_.size() < recording_.capacity()) recording_.push_back({t, state_.pose});

  forces_.push_back(glm::length(state_.wrench.force_world));
  torques_.push_back(glm::length(state_.wrench.torque_world));
  constexpr std::size_t k_ticks = 20;  // of an interval
  if (forces_.size() < k_ticks) return;
  const auto [force, noisy_force] = mean_and_noise(forces_);
  const auto [torque, noisy_torque] = mean_and_noise(torques_);
  if (intervals_.size() == k_intervals) intervals_.pop_front();
  intervals_.push_back({force, noisy_force, torque, noisy_torque});
  forces_.clear(), torques_.clear();
}

}  // namespace trephine::workbench
