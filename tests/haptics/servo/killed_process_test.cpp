// A process that is killed at any moment has sent its device bounded forces that begin at zero and change
// slowly.
#include <algorithm>
#include <array>
#include <atomic>
#include <csignal>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

#include "haptics/proxy/subvoxel_proxy.h"
#include "haptics/servo/servo_loop.h"
#include "tests/haptics/servo/servo_fixture.h"

namespace trephine::haptics {
namespace {

/// Wrenches that a device was sent, in memory that survives the process.
struct Log {
  std::array<glm::dvec3, 20000> forces;
  std::atomic<std::size_t> count;
  std::atomic<bool> should_stop, is_closed;
};

/// Presses 4 mm into a ball within 0.1 s, and keeps all that it is sent.
class LoggingDevice final : public Device {
 public:
  explicit LoggingDevice(Log& log) : log_(log) {}
  Status open() override { return std::nullopt; }
  void close() noexcept override { log_.is_closed = true; }
  DeviceCapabilities capabilities() const override { return {}; }
  bool read(double t, Pose& pose) noexcept override {
    pose.position_world = {0, 0, 46 - 5 * std::min(1.0, t / 0.1)};  // the radius of the ball is 45
    return true;
  }
  void write(const Wrench& wrench) noexcept override {
    const std::size_t i = log_.count;
    if (i == log_.forces.size()) return;
    log_.forces[i] = wrench.force_world;
    log_.count = i + 1;
  }

 private:
  Log& log_;
};

/// Returns the number of forces that exceed the limit, or that differ from the previous one by more than a
/// tick allows. The force before the first one is zero.
int violations(const Log& log, const ForceOptions& limits, double rate_hz) {
  int count = 0;
  glm::dvec3 last(0);
  for (std::size_t i = 0; i < log.count; ++i) {
    const glm::dvec3& force = log.forces[i];
    const bool is_fine = glm::length(force) <= limits.force_limit &&
                         glm::length(force - last) <= limits.slew_limit / rate_hz + 1e-9;
    count += !is_fine;
    last = force;
  }
  return count;
}

/// Runs a servo loop in a child process until the log is as long as `ticks`. Then kills the process, or
/// requests its end.
void run(Log& log, const TouchScene& scene, const SubvoxelProxy& method, std::size_t ticks, bool is_killed) {
  log.count = 0, log.should_stop = log.is_closed = false;
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    ServoChannel channel(servo_scene_of(scene, method));
    LoggingDevice device(log);
    ServoLoop loop(device, channel, {});
    if (loop.start()) std::_Exit(1);
    ServoRecord record;
    while (!log.should_stop) {
      while (loop.records().pop(record)) {}
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    loop.stop();
    std::_Exit(0);
  }
  for (int i = 0; i < 100000 && log.count < ticks; ++i)
    std::this_thread::sleep_for(std::chrono::microseconds(200));
  if (is_killed)
    ::kill(child, SIGKILL);
  else
    log.should_stop = true;
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_EQ(is_killed ? WIFSIGNALED(status) != 0 : WIFEXITED(status) && WEXITSTATUS(status) == 0, true);
  EXPECT_GE(log.count, ticks);
}

TEST(KilledProcess, SentOnlyForcesThatBeginAtZeroAndChangeSlowly) {
  void* const memory =
      ::mmap(nullptr, sizeof(Log), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  ASSERT_NE(memory, MAP_FAILED);
  Log& log = *new (memory) Log;
  const TouchScene scene = scenes::phantom_scene("sphere", phantom_options(32));
  SubvoxelProxy method;
  ASSERT_FALSE(method.prepare(scene));
  const ForceOptions limits;
  constexpr double k_rate_hz = 1000;
  double most = 0;
  for (const std::size_t ticks : {1u, 2u, 3u, 5u, 8u, 20u, 60u, 150u, 400u}) {
    run(log, scene, method, ticks, true);
    EXPECT_EQ(violations(log, limits, k_rate_hz), 0) << ticks;
    EXPECT_FALSE(log.is_closed) << "a killed process closes no device";
    for (std::size_t i = 0; i < log.count; ++i) most = std::max(most, glm::length(log.forces[i]));
  }
  EXPECT_GT(most, 1) << "the device was pressed into the ball";
  // The planted fault: a force that begins at once.
  log.forces[0] = {0, 0, 2}, log.count = 1;
  EXPECT_EQ(violations(log, limits, k_rate_hz), 1);

  // A process that ends by itself leaves no force.
  run(log, scene, method, 200, false);
  EXPECT_EQ(violations(log, {.slew_limit = 1e9}, k_rate_hz), 0);
  EXPECT_EQ(log.forces[log.count - 1], glm::dvec3(0));
  EXPECT_TRUE(log.is_closed);
  ::munmap(memory, sizeof(Log));
}

}  // namespace
}  // namespace trephine::haptics
