#include "apps/cli/commands/doctor_device.h"

#include <algorithm>
#include <cmath>
#include <thread>
#include <time.h>

#include "apps/workbench/clock.h"
#include "haptics/servo/servo_loop.h"
#include "volume/base/percentile.h"
#include "volume/base/text.h"

namespace trephine::cli {

using workbench::Clock;
using workbench::seconds_since;

bool run_at_1_khz(const std::function<bool(double t, double late_us)>& tick) {
  bool is_realtime = false;
  std::thread servo([&] {
    is_realtime = haptics::request_realtime(80);
    const Clock::time_point start = Clock::now();
    timespec due{};
    clock_gettime(CLOCK_MONOTONIC, &due);
    double late_us = 0;
    while (!is_interrupted() && tick(seconds_since(start), late_us)) {
      due.tv_nsec += 1'000'000;
      if (due.tv_nsec >= 1'000'000'000) due.tv_nsec -= 1'000'000'000, ++due.tv_sec;
      while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &due, nullptr) != 0 && !is_interrupted()) {}
      timespec now{};
      clock_gettime(CLOCK_MONOTONIC, &now);
      late_us = 1e6 * static_cast<double>(now.tv_sec - due.tv_sec) +
                1e-3 * static_cast<double>(now.tv_nsec - due.tv_nsec);
    }
  });
  servo.join();
  return is_realtime;
}

Result<std::vector<CheckResult>> measure_device(haptics::Device& device, double seconds,
                                                const std::function<void()>& on_open) {
  if (Status error = device.open()) return *error;
  on_open();
  const haptics::DeviceCapabilities able = device.capabilities();
  const auto ticks = static_cast<std::size_t>(1000 * seconds) + 1;
  std::vector<double> read_us, interval_ms;
  read_us.reserve(ticks), interval_ms.reserve(ticks);
  std::size_t failed = 0;
  double changed_at = -1;
  haptics::Pose last;
  run_at_1_khz([&](double t, double) {
    haptics::Pose pose = last;
    const Clock::time_point before = Clock::now();
    failed += !device.read(t, pose);
    read_us.push_back(1e6 * seconds_since(before));
    device.write({});
    if (pose.position_world != last.position_world || pose.orientation != last.orientation) {
      if (changed_at >= 0) interval_ms.push_back(1e3 * (t - changed_at));
      changed_at = t, last = pose;
    }
    return t < seconds;
  });
  device.close();
  std::sort(read_us.begin(), read_us.end());
  std::sort(interval_ms.begin(), interval_ms.end());
  std::vector<CheckResult> checks;
  checks.push_back(
      {"device",
       format_text("%s: %d degrees of freedom, force %.1f N, stiffness %.1f N/mm", able.name.c_str(),
                   able.degrees_of_freedom, able.max_force, able.max_stiffness),
       "", false});
  const double share = static_cast<double>(failed) / static_cast<double>(read_us.size());
  if (failed > 0)
    checks.push_back({"device answers", format_text("%.0f %% of the reads failed", 100 * share),
                      "check cable and power; do not use a hub", true});
  if (interval_ms.size() < 10)
    checks.push_back({"device rate", "not measured: the hand did not move",
                      "move the hand during the whole measurement", false});
  else {
    const double median = percentile(interval_ms, 50), p99 = percentile(interval_ms, 99);
    // The servo runs at 1 kHz: a pose that is repeated for several ticks makes the force a staircase.
    constexpr double k_slowest = 4.5;  // ms
    const bool is_slow = median > k_slowest;
    checks.push_back(
        {"device rate",
         format_text("a new pose every %.1f ms (median), %.1f ms (99 %%), at most %.1f ms", median, p99,
                     interval_ms.back()),
         is_slow ? "connect it to a port of the computer; set the latency timer of its USB chip to 1 ms" : "",
         is_slow});
  }
  const double read = percentile(read_us, 99);
  constexpr double k_longest_read = 50;  // us
  checks.push_back(
      {"device read", format_text("takes %.2f us (median), %.2f us (99 %%)", percentile(read_us, 50), read),
       read > k_longest_read ? "close other programs; trephine doctor checks the scheduling" : "",
       read > k_longest_read});
  return checks;
}

Result<std::vector<CheckResult>> test_feel(haptics::Device& device,
                                           const std::function<std::string(const std::string&)>& ask) {
  const double most = device.capabilities().max_force;
  if (!(most > 0))
    return Error{.what = "this device has no force",
                 .where = "--feel",
                 .found = device.capabilities().name,
                 .remedy = "omit --feel, or choose a device with force"};
  if (Status error = device.open()) return *error;
  const double force = std::min(1.0, 0.25 * most);
  const struct {
    const char* name;
    glm::dvec3 direction;  ///< device frame: right, up, toward the user
  } pushes[] = {{"to the right", {1, 0, 0}}, {"upward", {0, 1, 0}}, {"toward you", {0, 0, 1}}};
  std::vector<CheckResult> checks;
  bool is_lost = false;
  for (const auto& push : pushes) {
    constexpr double k_ramp = 0.4, k_hold = 1.2;  // s
    run_at_1_khz([&](double t, double) {
      haptics::Pose pose;
      if (!device.read(t, pose)) is_lost = true;
      if (is_lost) return false;
      const double share = std::clamp(std::min(t, 2 * k_ramp + k_hold - t) / k_ramp, 0.0, 1.0);
      device.write({share * force * push.direction, {}});
      return t < 2 * k_ramp + k_hold;
    });
    device.write({});
    if (is_lost) {
      checks.push_back({"device force", "the device did not answer", "check cable and power", true});
      break;
    }
    if (is_interrupted()) break;
    const std::string answer =
        ask(format_text("Was the hand pushed %s with %.1f N? [y/n] ", push.name, force));
    if (answer.empty()) {
      checks.push_back({"device force", "the test ended before an answer", "answer y or n", true});
      break;
    }
    const bool is_right = answer[0] == 'y' || answer[0] == 'Y';
    checks.push_back({"device force",
                      format_text("%s: %s", push.name, is_right ? "perceived" : "not perceived"),
                      is_right ? "" : "check power and motors with the vendor's program", !is_right});
  }
  device.close();
  return checks;
}

}  // namespace trephine::cli
