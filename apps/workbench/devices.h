// The devices of this build, by name.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "haptics/device/device.h"

namespace trephine::workbench {

/// "mouse" (null: the window's own), "playback:PATH.csv", "virtual:PATH.csv". Error on other names, or a path
/// that cannot be read. Not opened yet.
volume::Result<std::shared_ptr<haptics::Device>> open_device(const std::string& name);

}  // namespace trephine::workbench
