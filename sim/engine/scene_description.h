// SceneDescription: the start of an operation as a plain value, which is also the header of a session.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "haptics/depth/depth_stream.h"
#include "haptics/methods/methods.h"
#include "haptics/servo/servo_loop.h"
#include "sim/engine/engine.h"
#include "volume/scan/surgical_plan.h"

namespace trephine::sim {

struct VolumeSpec {
  glm::ivec3 size{0};
  std::optional<std::uint64_t> hash = std::nullopt;  ///< of its voxels; empty if not known yet
};

struct ModelSpec {
  std::uint64_t triangles = 0, hash = 0;
};

/// A depth stream.
struct StreamSpec {
  std::uint64_t pictures = 0, hash = 0;
};

/// A shape of a volume, or a model. Touchable structures of the anatomy are first in the list; structures of
/// one volume are adjacent.
struct StructureSpec {
  bool is_touchable = true;
  bool is_forbidden = false;  ///< a shape, or a closed model at rest, that must not be entered
  int volume = 0;             ///< 0: the anatomy, which alone can be cut
  int model = -1;             ///< index of the model; -1: a shape of a volume
  volume::Shape shape;
  haptics::Material material;
  haptics::Side sides = haptics::Side::front;
  std::optional<haptics::StiffnessRamp> ramp = std::nullopt;
  bool is_soft = false;  ///< touched by a soft field
  std::optional<haptics::Material> back_material = std::nullopt;
  haptics::Placement placement = {};                 ///< pose of a model
  volume::Matter matter = volume::Matter::titanium;  ///< of a model or a shape of a further volume
  int mover = -1;                                    ///< number of a moving model; -1: at rest
  /// Number of models, from `model` on, that are the keys of an animation touched by depth images; 0: no
  /// animation.
  int depth_keys = 0;
  double depth_beat = 1.0 / 30;  ///< s between keys
  bool is_repeating = false;     ///< the first key follows the last
  double depth_pixel = 0.2;      ///< mm
  double depth_rate = 100;       ///< Hz
  /// Index of a depth stream; -1: no stream. `placement` is the pose of its camera, and `model` its first
  /// surface.
  int stream = -1;
  /// Touched by depth pictures that the caller submits; `model` is the surface that views draw.
  bool is_streamed = false;
};

struct HandSpec {
  std::string instrument;  ///< empty: the hand only touches
  std::string parameters;  ///< in words: "diameter=4 removal_rate=30"
  haptics::SharedTool tool = std::make_shared<const haptics::ToolShape>();  ///< never null
  /// Index of the model whose surface touches, instead of `tool`; -1: none. Its coordinates are in the frame
  /// of the hand.
  int tool_model = -1;
  double tool_spacing = 0.5;  ///< mm, of the points on that surface
  std::string method = haptics::k_default_method;
  std::vector<std::string> effects;  ///< as haptics::parse_effect reads them

  HandSpec() = default;
  explicit HandSpec(const Instrument& initial)
      : instrument(initial.name()), parameters(initial.type ? initial.parameters.words() : std::string()) {}
};

struct SceneDescription {
  std::vector<VolumeSpec> volumes;  ///< the anatomy first
  std::vector<ModelSpec> models;
  std::vector<StreamSpec> streams;
  std::vector<StructureSpec> structures;
  std::vector<HandSpec> hands;
  volume::SurgicalPlan plan;
  double rate_hz = 1000;
  haptics::ForceOptions force;
  double smallest_burr = 0;  ///< mm, diameter for which cuts are sampled; 0: as coarse as the voxels
  /// Requests smoothing of all shapes with two values near their surface, instead of the shapes with
  /// StructureSpec::is_soft. Not stored in sessions: their structures have the resulting is_soft.
  bool smooths_all_shapes = false;
};

/// Loaded data of a SceneDescription.
struct SceneData {
  std::vector<std::shared_ptr<const volume::Volume>> volumes;
  std::vector<std::shared_ptr<const haptics::MeshTree>> models;
  std::vector<std::shared_ptr<const haptics::depth::DepthStream>> streams = {};

  SceneData() = default;
  SceneData(std::shared_ptr<const volume::Volume> anatomy) : volumes{std::move(anatomy)} {}
};

/// Input of an engine's constructor.
struct OperationStart {
  std::vector<HandStart> hands;
  std::vector<std::shared_ptr<const Forbidden>> forbidden;
  std::shared_ptr<const volume::SurgicalPlan> plan = nullptr;  ///< null: nothing is planned
};
/// Builds all that a servo needs: bits, smooth fields, offset fields and prepared methods. Error if the data
/// does not match the spec, the plan's procedure or an instrument is invalid, or a hand's method cannot touch
/// such a scene.
Result<OperationStart> build_scene(const SceneDescription& spec, const SceneData& data,
                                   const Catalogue& catalogue);
/// Returns the hand's instrument with its parameters; without a type if the hand only touches. Error if the
/// instrument is unknown, or its parameters are out of range.
Result<Instrument> instrument_of(const HandSpec& hand, const Catalogue& catalogue);
/// Reduces the limits of force and the stiffness of all structures to those of the devices that render them.
void apply_device_limits(SceneDescription& spec, std::span<const haptics::DeviceCapabilities> devices);
/// Sets the tools, methods and smallest burr that the hands' instruments need. `smallest_burr`: requested
/// diameter, mm. Errors refer to "smallest burr" or "burr diameter".
Status apply_tool_needs(SceneDescription& spec, const volume::Volume& anatomy, const Catalogue& catalogue,
                        std::optional<double> smallest_burr);
/// True if the method of some hand touches smooth solids only, with a point or a ball.
bool touches_smooth(const SceneDescription& spec) noexcept;
/// Builds the items alone, as a point touches them: no tool, no cuts.
Result<haptics::TouchScene> build_items(const SceneDescription& spec, const SceneData& data);
/// Returns the effects as laws; null without effects. Requires valid effects.
std::shared_ptr<const haptics::LawSet> laws_of(const std::vector<std::string>& effects);

/// Builds the forbidden structures of a spec.
Result<std::vector<std::shared_ptr<const Forbidden>>> build_forbidden(const SceneDescription& spec,
                                                                      const SceneData& data);
/// Describes a running scene whose hands all have the same tool and method. `hands`: instruments and effects
/// of the hands; this function sets their method and tool.
SceneDescription describe_scene(const haptics::TouchScene& scene, const haptics::ProxyMethod& method,
                                const haptics::ServoOptions& options, std::vector<HandSpec> hands);
/// Describes a scene whose hands may have different tools and methods.
SceneDescription describe_scene(std::span<const HandStart> hands, const haptics::ServoOptions& options);
/// Describes the scene `start` that was built from `request`, with its plan and forbidden structures.
SceneDescription describe_built_scene(const SceneDescription& request, const OperationStart& start);
/// Returns the volumes, models and streams of a scene, with the model of its tool.
SceneData data_of(const haptics::TouchScene& scene);
/// Returns those of hands in one scene, with the models of their tools.
SceneData data_of(std::span<const HandStart> hands);

/// Converts to lines of key=value, as in a session's header, and back. If the text has no lines for volumes,
/// models or streams, those of the data are used. An error of one line names its number.
std::string to_text(const SceneDescription& spec);
Result<SceneDescription> scene_from_text(std::string_view text, const SceneData& data);

/// Hash of a tree's vertices and triangles.
std::uint64_t content_hash(const haptics::MeshTree& tree) noexcept;

}  // namespace trephine::sim
