#include "apps/workbench/devices.h"

#include "apps/workbench/source.h"

namespace trephine::workbench {

Result<std::shared_ptr<haptics::Device>> open_device(const std::string& name) {
  if (name == "mouse") return std::shared_ptr<haptics::Device>();
  const std::size_t colon = name.find(':');
  const std::string kind = name.substr(0, colon);
  const bool is_virtual = kind == "virtual";
  if (!is_virtual && kind != "playback")
    return Error{.what = "unknown device",
                 .where = "device",
                 .found = name,
                 .expected = "mouse, playback:PATH.csv or virtual:PATH.csv",
                 .remedy = "choose one of these"};
  if (colon == std::string::npos || colon + 1 == name.size())
    return Error{
        .what = "the device needs a path", .where = "device", .found = name, .expected = kind + ":PATH.csv"};
  Result<haptics::PosePath> path = open_path(name.substr(colon + 1));
  if (!path) return path.error();
  if (is_virtual)
    return std::shared_ptr<haptics::Device>(
        std::make_shared<haptics::VirtualDevice>(std::move(path).value(), haptics::HandModel()));
  return std::shared_ptr<haptics::Device>(std::make_shared<haptics::PlaybackDevice>(std::move(path).value()));
}

}  // namespace trephine::workbench
