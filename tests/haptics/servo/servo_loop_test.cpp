#include "haptics/servo/servo_loop.h"

#include <atomic>
#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <limits>
#include <set>

#include "haptics/force/coupling.h"
#include "haptics/proxy/implicit_proxy.h"
#include "haptics/proxy/subvoxel_proxy.h"
#include "tests/haptics/servo/servo_fixture.h"

namespace trephine::haptics {
namespace {

/// Waits until the loop has run `ticks` ticks. Fails after about ten seconds, enough for a busy machine.
void wait_for_ticks(const ServoLoop& loop, std::uint64_t ticks) {
  for (int i = 0; i < 2000 && loop.report().ticks < ticks; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  ASSERT_GE(loop.report().ticks, ticks);
}

TEST(Ring, KeepsOrderAndReportsWhenItIsFull) {
  Ring<int> ring(4);
  for (int i = 0; i < 4; ++i) EXPECT_TRUE(ring.push(i));
  EXPECT_FALSE(ring.push(4));
  int v = -1;
  for (int i = 0; i < 4; ++i) {
    ASSERT_TRUE(ring.pop(v));
    EXPECT_EQ(v, i);
  }
  EXPECT_FALSE(ring.pop(v));
}

TEST(Ring, CarriesEverythingBetweenThreads) {
  Ring<int> ring(64);
  long sum = 0;
  std::thread consumer([&] {
    int v = 0;
    for (int seen = 0; seen < 200000;)
      if (ring.pop(v))
        sum += v, ++seen;
      else
        std::this_thread::yield();
  });
  for (int i = 0; i < 200000;)
    if (ring.push(i))
      ++i;
    else
      std::this_thread::yield();
  consumer.join();
  EXPECT_EQ(sum, 200000L * 199999L / 2);
}

TEST(Histogram, PercentilesAreWithinABucket) {
  Histogram h;
  for (std::uint64_t i = 1; i <= 100000; ++i) h.add(i);
  EXPECT_NEAR(h.percentile_us(50), 50.0, 50.0 * 0.04);
  EXPECT_NEAR(h.percentile_us(99), 99.0, 99.0 * 0.04);
  EXPECT_DOUBLE_EQ(h.max_us(), 100.0);
  EXPECT_EQ(h.count(), 100000u);
}

TEST(ServoLoop, RunsTicksInOrderAndTouchesTheSurface) {
  const TouchScene scene = scenes::phantom_scene("sphere", phantom_options(64));
  ImplicitProxy method;
  ServoChannel channel(servo_scene_of(scene, method));
  ASSERT_FALSE(method.prepare(scene).has_value());
  const PosePath request =
      PosePath::from_samples({{0, {{0, 0, 50}}}, {0.1, {{0, 0, 43}}}, {1, {{0, 0, 43}}}}, "test").value();
  VirtualDevice device(request, {});
  ServoLoop loop(device, channel, {});
  ASSERT_FALSE(loop.start().has_value());
  ServoRecord record;
  std::uint64_t expected = 0;
  double strongest = 0;
  for (int wait = 0; wait < 2000 && expected < 500; ++wait) {
    while (loop.records().pop(record)) {
      ASSERT_EQ(record.tick, expected++);
      strongest = std::max(strongest, record.force_world.z);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  loop.stop();
  EXPECT_GE(expected, 500u);
  EXPECT_GT(strongest, 0.2);
  const ServoReport report = loop.report();
  EXPECT_GE(report.ticks, 500u);
  EXPECT_GT(report.step_p50_us, 0);
  EXPECT_EQ(report.faults & (fault_lost_device | fault_not_finite), 0u);
}

TEST(ServoLoop, ALostDeviceFadesTheForceAndAFullRingIsAFault) {
  const TouchScene scene = scenes::phantom_scene("sphere", phantom_options(32));
  ImplicitProxy method;
  ServoChannel channel(servo_scene_of(scene, method));
  ASSERT_FALSE(method.prepare(scene).has_value());
  const PosePath request = PosePath::from_samples({{0, {{0, 0, 50}}}, {0.05, {{0, 0, 42}}}}, "test").value();
  {
    VirtualDevice device(request, {});
    device.lose_at(0.2);
    ServoOptions options;
    options.rate_hz = 2000;
    ServoLoop loop(device, channel, options);
    ASSERT_FALSE(loop.start().has_value());
    wait_for_ticks(loop, 700);
    loop.stop();
    ServoRecord record;
    while (loop.records().pop(record)) {
      if (record.t >= 0.26) {
        ASSERT_EQ(record.force_world, glm::dvec3(0));
      }
    }
    EXPECT_TRUE(loop.report().faults & fault_lost_device);
  }
  {
    VirtualDevice device(request, {});
    ServoOptions options;
    options.ring_capacity = 16;
    ServoLoop loop(device, channel, options);
    ASSERT_FALSE(loop.start().has_value());
    wait_for_ticks(loop, 50);
    loop.stop();
    EXPECT_TRUE(loop.report().faults & fault_full_ring);
  }
}

/// The test reads no record for 0.7 s. The waiting records make the scene stale at every rate: the force
/// fades, and no tick is lost.
TEST(ServoLoop, LateEditsFadeTheForceBeforeTheRingIsFullAtEveryRate) {
  const TouchScene scene = scenes::phantom_scene("sphere", phantom_options(32));
  ImplicitProxy method;
  ServoChannel channel(servo_scene_of(scene, method));
  ASSERT_FALSE(method.prepare(scene).has_value());
  const PosePath request = PosePath::from_samples({{0, {{0, 0, 50}}}, {0.05, {{0, 0, 42}}}}, "test").value();
  for (const double rate : {1000.0, 10000.0}) {
    VirtualDevice device(request, {});
    ServoOptions options;
    options.rate_hz = rate;
    options.watchdog_seconds = 10;  // so that delays of this machine do not raise the fault
    ServoLoop loop(device, channel, options);
    ASSERT_FALSE(loop.start().has_value());
    // A second start is refused, and the loop continues.
    const Status again = loop.start();
    ASSERT_TRUE(again.has_value());
    EXPECT_NE(again->message().find("already running"), std::string::npos);
    for (int i = 0; i < 5000 && static_cast<double>(loop.report().ticks) < 0.7 * rate; ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    loop.stop();
    EXPECT_TRUE(loop.report().faults & fault_stale_scene) << rate;
    EXPECT_FALSE(loop.report().faults & fault_full_ring) << rate;
    EXPECT_EQ(loop.report().dropped, 0u) << rate;
    ServoRecord record;
    glm::dvec3 last(1);
    while (loop.records().pop(record)) last = record.force_world;
    EXPECT_EQ(last, glm::dvec3(0)) << rate;
  }
}

TEST(ServoLoop, RefusesMoreDevicesThanTheSceneHasHands) {
  const TouchScene scene = scenes::phantom_scene("sphere", phantom_options(32));
  ImplicitProxy method;
  ASSERT_FALSE(method.prepare(scene).has_value());
  ServoChannel channel(servo_scene_of(scene, method));
  VirtualDevice left(scenes::sphere_slide(45, 1, 100, 1), {}), right(scenes::sphere_slide(45, 1, 100, 1), {});
  Device* devices[] = {&left, &right};
  ServoLoop loop(devices, channel, {});
  const Status error = loop.start();
  ASSERT_TRUE(error.has_value());
  EXPECT_NE(error->message().find("hands"), std::string::npos) << error->message();
}

TEST(ServoLoop, AFaultIsClearedOnRequest) {
  const TouchScene scene = scenes::phantom_scene("sphere", phantom_options(32));
  ImplicitProxy method;
  ServoChannel channel(servo_scene_of(scene, method));
  ASSERT_FALSE(method.prepare(scene).has_value());
  const PosePath request = PosePath::from_samples({{0, {{0, 0, 50}}}, {0.05, {{0, 0, 42}}}}, "test").value();
  VirtualDevice device(request, {});
  ServoOptions options;
  options.ring_capacity = 64;
  ServoLoop loop(device, channel, options);
  ASSERT_FALSE(loop.start().has_value());
  const auto wait_until = [&](auto&& done) {
    for (int i = 0; i < 1000 && !done(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(2));
    return done();
  };
  EXPECT_TRUE(wait_until([&] { return (loop.report().faults & fault_full_ring) != 0; }));
  ServoRecord record;
  loop.request_reset();
  EXPECT_TRUE(wait_until([&] {
    while (loop.records().pop(record)) {}
    return (loop.report().faults & k_latched_faults) == 0;
  }));
  loop.stop();
}

/// Presses a ball with the button down, and does not respond for a while.
class FailingDevice final : public Device {
 public:
  std::atomic<bool> is_pressed{true};
  DeviceCapabilities abilities;
  Status open() override { return std::nullopt; }
  void close() noexcept override {}
  DeviceCapabilities capabilities() const override { return abilities; }
  bool read(double t, Pose& pose) noexcept override {
    if (t > 0.1 && t < 0.12) return false;
    pose.position_world = {0, 0, std::max(42.0, 50 - 100 * t)};
    pose.press(is_pressed);
    pose.axes[0] = is_pressed ? 1.0f : 0.0f;
    pose.axes[1] = 0.6f;  // a wheel that stays where it is
    return true;
  }
  void write(const Wrench&) noexcept override {}
};

/// A loop whose device fails with its button down, until the fault was cleared.
struct FaultRun {
  TouchScene scene = scenes::phantom_scene("sphere", phantom_options(64));
  ImplicitProxy method;
  std::optional<ServoChannel> channel;
  FailingDevice device;
  std::optional<ServoLoop> loop;
  std::vector<ServoRecord> all;
  std::size_t reset = 0;  ///< number of records up to that of the reset

  explicit FaultRun(const DeviceCapabilities& abilities) {
    device.abilities = abilities;
    EXPECT_FALSE(method.prepare(scene).has_value());
    channel.emplace(servo_scene_of(scene, method));
    ServoOptions options;
    options.ring_capacity = 1 << 16;
    options.watchdog_seconds = 100, options.lag_seconds = 100;  // a loaded machine is no fault here
    loop.emplace(device, *channel, options);
    EXPECT_FALSE(loop->start().has_value());
    EXPECT_TRUE(wait_until([&] { return !all.empty() && (all.back().faults & fault_lost_device) != 0; }));
    const std::size_t fault = all.size();
    EXPECT_TRUE(wait_until([&] { return all.size() > fault + 200; }));
    loop->request_reset();
    EXPECT_TRUE(wait_until([&] { return (all.back().faults & k_latched_faults) == 0; }));
    reset = all.size();
    while (reset > 1 && !all[reset - 1].is_reset) --reset;
    EXPECT_TRUE(wait_until([&] { return all.size() > reset + 1500; }));
  }
  bool wait_until(const std::function<bool()>& done) {
    for (int i = 0; i < 5000 && !done(); ++i) {
      ServoRecord record;
      while (loop->records().pop(record)) all.push_back(record);
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    return done();
  }
};

TEST(ServoLoop, AfterAFaultTheToolStaysAndWorksAgainAfterItsButtonWasReleased) {
  FaultRun run({});
  run.device.is_pressed = false;
  const std::size_t released = run.all.size();
  ASSERT_TRUE(run.wait_until([&] { return run.all.size() > released + 500; }));
  run.device.is_pressed = true;
  ASSERT_TRUE(run.wait_until([&] { return run.all.back().pose.is_pressed(); }));
  run.loop->stop();
  EXPECT_TRUE(run.all[50].pose.is_pressed());
  double last = 0;
  for (std::size_t i = run.reset - 1; i < released; ++i) {
    const ServoRecord& r = run.all[i];
    EXPECT_FALSE(r.pose.is_pressed());
    EXPECT_EQ(r.pose.axes[0], 0.0f);
    EXPECT_TRUE(r.has_contact);
    EXPECT_GT(glm::length(r.proxy_world), 44) << "the tool stays at the surface of the ball";
    const double force = glm::length(r.force_world);
    EXPECT_LT(force, 10e-3 * static_cast<double>(i + 2 - run.reset) + 1e-9) << "the force rises from zero";
    EXPECT_GE(force, last - 1e-6);
    last = force;
  }
  EXPECT_GT(last, 0.5);
}

/// Nothing moves the hand of a user of a mouse, and no person holds a simulated device.
TEST(ServoLoop, AfterAFaultAMouseAndASimulatedHandContinue) {
  for (const DeviceCapabilities& abilities :
       {DeviceCapabilities{.name = "mouse", .max_force = 0},
        DeviceCapabilities{.name = "simulated", .is_simulated = true}}) {
    FaultRun run(abilities);
    run.loop->stop();
    bool was_released = false;
    for (std::size_t i = 50; i + 1 < run.reset; ++i) was_released |= !run.all[i].pose.is_pressed();
    EXPECT_TRUE(was_released) << "nothing is cut during the fault";
    for (std::size_t i = run.reset; i < run.all.size(); ++i) {
      EXPECT_TRUE(run.all[i].pose.is_pressed());
      EXPECT_EQ(run.all[i].pose.axes[0], 1.0f);
      EXPECT_GT(glm::length(run.all[i].proxy_world), 44) << "the tool stays at the surface of the ball";
    }
  }
}

/// Moves from one side of a ball to the other in one tick, lifted over the ball or straight through it.
class LiftedDevice final : public Device {
 public:
  static constexpr double k_height = 50;  // mm; the radius of the ball is 45
  explicit LiftedDevice(bool is_lifted) : is_lifted_(is_lifted) {}
  Status open() override { return std::nullopt; }
  void close() noexcept override {}
  DeviceCapabilities capabilities() const override { return {}; }
  bool read(double t, Pose& pose) noexcept override {
    const bool is_behind = t >= 0.1;
    if (is_behind && !was_behind_ && is_lifted_) jump_ = glm::dvec3(0, 0, -k_height);
    was_behind_ = is_behind;
    pose.position_world = {0, 0, is_behind ? -k_height : k_height};
    return true;
  }
  std::optional<glm::dvec3> fetch_jump() noexcept override { return std::exchange(jump_, std::nullopt); }
  void write(const Wrench&) noexcept override {}

 private:
  bool is_lifted_, was_behind_ = false;
  std::optional<glm::dvec3> jump_;
};

TEST(ServoLoop, ALiftedToolStartsAgainInTheTickOfItsJump) {
  const TouchScene scene = scenes::phantom_scene("sphere", phantom_options(32));
  SubvoxelProxy method;
  ASSERT_FALSE(method.prepare(scene).has_value());
  for (const bool is_lifted : {true, false}) {
    ServoChannel channel(servo_scene_of(scene, method));
    LiftedDevice lifted(is_lifted);
    glm::dvec3 last(0, 0, LiftedDevice::k_height);
    Recorder device(lifted, 10);  // must forward the jump
    ServoLoop loop(device, channel, {});
    ASSERT_FALSE(loop.start().has_value());
    wait_for_ticks(loop, 200);
    loop.stop();
    int restarts = 0, contacts = 0;
    for (ServoRecord record; loop.records().pop(record);) {
      const bool has_moved = record.pose.position_world != last;
      last = record.pose.position_world;
      EXPECT_EQ(record.is_restarted, has_moved && is_lifted) << record.tick;
      restarts += record.is_restarted, contacts += record.has_contact;
    }
    EXPECT_EQ(restarts, is_lifted ? 1 : 0);
    EXPECT_EQ(contacts > 0, !is_lifted) << "a tool that is not lifted meets the ball";
  }
}

/// Delays the servo once by 250 ms, as a busy machine may do.
class HoldingDevice final : public Device {
 public:
  Status open() override { return std::nullopt; }
  void close() noexcept override {}
  DeviceCapabilities capabilities() const override { return {}; }
  bool read(double t, Pose& pose) noexcept override {
    pose.position_world = {0, 0, 42};
    if (t >= 0.1 && !was_held_.exchange(true)) std::this_thread::sleep_for(std::chrono::milliseconds(250));
    return true;
  }
  void write(const Wrench&) noexcept override {}

 private:
  std::atomic<bool> was_held_{false};
};

TEST(ServoLoop, ALateWakeFadesTheForceAndLatches) {
  const TouchScene scene = scenes::phantom_scene("sphere", phantom_options(32));
  ImplicitProxy method;
  ServoChannel channel(servo_scene_of(scene, method));
  ASSERT_FALSE(method.prepare(scene).has_value());
  HoldingDevice device;
  ServoLoop loop(device, channel, {});
  ASSERT_FALSE(loop.start().has_value());
  wait_for_ticks(loop, 400);
  loop.stop();
  ServoRecord record;
  std::uint64_t faulty = 0;
  while (loop.records().pop(record)) {
    if (faulty == 0 && (record.faults & fault_stale_scene)) faulty = record.tick;
    if (faulty != 0 && record.tick > faulty + 51) {
      ASSERT_EQ(record.force_world, glm::dvec3(0));
      ASSERT_FALSE(record.pose.is_pressed());
    }
  }
  EXPECT_GE(faulty, 100u);
}

TEST(ServoLoop, RefusesMoreForceThanADeviceRenders) {
  class WeakDevice final : public Device {
   public:
    Status open() override { return std::nullopt; }
    void close() noexcept override {}
    DeviceCapabilities capabilities() const override { return {"weak", 3, 3.3, 0.6, 80, 0, 0.05, 0.002}; }
    bool read(double, Pose&) noexcept override { return true; }
    void write(const Wrench&) noexcept override {}
  };
  const TouchScene scene = scenes::phantom_scene("sphere", phantom_options(32));
  SubvoxelProxy method;
  ServoChannel channel(servo_scene_of(scene, method));
  ASSERT_FALSE(method.prepare(scene).has_value());
  WeakDevice device;
  ServoOptions options;
  ServoLoop strong(device, channel, options);
  const Status refused = strong.start();
  ASSERT_TRUE(refused.has_value());
  EXPECT_NE(refused->message().find("weak"), std::string::npos);
  options.force = within_limits(options.force, device.capabilities());
  ServoLoop fitting(device, channel, options);
  EXPECT_FALSE(fitting.start().has_value());
  fitting.stop();
}

TEST(ServoLoop, RefusesImpossibleRates) {
  const TouchScene scene = scenes::phantom_scene("sphere", phantom_options(16));
  ImplicitProxy method;
  ServoChannel channel(servo_scene_of(scene, method));
  VirtualDevice device(PosePath::from_samples({{0, {{0, 0, 50}}}}, "test").value(), {});
  for (const double rate : {0.0, 249.0, 10001.0, std::nan("")}) {
    ServoOptions options;
    options.rate_hz = rate;
    ServoLoop loop(device, channel, options);
    EXPECT_TRUE(loop.start().has_value());
  }
}

}  // namespace
}  // namespace trephine::haptics
