// Tests of one device: rate and regularity of its poses, duration of a read, and the direction of its force.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "apps/cli/commands.h"
#include "apps/workbench/devices.h"

namespace trephine::cli {

/// Result of a check of this machine.
struct CheckResult {
  std::string name, observation, remedy;
  bool is_fault = false;
};

/// Calls `tick` 1000 times per second in a thread with the servo's priority, until it returns false or the
/// user interrupts the program. `t`: s since the start; `late_us`: lateness of this call. Returns true if the
/// system allowed the priority.
bool run_at_1_khz(const std::function<bool(double t, double late_us)>& tick);

/// Opens a device, calls on_open(), reads the device 1000 times per second for `seconds` while its force is
/// 0, and closes it. Returns the measured intervals and durations. Error: the device cannot be opened.
Result<std::vector<CheckResult>> measure_device(haptics::Device& device, double seconds,
                                                const std::function<void()>& on_open);

/// Pushes the hand to the right, upward and toward the user with 1 N, or with a quarter of the device's
/// largest force if that is less. After each push, asks whether the hand was pushed in that direction. `ask`:
/// shows the question and returns the answer: y, n, or empty to end the test. Error: the device has no force
/// or cannot be opened.
Result<std::vector<CheckResult>> test_feel(
    haptics::Device& device, const std::function<std::string(const std::string& question)>& ask);

}  // namespace trephine::cli
