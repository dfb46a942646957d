// Page that is shown while devices are opened: their instructions for the user, and a button to cancel.
#pragma once

#include <functional>
#include <string>

#include "volume/base/error.h"

namespace trephine::view {

struct DevicePageOptions {
  std::string language;  ///< one of k_languages; empty: that of the system, or of the last window
  /// Opens the devices, on a thread of its own. Calls `notice` with instructions for the user. Returns an
  /// error soon after should_stop() has become true.
  std::function<Status(const std::function<void(const std::string& text)>& notice,
                       const std::function<bool()>& should_stop)>
      open;
};

/// Calls open() and returns its result. The page appears if open() gives an instruction or takes longer than
/// half a second. Without the full window, open() is called without a page.
Status open_with_page(const DevicePageOptions& options);

/// Entry point of the window's library.
using OpenWithPage = Status (*)(const DevicePageOptions&);
inline constexpr const char* k_device_page_entry = "trephine_open_with_page";

}  // namespace trephine::view
