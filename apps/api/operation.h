// Operation: surgery on a scan, for programs in C++. Poses and commands in; forces, cuts, events, measures,
// surfaces and images out. docs/concepts.md explains it.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "haptics/device/device.h"
#include "sim/api/command.h"
#include "sim/api/event.h"
#include "volume/base/error.h"
#include "volume/imaging/image_plane.h"
#include "volume/scan/volume.h"

namespace trephine {

using haptics::DeviceCapabilities, haptics::Pose;
using sim::Command, sim::Event, sim::Measure;
using volume::ImagePlane, volume::Volume;

/// A hand. `trephine modules` lists the instruments with their parameters.
struct Hand {
  std::string instrument = {};  ///< "burr", "craniotome", ...; empty: the hand only touches
  std::string parameters = {};  ///< in words: "diameter=4 removal_rate=30"
  /// mm, radius of the ball with which the hand touches; 0: a point. An instrument with a contact geometry of
  /// its own, such as the craniotome or a round burr, replaces this ball.
  double tool_radius = 0;
  std::string method = {};  ///< contact method; empty: "subvoxel"
  /// Forces in addition to those of surfaces, in words: "viscous damping=0.004".
  std::vector<std::string> effects = {};
};

/// Recording of an operation to a new file.
struct Recording {
  std::string file = {};      ///< empty: no recording
  bool is_embedding = false;  ///< the file also contains the scan
  std::string program = {};   ///< name and version of your program, stored in the file
};

struct OperationOptions {
  std::vector<Hand> hands = {Hand()};
  /// Devices that render the forces. Force, torque and the stiffness of the structures are reduced
  /// to their limits; implants, guides and effects keep their stiffness.
  std::vector<DeviceCapabilities> devices = {};
  /// Solid that is touched and cut; at most one of these three. By default the touchable structures of a
  /// case, or bone.
  std::optional<double> iso = std::nullopt;  ///< this value and above
  std::string window = {};                   ///< values "LO:HI"
  std::string label = {};                    ///< name of a label
  /// For a built-in phantom: also uses its structures, screws and planned trajectories.
  bool uses_plan = false;
  /// For a volume in memory with uses_plan: the name of the built-in phantom that it is, with its default
  /// seed and parameters.
  std::string phantom = {};
  double rate_hz = 1000;  ///< ticks per second, 10 to 100000
  /// mm, diameter of the smallest burr that will cut; empty: the smallest that the hands' instruments need.
  std::optional<double> smallest_burr = std::nullopt;
  Recording recording = {};
  /// Receives sentences about assumptions, such as a missing slice that was interpolated.
  std::function<void(const std::string& text)> notice = [](const std::string&) {};
};

/// Result of a tick for one hand. World frame.
struct Touch {
  glm::dvec3 proxy_world{0.0};   ///< mm
  glm::dvec3 normal_world{0.0};  ///< unit, toward the proxy; 0 without contact
  glm::dvec3 force_world{0.0};   ///< N, for the device: finite, limited, slew-limited
  glm::dvec3 torque_world{0.0};  ///< N mm
  bool has_contact = false;
  bool is_from_inside = false;  ///< touches the back of a surface, from within the solid
  int item = -1;                ///< index of the touched structure; -1 without contact
  /// Bits of haptics::FaultBit: faults that are latched until reset(), and limits that were applied to the
  /// force in this tick. A latched fault brings the force to 0, by default within 50 ms.
  std::uint32_t faults = 0;
};

struct DeviceOptions {
  std::string pedal = {};  ///< "pedal", "pedal:1": its buttons are added to the poses; empty: no pedal
  double scale = 1;        ///< motion of the tool per motion of the device, 0.1 to 10
  /// Position of the tool when the device is opened, and axes of the device: x to the right, y up, z toward
  /// the user.
  haptics::DeviceView view = {};
  /// Receives instructions for the user, such as how to home the device, while open() waits.
  std::function<void(const std::string& text)> notice = [](const std::string&) {};
};

/// A haptic device, a 3-D mouse or a recorded path that moves a hand of an operation, for programs with a
/// servo loop of their own: read() a pose, Operation::step(), write() the result, about once per millisecond.
class HandDevice {
 public:
  /// Opens a device by its name: "falcon", "touch", "spacemouse:1", "playback:PATH.csv", "virtual:PATH.csv"
  /// (docs/devices.md). Takes up to some seconds, longer while the user homes the device.
  static Result<HandDevice> open(const std::string& name, const DeviceOptions& options = {});
  HandDevice(HandDevice&&) noexcept = default;
  HandDevice& operator=(HandDevice&&) noexcept;
  ~HandDevice();  ///< switches the force off
  /// For OperationOptions::devices.
  const DeviceCapabilities& capabilities() const noexcept { return capabilities_; }
  /// Returns the pose at time t (s) of the program's loop; nullopt if the device does not respond. In that
  /// case, write an empty Touch, so that the hand has no force. Does not wait.
  std::optional<Pose> read(double t) noexcept;
  /// Renders the force and torque of a step, within the limits of the device. After the device did not
  /// respond, the force returns within 0.1 s. Hardware switches its force off 50 ms after the last call. Does
  /// not wait.
  void write(const Touch& touch) noexcept;

 private:
  HandDevice(std::shared_ptr<haptics::Device> device, DeviceCapabilities capabilities) noexcept
      : device_(std::move(device)), capabilities_(std::move(capabilities)) {}
  std::shared_ptr<haptics::Device> device_;  ///< null after a move
  DeviceCapabilities capabilities_;
};

/// Triangles in the world frame, mm, counter-clockwise as viewed from outside.
struct Surface {
  std::vector<glm::dvec3> vertices_world;
  std::vector<std::uint32_t> triangles;  ///< three vertex indices each
};

/// A detached part of the anatomy, or an implant.
struct Body {
  std::uint32_t id = 0;  ///< number in commands: "hold-body" with "body=3"
  int holder = -1;       ///< the hand that holds it; -1: not held
  double mm3 = 0;
  glm::dvec3 position_world{0.0};   ///< mm, current origin of the frame of `surface`
  glm::dquat rotation{1, 0, 0, 0};  ///< current rotation of the frame of `surface`
  /// In the frame of the body, which was the world frame at its detachment; for an implant, in the frame of
  /// the implant.
  std::shared_ptr<const Surface> surface;
};

/// A trajectory of the plan, mm.
struct PlannedLine {
  std::string name;
  glm::dvec3 entry_world{0.0}, target_world{0.0};
};
/// A landmark of the plan, mm.
struct PlannedPosition {
  std::string name;
  glm::dvec3 position_world{0.0};
};

/// A row of a score: a measured value, its verdict and its points.
struct Finding {
  std::string name;                    ///< "L4 left: breach"
  std::optional<double> value;         ///< empty: it could not be judged
  std::string unit;                    ///< "mm"; empty: dimensionless
  std::string verdict;                 ///< "good", "fair", "bad", "not judged"; "reported": it has no limits
  std::string reason;                  ///< one sentence; may be empty
  double points = 0, weight = 0;       ///< `weight`: the most points that the finding can have
  std::optional<std::uint64_t> tick;   ///< when it happened
  std::optional<glm::dvec3> position;  ///< world, mm, where it happened
};
struct Score {
  std::vector<Finding> findings;
  double points = 0;
  double possible = 0;                ///< sum of the weights of judged findings
  double not_judged = 0;              ///< sum of the weights of findings that could not be judged
  std::vector<std::string> critical;  ///< names of bad findings of weight 4 or more
};

/// A value that the calling program measured, to be judged with the findings of the modules.
struct MeasuredValue {
  std::string name;             ///< differs from those of all other findings
  std::optional<double> value;  ///< empty: it could not be measured
  std::string unit = {};        ///< "mm"; empty: dimensionless
  std::string reason = {};      ///< one sentence; may be empty
  /// Value that gives all points, and value that gives 0 points; linear between them. If both are equal, the
  /// value is only reported.
  double full_at = 0, zero_at = 0;
  double weight = 0;  ///< points at `full_at`
};

/// Image row by row from the upper left.
template <class Pixel>
struct Image {
  int columns = 0, rows = 0;
  std::vector<Pixel> pixels;
};

/// Matter at a position. The sample describes the first structure that was solid there before any cut, or
/// otherwise the structure with the largest value.
struct Sample {
  int item = -1;            ///< index of the structure; -1: outside the scan
  bool is_solid = false;    ///< in the structure, and not removed
  bool is_removed = false;  ///< a tool removed the matter there
  /// Field of the structure without cuts: intensity minus the threshold (for a window, distance from the
  /// nearer limit), or +-0.5 for a label; interpolated. Not negative: solid.
  double value = 0;
  glm::dvec3 gradient_world{0.0};  ///< of `value`, per mm
  double cut_distance = 0;         ///< mm to removed matter, negative in it; limited to some voxels
  int label = 0;                   ///< of the nearest voxel; 0 without labels
};

/// One part of the force of a recorded tick.
struct ForcePart {
  std::string name;  ///< "spring", "damping", "smoothing", an effect in words, "passivity controller", ...
  glm::dvec3 force_world{0.0}, torque_world{0.0};  ///< N, N mm
};

/// Pose of a C-arm. Angles in degrees, as in DICOM: primary 0 with the detector in front of the patient,
/// positive toward the left; secondary positive toward the head.
struct XrayPose {
  glm::dvec3 isocentre_world{0.0};  ///< mm
  double primary = 0, secondary = 0;
  double pixel = 0.3;  ///< mm, of the detector
  int columns = 1024, rows = 1024;
};

/// View of a volume rendering.
struct RenderView {
  std::string side = "oblique";   ///< front, back, left, right, top, bottom, oblique
  std::string function = "bone";  ///< transfer function: bone, bone-and-skin, skin, vessels, grey
  int columns = 512, rows = 512;  ///< at most 8192
};
using Colour = std::array<std::uint8_t, 3>;  ///< red, green, blue

struct VoxelRange {
  glm::ivec3 low{0}, high{-1};  ///< both included
};

/// State of an operation at one moment, with its undo history. Snapshots share their data with the operation
/// and with each other, and stay valid after the end of the operation.
class Snapshot {
 public:
  std::uint64_t tick() const noexcept;  ///< number of executed ticks

 private:
  friend class Operation;
  struct Data;
  explicit Snapshot(std::shared_ptr<const Data> data) noexcept : data_(std::move(data)) {}
  std::shared_ptr<const Data> data_;
};

/// Loads a module from a shared library (docs/how-to/add-a-module.md), for operations that are opened
/// afterwards. Call before other threads open operations.
Status load_module(const std::string& path);

/// Owns all that it needs. For one thread at a time; operations share no changing data. Equal input gives
/// equal bits on every machine. A moved-from operation can only be destroyed or assigned to.
class Operation {
 public:
  /// Opens a scan (DICOM folder or any supported file), a case, or a phantom: "head", "spine".
  static Result<Operation> open(const std::string& path, const OperationOptions& options = {});
  /// Opens a scan in memory. The scan stays unchanged.
  static Result<Operation> open(std::shared_ptr<const Volume> scan, const OperationOptions& options = {});
  /// Opens a scene in text (docs/file-formats.md, "A scene in text"), with its volumes and models. The first
  /// volume is the anatomy.
  static Result<Operation> open_scene(std::string_view scene,
                                      std::vector<std::shared_ptr<const Volume>> volumes,
                                      std::vector<Surface> models = {}, const Recording& recording = {});
  /// Opens a recorded operation at its beginning, read-only. `scan`: path of the scan; empty if the file
  /// contains the scan, or if the scan is a built-in phantom.
  static Result<Operation> reopen(const std::string& session, const std::string& scan = {});
  /// Opens a recorded operation with the volumes that the file does not contain, the anatomy first.
  static Result<Operation> reopen(const std::string& session,
                                  std::vector<std::shared_ptr<const Volume>> volumes);
  Operation(Operation&&) noexcept;
  Operation& operator=(Operation&&) noexcept;
  /// Finishes the recording; call end() for its errors.
  ~Operation();

  // ---- only for operations from open() and open_scene() ----
  /// Executes one tick with one pose per hand. The results stay valid until the next step(), run() or
  /// restore(). A tick takes some microseconds, longer while an instrument cuts. A pose that is not finite
  /// gives no force and latches a fault.
  Result<std::span<const Touch>> step(std::span<const Pose> poses);
  /// Executes one tick of an operation with one hand.
  Result<Touch> step(const Pose& pose);
  /// Executes one tick per pose of one hand; one result per tick.
  Result<std::vector<Touch>> run(std::span<const Pose> poses);
  /// Executes a command, and finishes the job that the command starts. Error, of kind `refused`, if the state
  /// does not allow the command or its job fails; such a command adds nothing to the undo history. By struct:
  /// `command(sim::Note{"text"})`; by words: `command("burr", "diameter=3")`.
  Status command(const Command& command);
  Status command(std::string_view name, std::string_view words = {}, int hand = 0);
  /// Undoes a stroke or command; does nothing if there is nothing to undo.
  Status undo();
  Status redo();
  /// Clears faults, contact and force with the next tick.
  Status reset();
  /// Returns the current state, also in the middle of a stroke. Does not change the results of later calls.
  Result<Snapshot> snapshot();
  /// Returns to the state of a snapshot of this operation: equal ticks and commands then give equal bits.
  /// References to events become invalid. Error: a snapshot of another operation, or an operation that is
  /// being recorded, because a recording cannot return to an earlier state.
  Status restore(const Snapshot& snapshot);
  /// Ends the operation and its recording. Returns the first error of the recording. Only queries remain.
  Status end();

  // ---- only for operations from reopen() ----
  /// Goes to the state after `tick` ticks, forward or back; tick_count() and beyond: the end.
  Status go_to(std::uint64_t tick);
  /// Replays the whole session. Error, of kind `different`, at the first difference from the recording; other
  /// errors if the session is damaged or cannot be verified.
  Status verify();
  /// Returns false if the end of the file was lost; the part before the loss is available.
  bool is_whole() const noexcept;

  // ---- state ----
  bool is_recorded() const noexcept;          ///< opened with reopen()
  bool is_read_only() const noexcept;         ///< recorded, or ended
  std::uint64_t tick() const noexcept;        ///< number of executed ticks
  std::uint64_t tick_count() const noexcept;  ///< recorded ticks; tick() if not is_recorded()
  std::size_t hand_count() const noexcept;
  double rate_hz() const noexcept;      ///< ticks per second
  const Volume& scan() const noexcept;  ///< uncut
  std::shared_ptr<const Volume> shared_scan() const noexcept;
  std::vector<std::string> item_names() const;     ///< of the touched structures; Touch::item is the index
  std::vector<PlannedLine> trajectories() const;   ///< of the plan
  std::vector<PlannedPosition> landmarks() const;  ///< of the plan
  std::string scene() const;                       ///< in the format of open_scene()
  double removed_mm3() const;
  std::vector<Measure> measures() const;  ///< "removed", "nearest to dura", ...
  /// Judges the current state by the findings of the modules and the limits of the plan. The score has no
  /// measures of the hands' motion, which `trephine score` adds for a session. May take several seconds.
  Score score();
  /// As score(), with values of the caller. Error if a name is empty or occurs twice, a number is not finite,
  /// or a weight is negative.
  Result<Score> score(const std::vector<MeasuredValue>& judgements);
  std::size_t event_count() const noexcept;              ///< undo removes no events
  const Event& event(std::size_t index) const noexcept;  ///< requires index < event_count()
  std::vector<Body> bodies() const;
  /// Hash of the whole state: equal states have equal hashes. The cost grows with removed matter.
  std::uint64_t hash();

  // ---- voxels, surfaces, images; without detached bodies unless stated ----
  /// Returns the voxels that may have changed since the last call; nullopt if none did.
  std::optional<VoxelRange> take_changed();
  /// Returns the current intensities, x fastest. The intensity of a voxel approaches that of air in
  /// proportion to the removed share of the voxel.
  Result<std::vector<std::int16_t>> read(const VoxelRange& range) const;
  /// Surface of a structure with its cuts. Takes a second per 100 million voxels.
  Result<Surface> surface(std::size_t item = 0) const;
  /// Returns the matter at positions (world, mm). Does not change the state. Cost: about 1 us each.
  std::vector<Sample> query(std::span<const glm::dvec3> positions_world) const;
  /// Returns the parts whose sum is the force of a hand in a recorded tick. Requires an operation from
  /// reopen(), and moves it to the state after this tick. Error if the session has no such tick.
  Result<std::vector<ForcePart>> explain_force(std::uint64_t tick, int hand = 0);
  /// Intensities in a plane, with the cuts; -32768 outside the scan.
  Result<Image<std::int16_t>> slice(const ImagePlane& plane) const;
  /// X-ray of a CT with bodies and models. The greys follow the logarithm of the signal. Further images reuse
  /// unchanged parts.
  Result<Image<std::uint8_t>> xray(const XrayPose& pose);
  /// Volume rendering with the cuts, bodies and models (docs/rendering.md). A scan without Hounsfield units
  /// is always drawn by "grey". Further images reuse unchanged parts.
  Result<Image<Colour>> render(const RenderView& view = {});

 private:
  struct Data;
  explicit Operation(std::unique_ptr<Data> data) noexcept;
  std::unique_ptr<Data> data_;
};

}  // namespace trephine
