// Tests of one device: rate and regularity of its poses, duration of a read, and the direction of its force.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "apps/cli/commands.h"
#include "apps/workbench/devices.h"

namespace trephine::cli {

/// Result of a check of this machine.
struct Finding {
  std::string name, found, remedy;
  bool is_fault = false;
};

/// Opens a device, reads it 1000 times per second for a time without force, and closes it. Returns what was
/// measured. Error: the device cannot be opened.
Result<std::vector<Finding>> measure_device(haptics::Device& device, double seconds);

/// Pushes the hand to the right, upward and toward the user, with at most 1 N or a quarter of the device's
/// largest force, and asks after each push for its direction. `ask`: shows a question, and returns the
/// answer: y, n, or empty to end the test. Error: the device has no force or cannot be opened.
Result<std::vector<Finding>> test_feel(haptics::Device& device,
                                       const std::function<std::string(const std::string& question)>& ask);

}  // namespace trephine::cli
