// Operation: a scan, shapes, models, hands and their tools, built from the choices of a user or a script.
#pragma once

#include "apps/workbench/source.h"
#include "data-tools/phantoms/screw_model.h"
#include "sim/api/overlay.h"
#include "sim/engine/scene_description.h"

namespace trephine::workbench {

/// A polygonal model to touch.
struct ModelChoice {
  std::string file = {};
  double mm_per_unit = 1;
  std::string frame;         ///< "LPS" or "RAS"; empty: as the file states
  glm::dvec3 at_world{0.0};  ///< mm, position of its origin
  volume::Matter matter = volume::Matter::titanium;
  bool is_forbidden = false;  ///< a tool must not enter it
  bool is_touchable = true;   ///< stops the proxy
  std::string name = {};      ///< empty: "model N"; never the name of a file
  std::optional<data_tools::ScrewPosition> screw = std::nullopt;  ///< instead of a file
  /// Touched by depth images. `file` may then be a folder of models with the same triangles, sorted by name:
  /// the keys of an animation.
  bool is_depth = false;
  double beat = 1.0 / 30;     ///< s between keys
  bool is_repeating = false;  ///< the first key follows the last
  double pixel = 0.2;         ///< mm, of depth images
  double rate = 100;          ///< Hz, of depth images
  /// Intrinsics of a depth video without them: fx, fy, cx, cy, pixels.
  std::optional<std::array<double, 4>> intrinsics = std::nullopt;
  std::optional<double> mm_per_value = std::nullopt;  ///< for a depth video that does not state it
  /// Touched as its picture on the screen; all such models form one object.
  bool is_background = false;
};

/// Loads the chosen surface, without `at_world`. Reports assumptions as notices of model `number`.
Result<std::shared_ptr<const haptics::MeshTree>> load_model(const ModelChoice& choice, std::size_t number,
                                                            const Listener& listener);

/// Returns `base` with the chosen properties replaced.
haptics::Material material_of(const data_tools::CaseMaterial& choice, haptics::Material base);

/// A further scan with a shape to touch, at the position that its file states. It cannot be cut.
struct VolumeChoice {
  std::string path;        ///< of a scan, a case or a built-in phantom
  ShapeChoice shape = {};  ///< empty: a case's touchable structures, or the usual one of such a scan
  std::string name = {};   ///< of its structure; empty: "volume N"
  std::optional<volume::Matter> matter = std::nullopt;  ///< for images; empty: bone for a window of a CT,
                                                        ///< else soft tissue
};
/// Parses "300" (from 300 up), "100:400", or the name of a label; an empty text gives an empty choice.
ShapeChoice parse_shape(const std::string& text);

/// Use of the procedure of a plan.
enum class ProcedureUse : std::uint8_t {
  followed,              ///< its first step must allow the instruments of the hands
  begins_without_tools,  ///< followed; hands begin empty, and take instruments in a step that allows them
  ignored                ///< for operations of a single command, such as the cut along a path
};

/// Options of an operation, in addition to its scan.
struct OperationChoice {
  ShapeChoice shape;  ///< empty: a case's touchable structures, or bone
  /// At least one. A tool radius of 0 is replaced by that which the instrument needs.
  std::vector<sim::HandSpec> hands{sim::HandSpec()};
  data_tools::CaseMaterial material;  ///< of the chosen shape (for a case, its first) and of models
  std::optional<haptics::StiffnessRamp> ramp;
  std::vector<VolumeChoice> volumes;  ///< in addition to those of a case
  std::vector<ModelChoice> models;
  double rate_hz = 1000;
  haptics::ForceOptions force;
  /// Smallest diameter that will cut, mm; empty: that of the hands' initial instruments.
  std::optional<double> smallest_burr;
  /// Name of a shipped procedure, or a file, instead of that of the plan; empty: that of the plan.
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
  const haptics::ProxyMethod& method() const { return *start.hands[0].touch.method; }
  haptics::ServoOptions servo() const;
  sim::Engine engine() const;
};

/// Returns the surgical plan of a source: that of its case, or of a built-in phantom; else an empty plan.
volume::SurgicalPlan plan_of(const Source& source);
/// Returns the models of a case.
std::vector<ModelChoice> models_of(const Source& source);
/// Returns the forbidden shapes of a case's scan.
std::vector<volume::Shape> forbidden_of(const data_tools::CasePlan& plan);

/// Checks names, ranges and words without loading data. Parses the hands' instruments.
Status check(const OperationChoice& choice);
/// Opens the scan and builds the operation. Errors name the choices above: "iso", "smallest burr", "tool
/// radius", "method" ...
Result<Operation> open_operation(const SourceChoice& src, const OperationChoice& choice,
                                 const Listener& listener = {});
Result<Operation> make_operation(Source source, const OperationChoice& choice, const Listener& listener = {});

/// A scan with its touchable items, for programs that neither record nor cut. A case gives all its touchable
/// structures; shapes of two values are made smooth.
struct OpenedTouch {
  Source source;
  haptics::TouchScene scene;
  double build_seconds = 0;  ///< duration of building the items
};
Result<OpenedTouch> open_touch(const SourceChoice& src, const ShapeChoice& choice,
                               const Listener& listener = {});

}  // namespace trephine::workbench
