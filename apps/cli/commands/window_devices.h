// Devices of a window, opened once before the window appears.
#pragma once

#include "apps/workbench/devices.h"

namespace trephine::cli {

/// Makes the devices of a choice. If `is_tried`, opens and closes each once, so that errors appear before the
/// window does, and so that devices are homed; a page shows their instructions in `language`.
Result<workbench::ChosenDevices> open_window_devices(const workbench::DeviceChoice& choice,
                                                     const std::string& language, bool is_tried);

}  // namespace trephine::cli
