// Devices of this build, by name.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "haptics/device/device.h"

namespace trephine::workbench {

/// Creates "playback:PATH.csv" or "virtual:PATH.csv", without opening it; null for "mouse", which belongs to
/// the window. Error on other names, or a path that cannot be read.
Result<std::shared_ptr<haptics::Device>> open_device(const std::string& name);

}  // namespace trephine::workbench
