// virtual-device: a window that is a haptic device for other programs, moved by the mouse.
#include <sstream>

#include "apps/cli/commands.h"
#include "apps/cli/commands/window_devices.h"
#include "apps/cli/options/display_options.h"
#include "apps/view/view_window.h"
#include "apps/view/virtual_device_page.h"
#include "apps/workbench/tool_path.h"
#include "data-tools/files/atomic_file.h"
#include "data-tools/files/output_set.h"

namespace trephine::cli {

namespace {

struct VirtualDeviceArguments {
  int index = 0;
  std::string motion, record, screenshot, attached;
  std::optional<double> seconds;
  std::string language;
};

Result<Outcome> run_virtual_device(const VirtualDeviceArguments& arguments) {
  if (arguments.index < 0 || arguments.index > haptics::SharedDeviceMemory::k_max_index)
    return Error{.what = "the index is out of range",
                 .where = "--index",
                 .found = std::to_string(arguments.index),
                 .expected = "0 to " + std::to_string(haptics::SharedDeviceMemory::k_max_index)};
  if (Status error = check_language(arguments.language)) return *error;
  if (!arguments.motion.empty() && !arguments.attached.empty())
    return Error{.what = "a device has one source of motion",
                 .where = "--attach",
                 .found = "--play and --attach",
                 .remedy = "omit one of them"};
  data_tools::OutputSet outputs;
  outputs.add_input(arguments.motion);
  outputs.add_output("recording", arguments.record, data_tools::OutputKind::table);
  outputs.add_output("screenshot", arguments.screenshot, data_tools::OutputKind::picture);
  if (Status error = outputs.check()) return *error;
  workbench::VirtualDeviceOptions options;
  options.index = arguments.index;
  if (!arguments.motion.empty()) {
    auto motion = workbench::open_path(arguments.motion);
    if (!motion) return motion.error();
    options.motion = std::move(motion).value();
  }
  if (!arguments.attached.empty()) {
    workbench::DeviceChoice choice;
    choice.device = arguments.attached;
    if (choice.device == "mouse" || choice.device.starts_with("remote"))
      return Error{.what = "this device cannot be attached",
                   .where = "--attach",
                   .found = choice.device,
                   .expected = "hardware, playback:PATH.csv or virtual:PATH.csv"};
    auto devices = open_window_devices(choice, arguments.language, false);
    if (!devices) return devices.error();
    options.attached = devices.value().device;
    if (Status error = options.attached->open()) return *error;
  }
  constexpr double k_longest_recording = 3600;  // s
  if (!arguments.record.empty()) options.record_seconds = k_longest_recording;
  auto host = workbench::VirtualDeviceHost::open(options);
  if (!host) return host.error();
  view::VirtualDevicePageOptions page;
  page.language = arguments.language;
  page.device = "remote:" + std::to_string(arguments.index);
  page.is_moved = arguments.motion.empty() && arguments.attached.empty();
  page.seconds = arguments.seconds;
  page.should_close = is_interrupted;
  page.screenshot = arguments.screenshot;
  const Status shown = view::show_virtual_device(*host.value(), page);
  std::optional<Result<haptics::PosePath>> recording;
  if (!arguments.record.empty()) recording = host.value()->recording();
  host.value().reset();
  if (options.attached) options.attached->close();
  if (shown) return *shown;
  Outcome outcome("virtual-device");
  outcome.json["device"] = page.device;
  if (recording && !*recording) return recording->error();
  if (recording) {
    const haptics::PosePath& path = recording->value();
    outcome.json["recorded_poses"] = path.samples().size();
    outcome.print("recorded {recorded_poses} poses", outcome.json);
    outputs.write(arguments.record, [&] {
      std::ostringstream text;
      path.write_csv(text);
      return data_tools::write_file_atomically(arguments.record, text.str());
    });
  }
  return finished(outputs, std::move(outcome));
}

Run build_virtual_device(Options& options) {
  auto a = std::make_shared<VirtualDeviceArguments>();
  options.add("--index", a->index, "Other programs open the device as remote:INDEX")
      .shows_default()
      .type("N");
  options.add("--play", a->motion, "Follow the motion of a path or a session instead of the mouse")
      .type("PATH.csv");
  options
      .add("--attach", a->attached,
           "Follow another device instead of the mouse, and pass forces on to it; names as of --device")
      .type("NAME");
  options.add("--record", a->record, "Write the motion as a path").type("OUT.csv");
  options.add("--screenshot", a->screenshot, "Write a picture of the window when it closes").type("OUT.png");
  options.add("--seconds", a->seconds, "Close the window after this time").type("S");
  add_language(options, a->language);
  return run_with(a, run_virtual_device);
}

}  // namespace

const Command k_virtual_device{"virtual-device", "A window that other programs use as a haptic device",
                               "  trephine virtual-device\n  trephine view head --device remote",
                               build_virtual_device};

}  // namespace trephine::cli
