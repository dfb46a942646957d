// Device: interface of haptic devices, with devices that play back, simulate and record.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "haptics/device/pose_path.h"
#include "haptics/device/wrench.h"

namespace trephine::haptics {

struct DeviceCapabilities {
  std::string name;
  int degrees_of_freedom = 3;
  double max_force = 8;           ///< N; 0: no force output
  double max_stiffness = 1;       ///< N/mm; 0: unknown
  double workspace_radius = 100;  ///< mm
  double max_slew = 0;            ///< N/s; 0: unknown
  double mass = 0;                ///< kg, moving with the hand; 0: unknown
  double damping = 0;             ///< N s/mm, of the device itself; 0: unknown
  double max_torque = 0;          ///< N mm; 0: no torque output, or unknown
  bool is_simulated = false;      ///< no person holds the device
  /// Returns true if the device moves the hand of a person.
  bool has_motors() const noexcept { return max_force > 0 && !is_simulated; }
};

/// Position and axes of a device in the world, as the user sees them.
struct DeviceView {
  glm::dvec3 start_world{0.0};               ///< position of the tool when the device starts
  glm::dquat world_from_device{1, 0, 0, 0};  ///< device frame: x to the right, y up, z toward the user
};

/// Ball of the world that a device reaches.
struct Workspace {
  glm::dvec3 centre_world{0.0};
  double radius = 0;  ///< mm
};

/// A haptic device. open() and close() may run on any thread, read() and write() on the servo thread only.
/// Neither read() nor write() may allocate or wait.
class Device {
 public:
  virtual ~Device() = default;
  virtual Status open() = 0;
  virtual void close() noexcept = 0;
  virtual DeviceCapabilities capabilities() const = 0;
  /// Reads the pose at servo time t (s). Returns false, and leaves `pose` as is, if the device does not
  /// respond.
  virtual bool read(double t, Pose& pose) noexcept = 0;
  /// Returns a free point (world, mm) if the tool jumped since the last call: no motion connects the pose of
  /// the last read() with the previous one, and the proxy starts again at this point in the same tick.
  virtual std::optional<glm::dvec3> fetch_jump() noexcept { return std::nullopt; }
  /// Renders a wrench that is already limited. A device without torque output ignores the torque.
  virtual void write(const Wrench& wrench) noexcept = 0;
  /// Sets the view. The window's thread calls it before open() and whenever the camera has turned. Devices
  /// whose poses are in the world frame ignore it.
  virtual void set_view(const DeviceView&) noexcept {}
  /// Returns the ball that the device reaches at present; nullopt if it is unknown or unlimited. Any thread.
  virtual std::optional<Workspace> workspace() const noexcept { return std::nullopt; }
};

/// Plays a path and ignores forces.
class PlaybackDevice final : public Device {
 public:
  explicit PlaybackDevice(PosePath path) : path_(std::move(path)) {}
  Status open() override { return std::nullopt; }
  void close() noexcept override {}
  DeviceCapabilities capabilities() const override { return {"playback", 6, 0, 0, 1e6, 0, 0, 0, 0, true}; }
  bool read(double t, Pose& pose) noexcept override {
    pose = path_.at(path_.start_time() + t);
    return true;
  }
  void write(const Wrench&) noexcept override {}

 private:
  PosePath path_;
};

/// Parameters of the simulated hand and device of VirtualDevice.
struct HandModel {
  double mass = 0.05;             ///< kg, of the stylus and the parts that move with it
  double device_damping = 0.002;  ///< N s/mm
  double stiffness = 0.3;         ///< N/mm, from the hand to its requested position
  double damping = 0.006;         ///< N s/mm, of the hand
  double encoder_step = 0.02;     ///< mm; 0: exact
  /// mm: the hand turns the stylus as if mass, spring and damper acted at this distance from the HIP.
  double grip = 20;
};

/// A hand that follows requested poses and yields to the wrench: mass, spring, damper, encoder. Its
/// orientation is the requested one, turned by the torque. Integrated by implicit Euler.
class SimulatedHand {
 public:
  explicit SimulatedHand(const HandModel& model) : model_(model) {}
  /// Puts the hand at rest.
  void rest_at(const glm::dvec3& position) noexcept;
  /// Moves by `dt` (s, above 0). `request_velocity`: of the requested position, mm/s.
  void step(const Pose& request, const glm::dvec3& request_velocity, const Wrench& wrench,
            double dt) noexcept;
  /// Returns the pose of the hand, with the buttons and axes of the request.
  Pose pose(const Pose& request) const noexcept;
  /// Returns the kinetic energy of the moving mass, N mm, without that of rotation.
  double kinetic_energy() const noexcept;

 private:
  HandModel model_;
  glm::dvec3 position_{0.0}, velocity_{0.0};
  glm::dvec3 yield_{0.0}, yield_rate_{0.0};  ///< rotation from the requested orientation, rad; rad/s
};

/// Simulated hand that follows a path, at the servo's period, with the last wrench.
class VirtualDevice final : public Device {
 public:
  VirtualDevice(PosePath request, const HandModel& hand);
  Status open() override;
  void close() noexcept override {}
  DeviceCapabilities capabilities() const override {
    return {"virtual", 6, 8, 1, 1e3, 0, hand_.mass, hand_.device_damping, 1e3, true};
  }
  bool read(double t, Pose& pose) noexcept override;
  void write(const Wrench& wrench) noexcept override { wrench_ = wrench; }

  /// Simulates an unplugged device: read() fails from servo time t (s) on.
  void lose_at(double t) noexcept { lost_from_ = t; }
  double kinetic_energy() const noexcept { return simulated_.kinetic_energy(); }

 private:
  PosePath request_;
  HandModel hand_;
  SimulatedHand simulated_;
  Wrench wrench_;
  double time_ = 0, lost_from_ = 1e300;
};

/// Forwards to a device and records its poses for a path file: at most `capacity`, allocated by the
/// constructor.
class Recorder final : public Device {
 public:
  Recorder(Device& device, std::size_t capacity) : device_(&device) { samples_.reserve(capacity); }
  Status open() override { return device_->open(); }
  void close() noexcept override { device_->close(); }
  DeviceCapabilities capabilities() const override { return device_->capabilities(); }
  bool read(double t, Pose& pose) noexcept override;
  std::optional<glm::dvec3> fetch_jump() noexcept override { return device_->fetch_jump(); }
  void write(const Wrench& wrench) noexcept override { device_->write(wrench); }

  /// Returns the recording. Call after the servo has stopped. Error if nothing was recorded.
  Result<PosePath> path() const { return PosePath::from_samples(samples_, "recording"); }
  /// Returns the number of poses not recorded: the buffer was full, or the time did not increase.
  std::size_t dropped() const noexcept { return dropped_; }

 private:
  Device* device_;
  std::vector<PosePath::Sample> samples_;
  std::size_t dropped_ = 0;
};

}  // namespace trephine::haptics
