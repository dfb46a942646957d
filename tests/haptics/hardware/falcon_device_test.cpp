// FalconDevice against a simulated Falcon that behaves as the documents of the device describe, with the
// known faults of the device.
#include "haptics/hardware/falcon_device.h"

#include <array>
#include <chrono>
#include <cmath>
#include <deque>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <mutex>
#include <thread>
#include <utility>

#include "tests/haptics/hardware/waiting.h"

using namespace trephine;
using namespace trephine::haptics;
using glm::dvec3;

namespace {

/// Faults and state of the simulated Falcon, and the frames that it received.
struct Falcon {
  // Initial state and faults.
  bool has_firmware = false, has_leading_zero = false, splits_packets = false, adds_noise = false;
  int silent_attempts = 0;    ///< number of attempts that the loader does not answer
  int bad_block = -1;         ///< this block is echoed wrongly, once
  int unplug_block = -1;      ///< unplugged while this block is loaded
  int unplug_frame = -1;      ///< unplugged at this frame
  bool has_error = false;     ///< the next read fails, once
  bool loses_home = false;    ///< the arms are no longer homed
  bool falls_silent = false;  ///< sends no more frames
  int homes_after = 3;        ///< frames with a request to home until the arms are homed; -1: never
  // State, shared with the thread of the test.
  std::mutex lock;
  std::array<int, 3> counts{100, -50, 20};
  int buttons = 0;
  std::vector<std::array<int, 3>> motors;  ///< received motor values, one entry per frame
  std::vector<int> flags;                  ///< received flags, one entry per frame
  std::vector<std::uint8_t> loaded;        ///< bytes of the firmware
  int loads = 0, links = 0;                ///< attempts to load firmware; open links

  std::array<int, 3> last_motors() {
    const std::lock_guard guard(lock);
    return motors.back();
  }
};

/// Device's side of the link, byte by byte. Shares no code with the driver.
class Peer final : public UsbLink {
 public:
  explicit Peer(Falcon& falcon) : falcon_(falcon) { ++falcon_.links; }
  ~Peer() override { --falcon_.links; }

  LinkResult control(std::uint8_t request, std::uint16_t value) noexcept override {
    if (is_gone_) return LinkResult::disconnected;
    if (request == 3) baud_ = value;
    if (request == 9) latency_ = value;
    if (request == 0) answer_.clear();
    if (request == 1 && value == 0x101) begins_ = true;  // DTR high: the processor starts its loader
    if (request == 1 && value == 0x101 && baud_ == 0x4138) is_loading_ = false, falcon_.has_firmware = false;
    return LinkResult::done;
  }
  LinkResult write(std::span<const std::uint8_t> bytes, int) noexcept override {
    const std::lock_guard guard(falcon_.lock);
    if (is_gone_) return LinkResult::disconnected;
    if (baud_ == 2 && falcon_.has_firmware) return run(bytes);
    if (baud_ == 0x4138 && begins_) {
      if (std::vector<std::uint8_t>(bytes.begin(), bytes.end()) ==
          std::vector<std::uint8_t>{0x0a, 0x43, 0x0d}) {
        ++falcon_.loads;
        if (latency_ != 16 || falcon_.silent_attempts-- > 0) return LinkResult::done;
        if (falcon_.has_leading_zero) answer_.push_back(0);
        for (const int byte : {0x0a, 0x44, 0x2c, 0x0d}) answer_.push_back(static_cast<std::uint8_t>(byte));
        falcon_.loaded.clear();
        block_ = 0;
      }
    } else if (baud_ == 0x15) {
      if (!is_loading_) {
        is_loading_ = bytes.size() == 1 && bytes[0] == 0x41;
        if (is_loading_) answer_.push_back(0x41);
      } else {
        if (block_ == falcon_.unplug_block) is_gone_ = true;
        for (std::size_t i = 0; i < bytes.size(); ++i) {
          falcon_.loaded.push_back(bytes[i]);
          const bool is_wrong = block_ == falcon_.bad_block && i == bytes.size() / 2;
          answer_.push_back(is_wrong ? static_cast<std::uint8_t>(~bytes[i]) : bytes[i]);
        }
        if (block_++ == falcon_.bad_block) falcon_.bad_block = -1;
        falcon_.has_firmware = bytes.size() < 62;  // only the last block of the image is shorter
      }
    }
    return LinkResult::done;
  }
  LinkResult read(std::span<std::uint8_t> buffer, std::size_t& count, int timeout_ms) noexcept override {
    count = 0;
    std::this_thread::sleep_for(
        std::chrono::microseconds(answer_.empty() ? 1000 * std::min(timeout_ms, 2) : 300));
    const std::lock_guard guard(falcon_.lock);
    if (is_gone_) return LinkResult::disconnected;
    if (std::exchange(falcon_.has_error, false)) return LinkResult::failed;
    // Packets of 64 bytes: two bytes of status, then data.
    std::size_t at = 0;
    do {
      if (at + 2 > buffer.size()) break;
      buffer[at++] = 1, buffer[at++] = 0x60;
      const std::size_t room = falcon_.splits_packets ? 5 : 62;
      for (std::size_t i = 0; i < room && !answer_.empty() && at < buffer.size(); ++i)
        buffer[at++] = answer_.front(), answer_.pop_front();
    } while (!answer_.empty() && at % 64 == 0 && at < buffer.size());
    count = at;
    return LinkResult::done;
  }

 private:
  LinkResult run(std::span<const std::uint8_t> bytes) {
    if (bytes.size() != 16 || bytes[0] != '<' || bytes[15] != '>') return LinkResult::done;
    std::array<int, 3> motors{};
    for (std::size_t i = 0; i < 3; ++i) {
      int value = 0;
      for (int digit = 3; digit >= 0; --digit)
        value = 16 * value + bytes[1 + 4 * i + static_cast<std::size_t>(digit)] - 'A';
      motors[i] = value >= 32768 ? value - 65536 : value;
    }
    falcon_.motors.push_back(motors);
    const int flags = bytes[13] - 'A';
    falcon_.flags.push_back(flags);
    if ((flags & 1) != 0) ++homing_;
    if (static_cast<int>(falcon_.motors.size()) == falcon_.unplug_frame) is_gone_ = true;
    if (falcon_.falls_silent) return LinkResult::done;
    if (falcon_.adds_noise)
      for (const char c : {'A', '>', '<', 'B', 'C'}) answer_.push_back(static_cast<std::uint8_t>(c));
    answer_.push_back('<');
    for (const int count : falcon_.counts)
      for (int digit = 0; digit < 4; ++digit)
        answer_.push_back(static_cast<std::uint8_t>('A' + ((count + 65536) >> 4 * digit & 15)));
    const bool is_homed = falcon_.homes_after >= 0 && homing_ >= falcon_.homes_after && !falcon_.loses_home;
    answer_.push_back(static_cast<std::uint8_t>('A' + (is_homed ? 0x70 : 0x30) + falcon_.buttons));
    answer_.push_back('A');
    answer_.push_back('>');
    return LinkResult::done;
  }

  Falcon& falcon_;
  std::deque<std::uint8_t> answer_;
  int baud_ = 0, latency_ = 0, block_ = 0, homing_ = 0;
  bool begins_ = false, is_loading_ = false, is_gone_ = false;
};

/// Returns the firmware: seven full blocks of 62 bytes, and a shorter block.
std::vector<std::uint8_t> image() {
  std::vector<std::uint8_t> bytes(62 * 7 + 30);
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(i * 37 + i / 62);
  return bytes;
}

FalconChoice choice_of(Falcon& falcon, std::vector<std::string>* notices = nullptr) {
  FalconChoice choice;
  choice.open_link = [&falcon]() -> Result<std::unique_ptr<UsbLink>> {
    return std::unique_ptr<UsbLink>(std::make_unique<Peer>(falcon));
  };
  choice.read_firmware = []() -> Result<std::vector<std::uint8_t>> { return image(); };
  if (notices) choice.notice = [notices](const std::string& text) { notices->push_back(text); };
  return choice;
}

}  // namespace

TEST(FalconDevice, ARunningDeviceIsHomedAndReportsItsPosition) {
  Falcon falcon;
  falcon.has_firmware = true;
  std::vector<std::string> notices;
  FalconDevice device(choice_of(falcon, &notices));
  const Status error = device.open();
  ASSERT_FALSE(error) << error->message();
  EXPECT_EQ(falcon.loads, 0);
  ASSERT_EQ(notices.size(), 1u);  // one instruction, not one per frame
  falcon.lock.lock();
  falcon.buttons = 2;
  falcon.lock.unlock();
  Pose pose;
  ASSERT_TRUE(eventually([&] { return device.read(0, pose) && pose.buttons == 2; }));
  FalconAngles angles;
  for (std::size_t i = 0; i < 3; ++i)
    angles[i] = FalconKinematics::angle_of(static_cast<std::int16_t>(falcon.counts[i]));
  const auto expected = FalconKinematics::forward(angles);
  EXPECT_LT(glm::length(pose.position_world + FalconKinematics::k_centre - *expected), 1e-6);
  device.close();
  EXPECT_EQ(falcon.links, 0);
}

TEST(FalconDevice, FirmwareIsLoadedDespiteKnownFaults) {
  for (const int fault : {0, 1, 2, 3, 4}) {
    Falcon falcon;
    falcon.has_leading_zero = fault == 1;
    falcon.silent_attempts = fault == 2 ? 1 : 0;
    falcon.bad_block = fault == 3 ? 4 : -1;
    falcon.splits_packets = falcon.adds_noise = fault == 4;
    FalconDevice device(choice_of(falcon));
    const Status error = device.open();
    ASSERT_FALSE(error) << fault << ": " << error->message();
    EXPECT_EQ(falcon.loaded, image());
    EXPECT_EQ(falcon.loads, fault == 2 || fault == 3 ? 2 : 1) << fault;
    Pose pose;
    EXPECT_TRUE(device.read(0, pose)) << fault;
  }
}

TEST(FalconDevice, FailuresNameTheirCause) {
  const auto cause = [](Falcon& falcon, const auto& change) {
    FalconChoice choice = choice_of(falcon);
    choice.load_attempts = 2;
    choice.homing_seconds = 0.2;
    change(choice);
    FalconDevice device(choice);
    const Status error = device.open();
    EXPECT_EQ(falcon.links, 0);  // nothing stays open
    return error ? error->where : std::string();
  };
  const auto as_is = [](FalconChoice&) {};
  Falcon mute;
  mute.silent_attempts = 99;
  EXPECT_EQ(cause(mute, as_is), "falcon: firmware");
  EXPECT_EQ(mute.loads, 2);
  Falcon unplugged;
  unplugged.unplug_block = 3;
  EXPECT_EQ(cause(unplugged, as_is), "falcon: absent");
  EXPECT_EQ(unplugged.loads, 1);  // no further attempt
  Falcon not_homed;
  not_homed.homes_after = -1;
  EXPECT_EQ(cause(not_homed, as_is), "falcon: not homed");
  const auto cancel = [calls = std::make_shared<int>(0)](FalconChoice& choice) {
    choice.homing_seconds = 60;
    choice.should_stop = [calls] { return ++*calls > 20; };
  };
  EXPECT_EQ(cause(not_homed, cancel), "falcon: cancelled");
  Falcon without_file;
  EXPECT_EQ(cause(without_file,
                  [](FalconChoice& choice) {
                    choice.read_firmware = []() -> Result<std::vector<std::uint8_t>> {
                      return Error{.what = "no file", .where = "falcon: firmware"};
                    };
                  }),
            "falcon: firmware");
  Falcon other;
  EXPECT_EQ(cause(other,
                  [](FalconChoice& choice) {
                    choice.open_link = []() -> Result<std::unique_ptr<UsbLink>> {
                      return Error{.what = "refused", .where = "falcon: permission"};
                    };
                  }),
            "falcon: permission");
}

TEST(FalconDevice, TheMotorsRenderTheForceAndNothingElse) {
  Falcon falcon;
  falcon.has_firmware = true;
  FalconDevice device(choice_of(falcon));
  ASSERT_FALSE(device.open());
  const std::array<int, 3> none{};
  wait_ms(20);
  {
    // No force before the servo writes one: not while the firmware is queried, during homing, or afterwards.
    const std::lock_guard guard(falcon.lock);
    for (const auto& values : falcon.motors) ASSERT_EQ(values, none);
  }
  // In the middle of the workspace, a force toward the user gives equal torques at all arms. The work of
  // these torques equals the work of the force.
  {
    const std::lock_guard guard(falcon.lock);
    falcon.counts = {};
  }
  Pose pose;
  ASSERT_TRUE(eventually([&] { return device.read(0, pose) && std::abs(pose.position_world.x) < 1e-6; }));
  // Writes a force until the motor values differ from zero and from `before`, and returns these values.
  // The values are constant when the force has returned after a pause of this thread.
  const auto rendered = [&](const dvec3& force, const std::array<int, 3>& before) {
    std::array<int, 3> values{};
    EXPECT_TRUE(eventually([&] {
      for (int i = 0; i < 5; ++i) device.write(Wrench(force)), wait_ms(2);
      const std::array<int, 3> last = std::exchange(values, falcon.last_motors());
      return values == last && values != none && values != before;
    }));
    return values;
  };
  const auto push = rendered({0, 0, 4}, none);
  EXPECT_NE(push[0], 0);
  EXPECT_EQ(push[0], push[1]);
  EXPECT_EQ(push[1], push[2]);
  const auto at = [](int count) {
    const double angle = FalconKinematics::angle_of(static_cast<std::int16_t>(count));
    return FalconKinematics::forward({angle, angle, angle})->z;
  };
  // Motor values are 10 per N mm. Each of the three arms turns by two counts of its encoder.
  const double turned = FalconKinematics::angle_of(1) - FalconKinematics::angle_of(0);
  EXPECT_NEAR(std::abs(push[0]) / 10.0 * 3 * 2 * turned, 4 * (at(1) - at(-1)), 4e-4);

  // A force beyond the limit of the motors keeps its direction.
  const auto strong = rendered({100, 50, 400}, push);
  const auto weak = rendered({1, 0.5, 4}, strong);
  int greatest = 0;
  for (const int value : strong) greatest = std::max(greatest, std::abs(value));
  EXPECT_EQ(greatest, 4095);
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_NEAR(static_cast<double>(strong[i]) / strong[0], static_cast<double>(weak[i]) / weak[0], 0.01);

  // If the servo stalls, the driver removes the force.
  device.write(Wrench(dvec3(0, 0, 4)));
  EXPECT_TRUE(eventually([&] { return falcon.last_motors() == none; }));
  // When the device is closed, its last frame has no force.
  for (int i = 0; i < 10; ++i) device.write(Wrench(dvec3(0, 0, 4))), wait_ms(1);
  device.close();
  EXPECT_EQ(falcon.last_motors(), none);
}

/// The error of a link whose device is still plugged in: the motors do not keep their last values.
TEST(FalconDevice, AnErrorOfTheLinkEndsTheForce) {
  Falcon falcon;
  falcon.has_firmware = true;
  FalconDevice device(choice_of(falcon));
  ASSERT_FALSE(device.open());
  Pose pose;
  const std::array<int, 3> none{};
  ASSERT_TRUE(eventually([&] {
    device.write(Wrench(dvec3(0, 0, 4)));
    return falcon.last_motors() != none;
  }));
  {
    const std::lock_guard guard(falcon.lock);
    falcon.has_error = true;
  }
  EXPECT_TRUE(eventually([&] {
    device.write(Wrench(dvec3(0, 0, 4)));
    return !device.read(0, pose);
  }));
  EXPECT_TRUE(eventually([&] { return falcon.last_motors() == none; }));
}

/// After a drop of the supply the counts begin again at 0: without homing they are no position.
TEST(FalconDevice, CountsThatAreNotHomedAreNotAPosition) {
  Falcon falcon;
  falcon.has_firmware = true;
  FalconDevice device(choice_of(falcon));
  ASSERT_FALSE(device.open());
  Pose before, pose;
  ASSERT_TRUE(device.read(0, before));
  std::size_t frames = 0;
  {
    const std::lock_guard guard(falcon.lock);
    falcon.loses_home = true;
    falcon.counts = {900, 900, 900};
    frames = falcon.motors.size();
  }
  ASSERT_TRUE(eventually([&] {
    const std::lock_guard guard(falcon.lock);
    return falcon.motors.size() > frames + 10;
  }));
  ASSERT_TRUE(device.read(0.05, pose));
  EXPECT_LT(glm::length(pose.position_world - before.position_world), 1e-9);
  double t = 1;
  EXPECT_TRUE(eventually([&] { return !device.read(t += 0.11, pose); }));
}

TEST(FalconDevice, LossIsReportedAndTheServoNeverWaits) {
  Falcon falcon;
  falcon.has_firmware = true;
  FalconDevice device(choice_of(falcon));
  ASSERT_FALSE(device.open());
  Pose pose;
  ASSERT_TRUE(device.read(0, pose));
  const auto frames = [&] {
    const std::lock_guard guard(falcon.lock);
    return falcon.motors.size();
  };
  const std::size_t first = frames();
  ASSERT_TRUE(eventually([&] { return frames() > first + 3; }));
  {
    const std::lock_guard guard(falcon.lock);
    falcon.falls_silent = true;
  }
  // Only the time of the servo decides: the device is lost 0.1 s after the last new report that the servo
  // read.
  ASSERT_TRUE(device.read(1, pose));
  EXPECT_TRUE(device.read(1.09, pose));
  // One more frame may have arrived before the device fell silent.
  double t = 1.09;
  EXPECT_TRUE(eventually([&] { return !device.read(t += 0.11, pose); }));
  {
    const std::lock_guard guard(falcon.lock);
    falcon.falls_silent = false;
  }
  EXPECT_TRUE(eventually([&] { return device.read(t, pose); }));
  {
    const std::lock_guard guard(falcon.lock);
    falcon.unplug_frame = static_cast<int>(falcon.motors.size()) + 5;
  }
  EXPECT_TRUE(eventually([&] { return !device.read(t, pose); }));
  // A driver thread that hangs in its link does not block the servo.
  Falcon held;
  held.has_firmware = true;
  FalconDevice other(choice_of(held));
  ASSERT_FALSE(other.open());
  held.lock.lock();
  for (int i = 0; i < 1000; ++i) {
    other.read(0.001 * i, pose);
    other.write(Wrench(dvec3(0, 0, 1)));
  }
  held.lock.unlock();
}

TEST(FalconDevice, ImpossibleCountsAreNotAPosition) {
  Falcon falcon;
  falcon.has_firmware = true;
  FalconDevice device(choice_of(falcon));
  ASSERT_FALSE(device.open());
  Pose before, pose;
  ASSERT_TRUE(device.read(0, before));
  {
    const std::lock_guard guard(falcon.lock);
    falcon.counts = {32767, -32768, 32767};
  }
  wait_ms(50);
  for (int i = 0; i < 90; ++i)
    EXPECT_TRUE(!device.read(0.001 * i, pose) || std::isfinite(glm::length(pose.position_world)));
  // Frames with impossible counts are ignored: after 0.1 s the device is lost, although frames arrive.
  double t = 1;
  EXPECT_TRUE(eventually([&] { return !device.read(t += 0.11, pose); }));
}
