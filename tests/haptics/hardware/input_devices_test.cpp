// SpaceMouseDevice and PedalDevice against scripted links; the table of USB ids.
#include <chrono>
#include <deque>
#include <fcntl.h>
#include <fstream>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <iterator>
#include <linux/input.h>
#include <mutex>
#include <thread>
#include <unistd.h>

#include "apps/bench/scenes/scratch.h"
#include "haptics/hardware/input_file.h"
#include "haptics/hardware/pedal_device.h"
#include "haptics/hardware/spacemouse_device.h"
#include "haptics/hardware/usb_ids.h"
#include "tests/haptics/hardware/waiting.h"

using namespace trephine;
using namespace trephine::haptics;

namespace {

struct Mouse3d {
  std::mutex lock;
  std::deque<std::vector<std::uint8_t>> reports;
  std::vector<std::vector<std::uint8_t>> written;
  bool is_gone = false;
};

class MouseLink final : public HidLink {
 public:
  explicit MouseLink(Mouse3d& mouse) : mouse_(mouse) {}
  LinkResult write(std::span<const std::uint8_t> report) noexcept override {
    const std::lock_guard guard(mouse_.lock);
    mouse_.written.emplace_back(report.begin(), report.end());
    return LinkResult::done;
  }
  LinkResult read(std::span<std::uint8_t> report, std::size_t& count, int timeout_ms) noexcept override {
    for (int i = 0; i <= timeout_ms; ++i) {
      {
        const std::lock_guard guard(mouse_.lock);
        if (mouse_.is_gone) return LinkResult::disconnected;
        if (!mouse_.reports.empty()) {
          const auto next = mouse_.reports.front();
          mouse_.reports.pop_front();
          std::copy(next.begin(), next.end(), report.begin());
          count = next.size();
          return LinkResult::done;
        }
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return LinkResult::timed_out;
  }

 private:
  Mouse3d& mouse_;
};

/// A pedal at the other end of a pipe.
struct Pipe {
  int ends[2] = {-1, -1};
  Pipe() { EXPECT_EQ(::pipe2(ends, O_DIRECT), 0); }  // each write is read as a whole
  ~Pipe() { unplug(); }
  void send(int type, int code, int value) const {
    input_event event{};
    event.type = static_cast<__u16>(type), event.code = static_cast<__u16>(code), event.value = value;
    EXPECT_EQ(::write(ends[1], &event, sizeof(event)), static_cast<ssize_t>(sizeof(event)));
  }
  void unplug() {
    if (ends[1] >= 0) ::close(ends[1]);
    ends[1] = -1;
  }
};

std::string text_of_file(const std::string& path) {
  std::ifstream in(std::string(TREPHINE_SOURCE_DIR) + "/" + path);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// The installed rules contain the ids that the drivers look for, and no others; the documentation contains
/// all of them.
TEST(UsbIds, RulesAndDocumentationFollowTheTable) {
  EXPECT_EQ(text_of_file("packaging/60-trephine.rules"), udev_rules());
  const std::string docs = text_of_file("docs/devices.md");
  const auto documented = [&](std::uint16_t vendor, const std::string& product) {
    return docs.find("`" + hex_of(vendor) + ":" + product + "`") != std::string::npos;
  };
  for (const UsbIds& ids : usb_ids()) {
    EXPECT_EQ(documented(ids.vendor, "*"), ids.products.empty()) << ids.name;
    for (const std::uint16_t product : ids.products)
      EXPECT_TRUE(documented(ids.vendor, hex_of(product))) << ids.name;
    EXPECT_NE(docs.find("`" + std::string(ids.device)), std::string::npos) << ids.device;
  }
}

}  // namespace

TEST(SpaceMouseDevice, MovesTheToolRestsWhenSilentAndReportsItsLoss) {
  Mouse3d mouse;
  SpaceMouseDevice device([&]() -> Result<std::unique_ptr<HidLink>> {
    return std::unique_ptr<HidLink>(std::make_unique<MouseLink>(mouse));
  });
  ASSERT_FALSE(device.open());
  Pose pose;
  ASSERT_TRUE(device.read(0, pose));
  EXPECT_EQ(pose.buttons, 0u);
  EXPECT_EQ(glm::length(pose.position_world), 0);
  const auto send = [&](std::vector<std::uint8_t> report) {
    const std::lock_guard guard(mouse.lock);
    mouse.reports.push_back(std::move(report));
  };
  send({3, 1});
  ASSERT_TRUE(eventually([&] { return device.read(0, pose) && pose.buttons == 1; }));
  // Full deflection to the right, then silence: older devices send nothing at rest.
  send({1, 0x5e, 1, 0, 0, 0, 0});
  double t = 0;
  ASSERT_TRUE(eventually([&] { return device.read(t += 0.001, pose) && pose.position_world.x > 0; }));
  double rest = 0;
  ASSERT_TRUE(eventually([&] {
    rest = pose.position_world.x;
    return device.read(t += 0.001, pose) && pose.position_world.x == rest;
  }));
  for (int i = 0; i < 100; ++i) ASSERT_TRUE(device.read(t += 0.001, pose));
  EXPECT_EQ(pose.position_world.x, rest);
  EXPECT_EQ(pose.buttons, 1u);  // without a report the button is still pressed
  {
    const std::lock_guard guard(mouse.lock);
    mouse.is_gone = true;
  }
  EXPECT_TRUE(eventually([&] { return !device.read(t, pose); }));
  device.close();
  EXPECT_EQ(mouse.written.front(), (std::vector<std::uint8_t>{4, 1}));
}

TEST(PedalDevice, KeysAreButtonsInTheOrderOfTheirFirstPress) {
  Pipe pipe;
  PedalDevice pedal([&]() -> Result<InputFile> { return InputFile{pipe.ends[0], {}}; });
  ASSERT_FALSE(pedal.open());
  Pose pose;
  const auto becomes = [&](std::uint32_t buttons) {
    return eventually([&] { return pedal.read(0, pose) && pose.buttons == buttons; });
  };
  EXPECT_TRUE(becomes(0));
  pipe.send(EV_KEY, KEY_C, 0);  // it was held when the pedal was opened: no press, and no bit
  pipe.send(EV_KEY, KEY_B, 1);
  EXPECT_TRUE(becomes(1));
  pipe.send(EV_KEY, KEY_B, 2);  // repeated
  pipe.send(EV_KEY, KEY_A, 1);
  EXPECT_TRUE(becomes(3));
  pipe.send(EV_KEY, KEY_B, 0);
  EXPECT_TRUE(becomes(2));
  pipe.send(EV_KEY, KEY_B, 1);
  EXPECT_TRUE(becomes(3));
  pipe.unplug();
  EXPECT_TRUE(eventually([&] { return !pedal.read(0, pose); }));
}

TEST(PedalDevice, AnAxisBeyondHalfWorksTheTool) {
  Pipe pipe;
  PedalDevice pedal([&]() -> Result<InputFile> {
    return InputFile{pipe.ends[0], {{ABS_X, 100, 300}, {ABS_Y, 0, 255}}};
  });
  ASSERT_FALSE(pedal.open());
  Pose pose;
  pipe.send(EV_ABS, ABS_X, 150);
  ASSERT_TRUE(eventually([&] { return pedal.read(0, pose) && pose.axes[0] == 0.25f; }));
  EXPECT_FALSE(pose.is_pressed());
  pipe.send(EV_ABS, ABS_X, 290);
  ASSERT_TRUE(eventually([&] { return pedal.read(0, pose) && pose.is_pressed(); }));
  pipe.send(EV_ABS, ABS_X, -5000);  // beyond its range
  ASSERT_TRUE(eventually([&] { return pedal.read(0, pose) && pose.axes[0] == 0; }));
  EXPECT_FALSE(pose.is_pressed());
  pipe.send(EV_ABS, ABS_Y, 255);
  ASSERT_TRUE(eventually([&] { return pedal.read(0, pose) && pose.axes[1] == 1; }));
  EXPECT_FALSE(pose.is_pressed());  // only the first axis works the tool
}

/// Each bit of a raw report is a button, without the number of the report.
TEST(PedalDevice, BitsOfRawReportsAreButtons) {
  for (const bool has_number : {false, true}) {
    Pipe pipe;
    PedalDevice pedal([&]() -> Result<InputFile> {
      return InputFile{
          .descriptor = pipe.ends[0], .axes = {}, .is_raw = true, .has_report_number = has_number};
    });
    ASSERT_FALSE(pedal.open());
    Pose pose;
    const auto becomes = [&](std::uint32_t buttons) {
      return eventually([&] { return pedal.read(0, pose) && pose.buttons == buttons; });
    };
    const auto send = [&](std::vector<std::uint8_t> report) {
      if (has_number) report.insert(report.begin(), 7);
      EXPECT_EQ(::write(pipe.ends[1], report.data(), report.size()), static_cast<ssize_t>(report.size()));
    };
    send({0x01, 0x00});
    EXPECT_TRUE(becomes(1));
    send({0x06, 0x00});
    EXPECT_TRUE(becomes(6));
    send({0x00, 0x80, 0x01, 0xff});
    EXPECT_TRUE(becomes(0x18000));
    if (has_number) {
      // A report with another number has other contents.
      const std::uint8_t other[] = {8, 0xff};
      EXPECT_EQ(::write(pipe.ends[1], other, sizeof other), static_cast<ssize_t>(sizeof other));
      send({0x02});
      EXPECT_TRUE(becomes(2));
    }
    send({});
    pipe.unplug();
    EXPECT_TRUE(eventually([&] { return !pedal.read(0, pose); }));
  }
  // Descriptors of a boot mouse (without a number), and with the item "report ID 1".
  const std::uint8_t mouse[] = {0x05, 0x01, 0x09, 0x02, 0xa1, 0x01, 0x26, 0x85, 0x00, 0xc0};
  const std::uint8_t numbered[] = {0x05, 0x0c, 0x09, 0x01, 0xa1, 0x01, 0x85, 0x01, 0xc0};
  const std::uint8_t cut[] = {0xfe, 0xff};
  EXPECT_FALSE(has_report_number(mouse));
  EXPECT_TRUE(has_report_number(numbered));
  EXPECT_FALSE(has_report_number(cut));
}

/// After lost events, a key whose release may be among them counts as released. An axis that rests beyond
/// half its range is no button before it moves.
TEST(PedalDevice, LostEventsAndRestingAxesDoNotWorkTheTool) {
  Pipe pipe;
  PedalDevice pedal([&]() -> Result<InputFile> { return InputFile{pipe.ends[0], {{ABS_X, 0, 100, 80}}}; });
  ASSERT_FALSE(pedal.open());
  Pose pose;
  EXPECT_TRUE(eventually([&] { return pedal.read(0, pose) && pose.axes[0] == 0.8f; }));
  EXPECT_EQ(pose.buttons, 0u);
  pipe.send(EV_KEY, KEY_B, 1);
  EXPECT_TRUE(eventually([&] { return pedal.read(0, pose) && pose.is_pressed(); }));
  pipe.send(EV_SYN, SYN_DROPPED, 0);
  EXPECT_TRUE(eventually([&] { return pedal.read(0, pose) && !pose.is_pressed(); }));
}

TEST(PedalDevice, OtherFilesAreNoInputDevices) {
  const auto absent = open_input("/dev/input/event99999");
  ASSERT_FALSE(absent);
  EXPECT_EQ(absent.error().where, "pedal: absent");
  const auto other = open_input("/dev/null");
  ASSERT_FALSE(other);
  EXPECT_EQ(other.error().what, "the file is not an input device");
  EXPECT_FALSE(other.error().remedy.empty());
}

/// A HID device has a folder for each input device that the kernel makes of it. Files that cannot be held are
/// left alone.
TEST(InputGrab, EventFilesAreThoseOfTheDevice) {
  const scenes::Scratch sysfs;
  for (const char* entry : {"input/input12/event7", "input/input12/mouse1", "input/input9/event3", "hidraw"})
    std::filesystem::create_directories(sysfs.path / entry);
  EXPECT_EQ(event_files_of(sysfs.path), (std::vector<std::string>{"/dev/input/event3", "/dev/input/event7"}));
  EXPECT_TRUE(event_files_of(sysfs / "absent").empty());
  EXPECT_EQ(InputGrab({"/dev/input/event99999", "/dev/null"}).count(), 0u);
}
