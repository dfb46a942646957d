// Command: a request that changes an operation, outside the tick stream. A session is ticks and commands in
// order.
#pragma once

#include "haptics/tool/tool_shape.h"
#include "sim/api/value.h"

namespace trephine::sim {

/// The request is a struct with a table of its fields. It is a command of this file, a command of a module,
/// the parameters of an instrument (the hand receives the instrument), or the parameters of a job (the job
/// starts).
struct Command {
  Command() = default;
  template <HasSchema T>
  Command(T request, std::uint8_t hand_index = 0) : request(std::move(request)), hand(hand_index) {}
  Command(Value request, std::uint8_t hand_index) : request(std::move(request)), hand(hand_index) {}

  Value request;
  std::uint8_t hand = 0;
};

/// Undoes one stroke, or one command that changed the undoable state.
struct Undo {
  static const Schema& schema();
};
struct Redo {
  static const Schema& schema();
};
/// Begins a branch: the history continues under this name. The previous branch keeps its whole history and
/// can be switched to.
struct BeginBranch {
  std::string name;
  static const Schema& schema();
};
/// Switches to another branch, at the entry where it was left.
struct SwitchBranch {
  std::string name;
  static const Schema& schema();
};
/// A remark; changes no state.
struct Note {
  std::string text;
  static const Schema& schema();
};
/// Begins a step of the procedure, if a transition on request leads there and its conditions are met.
struct GoToStep {
  std::string step;
  static const Schema& schema();
};
/// Continues a session: strokes end, bodies are released, and every proxy and force starts again.
struct Resume {
  static const Schema& schema();
};
/// Data that are derived from the state in the background, while the operation goes on.
enum class DerivedKind : std::uint8_t {
  offset_fields,  ///< of a round tool, after cuts
  depth_images,   ///< of an item that is drawn
  depth_picture,  ///< of an item whose pictures are submitted by the caller
  loose_parts     ///< search for disconnected parts; FreePieces detaches them
};
inline constexpr std::size_t k_derived_kinds = 4;
/// Adopts derived data. Issued by drivers many times a second, not by a user; never refused by modules.
struct Adopt {
  DerivedKind kind = DerivedKind::offset_fields;
  std::int64_t item = 0;    ///< index of an item of the hand's scene; 0 for offset fields
  std::int64_t serial = 0;  ///< offset fields: of the version; depth images and pictures: of the set
  /// Data in addition to the state, as bytes of their fields: DepthImages, DepthPixels, or empty.
  std::string input = {};
  std::int64_t hash = 0;  ///< of the derived data; 0: not compared
  static const Schema& schema();
};
/// Removes the hand's instrument. Afterwards the hand only touches.
struct RemoveInstrument {
  static const Schema& schema();
};
/// Makes an item (by index) touchable for the hand, or lets the hand pass through it.
struct SwitchItem {
  std::int64_t item = 0;
  bool is_touchable = true;
  static const Schema& schema();
};
/// Returns an error, which names `field`, unless the rotation is a unit quaternion, w first.
Status check_rotation(const std::vector<double>& rotation, const char* field);
/// Sets the pose of a moving model, for all hands.
struct PlaceModel {
  std::int64_t mover = 0;
  glm::dvec3 position{0.0};                  ///< mm, world
  std::vector<double> rotation{1, 0, 0, 0};  ///< a unit quaternion, w first
  static const Schema& schema();
};
/// Sets a force of the hand in addition to those of surfaces. The state of the effect persists while the hand
/// has an effect of this kind with this id.
struct SetEffect {
  Id effect;
  std::string words;  ///< as haptics::parse_effect reads them; empty: ends the force
  static const Schema& schema();
};
/// A job: makes the hand's tool a ball of this radius, a point, a rigid chain of such balls, or the surface
/// of a body of revolution.
struct ToolGeometry {
  double radius = 0;                   ///< mm; 0: a point
  std::vector<glm::dvec3> balls = {};  ///< centres, mm, frame of the hand; empty: one ball or a point
  /// Position along the axis and radius (mm) of each ring of the body; empty: no body.
  std::vector<double> profile = {};
  double spacing = 0;  ///< mm, of the points on the body
  static const Schema& schema();
  static ToolGeometry of(const haptics::ToolShape& tool);
  /// Returns the tool. Error if the balls or the profile form no valid tool. The surface of a body of
  /// revolution has no points: the job computes them.
  Result<haptics::SharedTool> tool() const;
};
/// A job: gives the hand an instrument, and the contact geometry that the instrument needs. Until the
/// geometry is ready, the hand keeps its current instrument. If the instrument needs no geometry, the hand
/// gets its initial geometry.
struct TakeInstrument {
  std::string instrument;  ///< its name
  std::string parameters;  ///< in words: "diameter=4 removal_rate=30"
  static const Schema& schema();
};
/// A job: detaches the parts of a cut shape that are no longer connected to the rest. Parts of at least
/// `smallest` become bodies; smaller ones are debris.
struct FreePieces {
  std::int64_t item = 0;  ///< index of a shape of the anatomy
  double smallest = 10;   ///< mm3, least volume of a body
  static const Schema& schema();
};
/// The hand grasps a body, which then moves with it.
struct HoldBody {
  Id body;
  static const Schema& schema();
};
/// The hand releases its body, which stays where it is.
struct ReleaseBody {
  static const Schema& schema();
};
/// Sets the pose of a released body. The defaults are the identity: the pose of a part at its detachment.
struct PlaceBody {
  Id body;
  glm::dvec3 position{0.0};                  ///< mm, world: origin of the frame of the body's piece
  std::vector<double> rotation{1, 0, 0, 0};  ///< a unit quaternion, w first
  static const Schema& schema();
};
/// Removes a body.
struct DiscardBody {
  Id body;
  static const Schema& schema();
};
/// Adopts the result of a job, if it is still valid.
struct AdoptJob {
  Id job;
  std::int64_t hash = 0;  ///< of the result: the bits of an unsigned number
  static const Schema& schema();
};
struct CancelJob {
  Id job;
  static const Schema& schema();
};

}  // namespace trephine::sim
