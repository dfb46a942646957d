// Operation: a scan, shapes, models, hands and their tools, built from the choices of a user or a script.
#pragma once

#include "apps/workbench/source.h"
#include "data-tools/phantoms/screw_model.h"
#include "haptics/device/device.h"
#include "sim/api/overlay.h"
#include "sim/engine/scene_description.h"

namespace trephine::workbench {

/// A polygonal model to touch.
struct ModelChoice {
  std::string file = {};
  double mm_per_unit = 1;
  std::string frame;         ///< "LPS" or "RAS"; empty: as the file states, or else LPS
  glm::dvec3 at_world{0.0};  ///< mm, position of the model's origin
  volume::Matter matter = volume::Matter::titanium;
  bool is_forbidden = false;  ///< a tool must not enter it
  bool is_touchable = true;   ///< stops the proxy
  std::string name = {};      ///< empty: "model N"; never the name of a file
  std::optional<data_tools::ScrewPosition> screw = std::nullopt;  ///< instead of a file
  /// Touched by depth images. `file` may then also be a depth video, or a folder of models with the same
  /// triangles. The models of a folder, sorted by name, are the key frames (keys) of an animation.
  bool is_depth = false;
  double beat = 1.0 / 30;     ///< s between keys
  bool is_repeating = false;  ///< the first key follows the last
  double pixel = 0.2;         ///< mm, of depth images
  double rate = 100;          ///< Hz, of depth images
  /// Intrinsics of a depth video without them: fx, fy, cx, cy, pixels.
  std::optional<std::array<double, 4>> intrinsics = std::nullopt;
  std::optional<double> mm_per_value = std::nullopt;  ///< for a depth video that does not state it
  /// Touched as the picture that the screen shows of it; all such models form one object.
  bool is_background = false;
};

/// Loads the chosen surface. Does not apply `at_world`. Reports assumptions as notices of model `number`.
Result<std::shared_ptr<const haptics::MeshTree>> load_model(const ModelChoice& choice, std::size_t number,
                                                            const Listener& listener);

/// Returns `base` with the chosen properties replaced.
haptics::Material material_of(const data_tools::CaseMaterial& choice, haptics::Material base);

/// A further scan with a shape to touch, at the position that its file states. It cannot be cut.
struct VolumeChoice {
  std::string path;        ///< of a scan, a case or a built-in phantom
  ShapeChoice shape = {};  ///< empty: a case's touchable structures, or the usual one of such a scan
  std::string name = {};   ///< of its structure; empty: "volume N"; the anatomy is volume 1
  /// Matter that pictures show. Empty: bone for a window of a CT, else soft tissue.
  std::optional<volume::Matter> matter = std::nullopt;
};
/// Parses "300" (from 300 up), "100:400", or the name of a label; an empty text gives an empty choice.
ShapeChoice parse_shape(const std::string& text);

/// A closed model whose surface is the tool of a hand, in the frame of the hand.
struct ToolModelChoice {
  std::size_t hand = 0;
  ModelChoice model;                             ///< only file, unit and frame are used
  std::optional<double> spacing = std::nullopt;  ///< mm, of points on the surface; empty: half a voxel
};

/// Use of the procedure of a plan.
enum class ProcedureUse : std::uint8_t {
  followed,              ///< its first step must allow the instruments of the hands
  begins_without_tools,  ///< followed; hands begin empty, and take instruments in a step that allows them
  ignored                ///< for operations that only run a single command, such as a cut along a path
};

/// Options of an operation, in addition to its scan.
struct OperationChoice {
  ShapeChoice shape;  ///< empty: a case's touchable structures, or bone
  /// At least one hand. A tool radius of 0 is replaced by the radius that the instrument needs.
  std::vector<sim::HandSpec> hands{sim::HandSpec()};
  /// Material of the chosen or first touchable shape, of `volumes`, and of models.
  data_tools::CaseMaterial material;
  std::optional<haptics::StiffnessRamp> ramp;  ///< of the chosen or first touchable shape
  std::vector<VolumeChoice> volumes;           ///< in addition to those of a case
  std::vector<ModelChoice> models;
  std::vector<ToolModelChoice> tools;
  double rate_hz = 1000;
  haptics::ForceOptions force;
  /// Devices that render the forces. Force, torque and stiffness are reduced to their limits.
  std::vector<haptics::DeviceCapabilities> devices;
  /// Smallest diameter of the instruments that will cut, mm; empty: that of the hands' initial instruments.
  std::optional<double> smallest_burr;
  /// Name of a shipped procedure or path of a file. It replaces the procedure of the plan. Empty: the
  /// procedure of the plan is used.
  std::string procedure = {};
  ProcedureUse procedure_use = ProcedureUse::followed;
  bool cuts_by_command = false;  ///< adds forbidden structures even if no hand has an instrument
  double blur_voxels = 0;        ///< sigma of a Gaussian that is applied to the scan first
};

/// An operation that is ready to start.
struct Operation {
  Source source;
  sim::SceneDescription spec;  ///< the built scene, for a session's header
  sim::OperationStart start;
  double build_seconds = 0;  ///< duration of building bits, fields and methods

  /// Scene of the first hand.
  const std::shared_ptr<const haptics::TouchScene>& scene() const { return start.hands[0].touch.scene; }
  /// Proxy method of the first hand.
  const haptics::ProxyMethod& method() const { return *start.hands[0].touch.method; }
  haptics::ServoOptions servo() const;
  sim::Engine engine() const;
};

/// Returns the surgical plan of the case or of the built-in phantom; an empty plan for other sources. A
/// phantom has its plan also without SourceChoice::uses_plan.
volume::SurgicalPlan plan_of(const Source& source);
/// Returns the models of a case.
std::vector<ModelChoice> models_of(const Source& source);
/// Returns the forbidden shapes in the scan of a case, without those of further volumes.
std::vector<volume::Shape> forbidden_of(const data_tools::CasePlan& plan);

/// Checks names, ranges and effects, and that the files of models exist, without loading data. Parses the
/// hands' instruments.
Status check(const OperationChoice& choice);
/// Opens the scan and builds the operation. An error about a choice states the choice as its location: "iso",
/// "smallest burr", "tool radius", "method" ...
Result<Operation> open_operation(const SourceChoice& src, const OperationChoice& choice,
                                 const Listener& listener = {});
Result<Operation> make_operation(Source source, const OperationChoice& choice, const Listener& listener = {});

/// A scan with its touchable items, for programs that neither record nor cut. In a case, these are all
/// touchable structures of its scan. Shapes whose voxels have only two values are smoothed.
struct OpenedTouch {
  Source source;
  haptics::TouchScene scene;
  double build_seconds = 0;  ///< duration of building the items
};
Result<OpenedTouch> open_touch(const SourceChoice& src, const ShapeChoice& choice,
                               const Listener& listener = {});

}  // namespace trephine::workbench
