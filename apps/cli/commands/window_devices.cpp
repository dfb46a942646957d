#include "apps/cli/commands/window_devices.h"

#include "apps/cli/report.h"
#include "apps/view/device_page.h"

namespace trephine::cli {

Result<workbench::ChosenDevices> open_window_devices(const workbench::DeviceChoice& choice,
                                                     const std::string& language, bool is_tried) {
  /// The page that receives instructions; ignores them while no page is shown.
  struct Page {
    std::function<void(const std::string&)> notice = [](const std::string&) {};
    std::function<bool()> should_stop = [] { return false; };
  };
  const auto page = std::make_shared<Page>();
  workbench::Listener listener = terminal_listener();
  listener.notice = [page, print = listener.notice](const std::string& text) {
    print(text);
    page->notice(text);
  };
  listener.should_stop = [page, is_stopped = listener.should_stop] {
    return is_stopped() || page->should_stop();
  };
  auto devices = workbench::make_devices(choice, listener);
  if (!devices || !is_tried) return devices;
  const workbench::ChosenDevices& chosen = devices.value();
  if (!chosen.device && !chosen.left && !chosen.pedal) return devices;
  const Status error = view::open_with_page({language, [&](const auto& notice, const auto& should_stop) {
                                               *page = {notice, should_stop};
                                               Status opened = workbench::try_devices(chosen);
                                               *page = {};
                                               return opened;
                                             }});
  if (error) return *error;
  return devices;
}

}  // namespace trephine::cli
