// Start of an operation, as a plain value: a session's header is one.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "haptics/depth/depth_stream.h"
#include "haptics/proxy/methods.h"
#include "haptics/servo/servo_loop.h"
#include "sim/engine.h"

namespace trephine::sim {

struct VolumeSpec {
  glm::ivec3 size{0};
  std::optional<std::uint64_t> hash = std::nullopt;  ///< of its voxels; nothing when it is not known yet
};

struct ModelSpec {
  std::uint64_t triangles = 0, hash = 0;
};

/// A depth stream.
struct StreamSpec {
  std::uint64_t pictures = 0, hash = 0;
};

/// Something in the scene: a shape of a volume, or a model. Of those that can be touched the anatomy's come
/// first, those of one volume together.
struct StructureSpec {
  bool is_touchable = true;
  bool is_forbidden = false;  ///< a shape that must not be cut
  int volume = 0;             ///< 0: the anatomy, which alone is cut
  int model = -1;             ///< then it is this model, and no volume's
  volume::Shape shape;
  haptics::Material material;
  haptics::Side sides = haptics::Side::front;
  std::optional<haptics::StiffnessRamp> ramp = std::nullopt;
  bool is_soft = false;  ///< its field was made smooth
  std::optional<haptics::Material> back_material = std::nullopt;
  haptics::Placement placement = {};  ///< of a model
  int mover = -1;                     ///< a model that is placed midway by this number
  /// A model that is touched by depth images: so many models, from `model` on, are its shapes a beat
  /// after another; 0: it is touched by its triangles.
  int depth_keys = 0;
  double depth_beat = 1.0 / 30;  ///< s
  bool is_repeating = false;     ///< after the last comes the first
  double depth_pixel = 0.2;      ///< mm
  double depth_rate = 100;       ///< Hz
  /// Then it is this depth stream, placed as its camera; `model` is what it looked like at first.
  int stream = -1;
  /// It is touched by submitted pictures; `model` is what is drawn of it.
  bool comes_in = false;
};

struct HandSpec {
  std::string instrument;              ///< empty: it only touches
  std::string parameters;              ///< in words: "diameter=4 removal_rate=30"
  double tool_radius = 0;              ///< mm; 0: a point
  std::vector<glm::dvec3> tool_balls;  ///< of a rigid tool of several, as haptics::TouchScene has them
  std::string method = haptics::k_default_method;
  std::vector<std::string> effects;  ///< as haptics::parse_effect reads them

  HandSpec() = default;
  explicit HandSpec(const Instrument& begins)
      : instrument(begins.name()), parameters(begins.type ? begins.parameters.words() : std::string()) {}
};

struct SceneSpec {
  std::vector<VolumeSpec> volumes;  ///< the anatomy first
  std::vector<ModelSpec> models;
  std::vector<StreamSpec> streams;
  std::vector<StructureSpec> structures;
  std::vector<HandSpec> hands;
  double rate_hz = 1000;
  haptics::ForceOptions force;
  double smallest_burr = 0;  ///< mm, for which cuts are sampled; 0: on the voxels
  /// Shapes of two values are made smooth, whatever StructureSpec::is_soft says. A request, which no session
  /// keeps: it says of each which it was.
  bool is_softening = false;
};

/// Loaded data that a spec names.
struct SceneData {
  std::vector<std::shared_ptr<const volume::Volume>> volumes;
  std::vector<std::shared_ptr<const haptics::MeshTree>> models;
  std::vector<std::shared_ptr<const haptics::depth::DepthStream>> streams = {};

  SceneData() = default;
  SceneData(std::shared_ptr<const volume::Volume> anatomy) : volumes{std::move(anatomy)} {}
};

/// Start of an engine.
struct OperationStart {
  std::vector<HandStart> hands;
  std::vector<std::shared_ptr<const Forbidden>> forbidden;
};
/// The one place that turns a spec into what a servo runs on: bits, smooth fields, offset fields, methods
/// made ready. Error when the data is not the spec's, or a hand's method cannot touch such a scene.
volume::Result<OperationStart> build_scene(const SceneSpec& spec, const SceneData& data,
                                           const Catalogue& catalogue);
/// The hand's instrument with its parameters; one without a type when it has none. Error when there is no
/// such instrument, or its parameters are out of their ranges.
volume::Result<Instrument> instrument_of(const HandSpec& hand, const Catalogue& catalogue);
/// Fills in what the hands' instruments need: the ball that they touch with, and how finely is cut.
/// `smallest_burr`: mm, what was said. Errors speak of "smallest burr" and "burr diameter".
volume::Status meet_needs(SceneSpec& spec, const volume::Volume& anatomy, const Catalogue& catalogue,
                          std::optional<double> smallest_burr);
/// Does some hand's method touch smooth solids only?
bool touches_smooth(const SceneSpec& spec) noexcept;
/// Its items alone, as a point touches them: no tool, no cuts.
volume::Result<haptics::TouchScene> build_items(const SceneSpec& spec, const SceneData& data);
/// The effects as laws; null without effects. Each is in the range of effects.
std::shared_ptr<const haptics::LawSet> laws_of(const std::vector<std::string>& effects);

/// The forbidden structures of a spec.
volume::Result<std::vector<std::shared_ptr<const Forbidden>>> build_forbidden(const SceneSpec& spec,
                                                                              const SceneData& data);
/// The other way: what a running scene is. Hands share their items but for the tool. `hands`: their
/// instruments and effects; method and radius are filled in.
SceneSpec describe_scene(const haptics::TouchScene& scene, const haptics::ProxyMethod& method,
                         const haptics::ServoOptions& options, std::vector<HandSpec> hands);
/// For hands of several tools.
SceneSpec describe_scene(std::span<const HandStart> hands, const haptics::ServoOptions& options);
/// Scene made of a spec, with its forbidden structures.
SceneSpec as_made(const SceneSpec& asked, const OperationStart& start);
/// Its volumes and models.
SceneData data_of(const haptics::TouchScene& scene);

/// Lines of key=value, as in a session's header, and back. Volumes and models that the text does not name are
/// those of the data. Error with the line.
std::string to_text(const SceneSpec& spec);
volume::Result<SceneSpec> scene_from_text(std::string_view text, const SceneData& data);

/// Hash of a tree's contents.
std::uint64_t content_hash(const haptics::MeshTree& tree) noexcept;

}  // namespace trephine::sim
