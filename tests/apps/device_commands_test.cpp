// Devices of commands: devices.toml, refused choices, and libraries that are loaded only with a device.
#include "tests/apps/command_fixture.h"

namespace trephine::command_tests {
namespace {

/// devices.toml selects the devices of a user unless the command line does.
TEST_F(Command, TheDevicesOfAUserAreRead) {
  std::filesystem::create_directories(folder_ / ".config/trephine");
  const auto settings = [&](const std::string& text) { write(".config/trephine/devices.toml", text); };
  settings("device = \"falcon:first\"\n");
  EXPECT_NE(run("view head --screenshot t.png").err.find("index of the device is invalid"),
            std::string::npos);
  EXPECT_EQ(run("view head --device mouse --screenshot t.png").exit_code, 0);
  settings("device = \"spacemouse\"\nscale = 20\n");
  EXPECT_NE(run("view head --screenshot t.png").err.find("from 0.1 to 10"), std::string::npos);
  settings("devise = \"falcon\"\n");
  const ProcessResult misspelt = run("view head --screenshot t.png");
  EXPECT_EQ(misspelt.exit_code, 2);
  EXPECT_NE(misspelt.err.find("unknown key"), std::string::npos) << misspelt.err;
  // A folder in place of the file, and a link to a missing file.
  fs::remove(folder_ / ".config/trephine/devices.toml");
  fs::create_directory(folder_ / ".config/trephine/devices.toml");
  EXPECT_EQ(run("view head --screenshot t.png").exit_code, 2);
  fs::remove(folder_ / ".config/trephine/devices.toml");
  fs::create_symlink("nothing", folder_ / ".config/trephine/devices.toml");
  EXPECT_EQ(run("view head --screenshot t.png").exit_code, 2);
  fs::remove(folder_ / ".config/trephine/devices.toml");
  for (const char* pair :
       {"inverse3 --left inverse3:0", "falcon:1 --left falcon:01", "touch --left touch:B"}) {
    const ProcessResult refused = run(std::string("view head --screenshot t.png --device ") + pair);
    EXPECT_EQ(refused.exit_code, 2) << pair;
    EXPECT_NE(refused.err.find("for one hand"), std::string::npos) << refused.err;
  }
}

/// Qt ends the process with an abort if no X server answers. The commands report an error before.
TEST_F(Command, AnUnreachableDisplayIsReported) {
  for (const char* command : {"view head", "simulator", "virtual-device"}) {
    const ProcessResult result = run(command, "env -u WAYLAND_DISPLAY DISPLAY=:59999");
    EXPECT_EQ(result.exit_code, 3) << command << result.err;
    EXPECT_NE(result.err.find("no X server answers at DISPLAY=:59999"), std::string::npos)
        << command << result.err;
  }
  const ProcessResult picture = run("view head --screenshot t.png", "env DISPLAY=:59999");
  EXPECT_EQ(picture.exit_code, 0) << picture.err;
}

/// The drivers, and the libraries that they need, are loaded only if hardware is requested.
TEST_F(Command, WithoutADeviceNoDriverIsLoaded) {
  const auto loaded = [&](const std::string& device) {
    // The dynamic loader writes the names of the files that it opens to loader.PID.
    EXPECT_NE(
        run("view head --screenshot t.png" + device, "env -u DISPLAY LD_DEBUG=files LD_DEBUG_OUTPUT=loader")
            .exit_code,
        -1);
    std::string text;
    for (const auto& entry : fs::directory_iterator(folder_))
      if (entry.path().filename().string().starts_with("loader."))
        text += read(entry.path().string()), fs::remove(entry.path());
    return text;
  };
  const std::string with_mouse = loaded(""), with_device = loaded(" --device spacemouse");
  EXPECT_NE(with_mouse.find("libtrephine"), std::string::npos);
  for (const char* library : {"libtrephine-devices", "libusb-1.0", "libhidapi"}) {
    EXPECT_EQ(with_mouse.find(library), std::string::npos) << library;
    EXPECT_NE(with_device.find(library), std::string::npos) << library;
  }
}

}  // namespace
}  // namespace trephine::command_tests
