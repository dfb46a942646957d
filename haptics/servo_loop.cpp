#include "haptics/servo_loop.h"

#include <cmath>
#include <pmmintrin.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <time.h>

namespace trephine::haptics {

using glm::dvec3;

namespace {

constexpr double k_farthest_mm = 1e6;  // a pose beyond this is a broken device, not a place

bool is_place(const dvec3& p) noexcept {
  for (int a = 0; a < 3; ++a)
    if (!(std::abs(p[a]) <= k_farthest_mm)) return false;
  return true;
}

std::int64_t now_ns() noexcept {
  timespec t{};
  clock_gettime(CLOCK_MONOTONIC, &t);
  return static_cast<std::int64_t>(t.tv_sec) * 1'000'000'000 + t.tv_nsec;
}

void sleep_until(std::int64_t ns) noexcept {
  const timespec t{ns / 1'000'000'000, ns % 1'000'000'000};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, nullptr) != 0) {}
}

}  // namespace

ServoCore::ServoCore(const TouchScene& scene, const ProxyMethod& method, const ForceOptions& options,
                     double dt)
    : scene_(&scene), method_(&method), force_(options, dt), guard_(options, dt) {}

ServoRecord ServoCore::step(const volume::Version& version, const Pose& pose, double t,
                            std::uint32_t faults) noexcept {
  ServoRecord record;
  record.tick = tick_++;
  record.t = t;
  record.version = version.serial();
  record.pose = pose;
  dvec3 wanted(0);
  if (is_place(pose.position_world)) {
    step_ = method_->step(*scene_, version, state_, {pose.position_world});
    wanted = force_.step(step_, pose.position_world, *scene_);
    record.proxy_world = step_.proxy_world;
    record.normal_world = step_.normal_world;
    record.has_contact = step_.has_contact;
    record.is_buried = step_.is_buried;
    record.shape = step_.shape;
    record.side = step_.side;
  } else {
    record.pose.position_world = dvec3(0);
    faults |= fault_not_finite;
  }
  record.force_world = guard_.step(wanted, faults);
  record.faults = guard_.faults();
  // Without a force there is no hand on the tool: nothing is cut.
  if (record.faults & k_latched_faults) record.pose.is_pressed = false;
  return record;
}

void ServoCore::restart_at(const dvec3& free_point_volume) noexcept {
  state_ = ProxyState{};
  state_.has_proxy = true;
  state_.proxy_volume = free_point_volume;
  force_.reset();
}

void ServoCore::reset() noexcept {
  state_ = ProxyState{};
  force_.reset();
  guard_.reset();
}

ServoLoop::ServoLoop(Device& device, volume::VersionChannel& channel, const TouchScene& scene,
                     const ProxyMethod& method, const ServoOptions& options)
    : device_(&device),
      channel_(&channel),
      options_(options),
      core_(scene, method, options.force, 1 / options.rate_hz),
      ring_(options.ring_capacity) {}

ServoLoop::~ServoLoop() { stop(); }

volume::Status ServoLoop::start() {
  if (!(options_.rate_hz >= 250 && options_.rate_hz <= 10000))
    return volume::Error{"the servo rate is out of range", "", std::to_string(options_.rate_hz) + " Hz",
                         "250 to 10000 Hz", ""};
  if (volume::Status error = device_->open()) return error;
  reader_ = channel_->open_reader();
  if (reader_ < 0) {
    device_->close();
    return volume::Error{"too many servo loops read one scene", "", "",
                         "at most " + std::to_string(volume::VersionChannel::k_readers),
                         "stop another loop first"};
  }
  is_stopping_ = false;
  thread_ = std::thread([this] { run(); });
  return std::nullopt;
}

void ServoLoop::stop() {
  if (!thread_.joinable()) return;
  is_stopping_ = true;
  thread_.join();
  channel_->close_reader(reader_);
  device_->close();
}

void ServoLoop::request_restart(const dvec3& free_point_volume) noexcept {
  restarts_.push(free_point_volume);
}

void ServoLoop::run() noexcept {
  _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);
  _MM_SET_DENORMALS_ZERO_MODE(_MM_DENORMALS_ZERO_ON);
  if (options_.wants_realtime) {
    sched_param priority{};
    priority.sched_priority = 80;
    if (pthread_setschedparam(pthread_self(), SCHED_FIFO, &priority) != 0) refused_ |= 1;
    if (mlockall(MCL_CURRENT) != 0) refused_ |= 2;
  }
  const auto period = static_cast<std::int64_t>(std::llround(1e9 / options_.rate_hz));
  const auto watchdog = static_cast<std::int64_t>(options_.watchdog_seconds * 1e9);
  const std::int64_t start = now_ns();
  std::int64_t due = start;
  Pose pose;
  std::uint32_t faults = 0;
  for (std::uint64_t tick = 0; !is_stopping_.load(std::memory_order_relaxed); ++tick, due += period) {
    sleep_until(due);
    const std::int64_t begin = now_ns();
    const std::int64_t late = begin - due;
    lateness_.add(static_cast<std::uint64_t>(late > 0 ? late : 0));
    if (late > period) overruns_.fetch_add(1, std::memory_order_relaxed);
    if (late > watchdog) faults |= fault_stale_scene;

    // Wishes first, then one version for the whole step: a wish is published after the version that it is
    // about. Device time is the tick's own, so that nothing depends on the clock.
    if (wants_reset_.exchange(false, std::memory_order_relaxed)) {
      core_.reset();
      faults = 0;
    }
    dvec3 free_point;
    while (restarts_.pop(free_point)) core_.restart_at(free_point);
    const volume::Version* version = channel_->adopt(reader_);
    const double t = static_cast<double>(tick) / options_.rate_hz;
    if (!device_->read(t, pose)) faults |= fault_lost_device;
    const ServoRecord record = core_.step(*version, pose, t, faults);
    device_->write(record.force_world);
    if (!ring_.push(record)) faults |= fault_full_ring;
    faults_.store(record.faults | faults, std::memory_order_relaxed);
    ticks_.store(tick + 1, std::memory_order_relaxed);
    step_times_.add(static_cast<std::uint64_t>(now_ns() - begin));
    // After a long gap the missed ticks are not made up for.
    if (late > 8 * period) due = begin;
  }
  device_->write(dvec3(0));
}

ServoReport ServoLoop::report() const {
  ServoReport r;
  r.ticks = ticks_.load();
  r.overruns = overruns_.load();
  r.step_p50_us = step_times_.percentile_us(50);
  r.step_p99_us = step_times_.percentile_us(99);
  r.step_p999_us = step_times_.percentile_us(99.9);
  r.step_max_us = step_times_.max_us();
  r.late_p50_us = lateness_.percentile_us(50);
  r.late_p99_us = lateness_.percentile_us(99);
  r.late_p999_us = lateness_.percentile_us(99.9);
  r.late_max_us = lateness_.max_us();
  r.faults = faults_.load();
  const int refused = refused_.load();
  if (refused & 1) r.notice = "real-time scheduling was refused (allow it: rtprio in /etc/security/limits.d)";
  if (refused & 2)
    r.notice += std::string(r.notice.empty() ? "" : "; ") +
                "locking memory was refused (allow it: memlock in /etc/security/limits.d)";
  return r;
}

}  // namespace trephine::haptics
