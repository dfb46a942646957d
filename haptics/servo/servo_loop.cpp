#include "haptics/servo/servo_loop.h"

#include <algorithm>
#include <cmath>
#include <pmmintrin.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <time.h>

#include "haptics/force/coupling.h"
#include "volume/base/text.h"

namespace trephine::haptics {

using glm::dvec3;

namespace {

std::int64_t now_ns() noexcept {
  timespec t{};
  clock_gettime(CLOCK_MONOTONIC, &t);
  return static_cast<std::int64_t>(t.tv_sec) * 1'000'000'000 + t.tv_nsec;
}

void sleep_until(std::int64_t ns) noexcept {
  const timespec t{ns / 1'000'000'000, ns % 1'000'000'000};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, nullptr) != 0) {}
}

std::size_t ring_capacity(const ServoOptions& options, std::size_t hands) {
  if (options.ring_capacity > 0) return options.ring_capacity;
  constexpr double k_min = 4096, k_max = 1 << 20;
  const double lag = options.lag_seconds * options.rate_hz * static_cast<double>(hands);
  // A non-finite rate is refused later, by start().
  return static_cast<std::size_t>(2 * lag > k_min ? std::min(2 * lag, k_max) : k_min);
}

}  // namespace

ServoLoop::ServoLoop(std::span<Device* const> devices, ServoChannel& channel, const ServoOptions& options,
                     std::uint64_t first_tick)
    : channel_(&channel), options_(options), ring_(ring_capacity(options, devices.size())) {
  TREPHINE_ASSERT(!devices.empty() && devices.size() <= ServoScene::k_max_hands);
  for (Device* device : devices)
    hands_.push_back({device, ServoCore(options.force, 1 / options.rate_hz, hands_.size(), first_tick), {}});
}

ServoLoop::ServoLoop(Device& device, ServoChannel& channel, const ServoOptions& options)
    : ServoLoop(std::array{&device}, channel, options) {}

ServoLoop::~ServoLoop() { stop(); }

Status ServoLoop::start() {
  if (thread_.joinable())
    return Error{.what = "the servo loop is already running",
                 .found = "a second start",
                 .expected = "a stop between two starts",
                 .remedy = "stop the loop first"};
  if (!(options_.rate_hz >= 250 && options_.rate_hz <= 10000))
    return Error{.what = "the servo rate is out of range",
                 .found = rounded_text(options_.rate_hz) + " Hz",
                 .expected = "250 to 10000 Hz"};
  // Records contain the force that is sent to the device. A device that limits it further would render
  // another force, so limits above those of the device are an error.
  for (const Hand& hand : hands_) {
    const DeviceCapabilities device = hand.device->capabilities();
    const ForceOptions limited = within_limits(options_.force, device);
    if (limited.force_limit < options_.force.force_limit || limited.slew_limit < options_.force.slew_limit ||
        limited.torque_limit < options_.force.torque_limit)
      return Error{.what = "the force limits exceed those of the device",
                   .where = device.name,
                   .found = rounded_text(options_.force.force_limit) + " N, " +
                            rounded_text(options_.force.slew_limit) + " N/s, " +
                            rounded_text(options_.force.torque_limit) + " N mm",
                   .expected = "at most " + rounded_text(limited.force_limit) + " N, " +
                               rounded_text(limited.slew_limit) + " N/s, " +
                               rounded_text(limited.torque_limit) + " N mm",
                   .remedy =
                       "continue the session with a stronger device or the mouse; a new operation adapts "
                       "to its devices"};
  }
  for (std::size_t h = 0; h < hands_.size(); ++h) {
    Status error = hands_[h].device->open();
    hands_[h].has_motors = hands_[h].device->capabilities().has_motors();
    if (!error) continue;
    while (h-- > 0) hands_[h].device->close();
    return error;
  }
  reader_ = channel_->open_reader();
  if (reader_ < 0) {
    for (Hand& hand : hands_) hand.device->close();
    return Error{.what = "too many servo loops read one scene",
                 .expected = "at most " + std::to_string(ServoChannel::k_readers),
                 .remedy = "stop another loop first"};
  }
  if (const std::size_t known = channel_->adopt(reader_)->hands.size(); known < hands_.size()) {
    channel_->close_reader(reader_);
    for (Hand& hand : hands_) hand.device->close();
    return Error{.what = "the scene has fewer hands than devices",
                 .found = std::to_string(hands_.size()) + " devices",
                 .expected = "at most " + std::to_string(known),
                 .remedy = "publish a scene with a hand per device first"};
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
  for (Hand& hand : hands_) hand.device->close();
}

void ServoLoop::request_restart(const dvec3& free_point_volume, std::size_t hand) noexcept {
  hands_[hand].restarts.push(free_point_volume);
}

bool request_realtime(int priority) noexcept {
  sched_param parameters{};
  parameters.sched_priority = priority;
  return pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters) == 0;
}

void ServoLoop::run() noexcept {
  _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);
  _MM_SET_DENORMALS_ZERO_MODE(_MM_DENORMALS_ZERO_ON);
  if (options_.wants_realtime) {
    if (!request_realtime(80)) refused_ |= 1;
    if (mlockall(MCL_CURRENT) != 0) refused_ |= 2;
  }
  const auto period = static_cast<std::int64_t>(std::llround(1e9 / options_.rate_hz));
  const auto watchdog = static_cast<std::int64_t>(options_.watchdog_seconds * 1e9);
  const std::int64_t start = now_ns();
  std::int64_t due = start;
  for (std::uint64_t tick = 0; !is_stopping_.load(std::memory_order_relaxed); ++tick, due += period) {
    sleep_until(due);
    const std::int64_t begin = now_ns();
    const std::int64_t late = begin - due;
    lateness_.add(static_cast<std::uint64_t>(late > 0 ? late : 0));
    if (late > period) overruns_.fetch_add(1, std::memory_order_relaxed);
    this->tick(tick, late > watchdog ? fault_stale_scene : 0u);
    ticks_.store(tick + 1, std::memory_order_relaxed);
    step_times_.add(static_cast<std::uint64_t>(now_ns() - begin));
    // After a gap of more than eight periods, the loop does not catch up on the missed ticks.
    if (late > 8 * period) due = begin;
  }
  for (Hand& hand : hands_) hand.device->write(dvec3(0));
}

/// Stops the tool of a hand at a fault. If the device has motors, the tool works again only after its button
/// and its squeeze (the first axis) were released: with a force that returns, it must not start by itself.
void ServoLoop::lock_buttons(Hand& hand) noexcept {
  constexpr float k_released = 0.2f;  // of the squeeze
  const bool is_released = !hand.pose.is_pressed() && hand.pose.axes[0] <= k_released;
  if ((hand.core.faults() & k_latched_faults) != 0)
    hand.is_locked = true;
  else if (is_released || !hand.has_motors)
    hand.is_locked = false;
  if (hand.is_locked) hand.pose.buttons = 0, hand.pose.axes = {};
}

void ServoLoop::tick(std::uint64_t tick, std::uint32_t faults) noexcept {
  // Device time is that of the tick, so that no result depends on the clock.
  const double t = static_cast<double>(tick) / options_.rate_hz;
  std::uint32_t all_faults = 0;

  // If the ring has no room for the records of this tick, no contact is computed, because a replay needs the
  // record of every computed contact.
  if (ring_.room() < hands_.size()) {
    dropped_.fetch_add(1, std::memory_order_relaxed);
    for (Hand& hand : hands_) {
      hand.faults |= faults | fault_full_ring;
      if (hand.device->read(t, hand.pose)) hand.pose = rounded_to_grid(hand.pose);
      hand.device->write(hand.core.skip(hand.faults));
      all_faults |= hand.faults;
    }
    faults_.store(all_faults, std::memory_order_relaxed);
    return;
  }
  const bool is_reset = wants_reset_.exchange(false, std::memory_order_relaxed);
  const ServoScene* servo_scene = channel_->adopt(reader_);
  // The force fades before the ring is full, at any rate and ring size.
  const double waiting = static_cast<double>(ring_.size());
  const bool is_lagging =
      waiting > options_.lag_seconds * options_.rate_hz * static_cast<double>(hands_.size()) ||
      waiting > 0.5 * static_cast<double>(ring_.capacity());
  HandPlacements hand_placements;
  for (std::size_t h = 0; servo_scene->has_held && h < hands_.size(); ++h)
    hand_placements[h] = hands_[h].core.pose_before(hands_[h].core.next_tick());
  for (Hand& hand : hands_) {
    ServoInput input;
    input.hand_placements = &hand_placements;
    if (is_reset) hand.faults = 0;
    input.is_reset = is_reset;
    while (hand.restarts.pop(input.restart_volume)) input.is_restarted = true;
    hand.faults |= faults;
    if (is_lagging) hand.faults |= fault_stale_scene;
    if (hand.device->read(t, hand.pose))
      hand.pose = rounded_to_grid(hand.pose);
    else
      hand.faults |= fault_lost_device;
    if (const std::optional<dvec3> free = hand.device->fetch_jump()) {
      input.is_restarted = true;
      input.restart_volume = servo_scene->hands[0].scene->base->frame.volume_from_world(*free);
    }
    lock_buttons(hand);
    input.pose = hand.pose;
    input.faults = hand.faults;
    const ServoRecord record = hand.core.step(*servo_scene, input);
    hand.device->write(record.wrench());
    ring_.push(record);
    all_faults |= record.faults | hand.faults;
  }
  faults_.store(all_faults, std::memory_order_relaxed);
}

ServoReport ServoLoop::report() const {
  ServoReport r;
  r.ticks = ticks_.load();
  r.overruns = overruns_.load();
  r.dropped = dropped_.load();
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
