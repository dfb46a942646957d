// State of the stand-ins for vendors' libraries, shared between a test and a library that it loads.
#pragma once

#include <array>
#include <atomic>

namespace trephine::fake_vendor {

/// Faults and state of a stand-in.
struct State {
  // Faults and settings. `calibration_styles`: bits as in libHD; `calibrated_by`: style that the driver used.
  std::atomic<bool> has_no_device{false}, refuses_to_open{false}, fails{false}, needs_inkwell{false},
      is_silent{false}, has_hot_motors{false}, needs_update{false};
  std::atomic<int> calibration_styles{4}, calibrated_by{0};
  // Values that the library returns.
  std::atomic<double> position[3] = {};                           ///< in the library's units and axes
  std::atomic<double> rotation[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};  ///< rows
  std::atomic<unsigned> buttons{0};
  // Values that the library received.
  std::atomic<double> wrench[6] = {};  ///< in the library's units and axes
  std::atomic<int> frames{0}, frames_with_force{0};
  std::atomic<bool> is_open{false}, has_force{false}, is_running{false};
};

}  // namespace trephine::fake_vendor
