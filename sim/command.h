// A request that changes an operation, outside the tick stream. A session is ticks and commands in order.
#pragma once

#include "sim/value.h"

namespace trephine::sim {

/// A request is a struct with a table: one of those below, the parameters of an instrument (the hand has
/// that instrument from here on), the parameters of a job (it begins), or a command of a module.
struct Command {
  Command() = default;
  template <HasSchema T>
  Command(T request, std::uint8_t of_hand = 0) : what(std::move(request)), hand(of_hand) {}
  Command(Value request, std::uint8_t of_hand) : what(std::move(request)), hand(of_hand) {}

  Value what;
  std::uint8_t hand = 0;
};

/// Back by one stroke, or by one command that changed the world.
struct Undo {
  static const Schema& schema();
};
struct Redo {
  static const Schema& schema();
};
/// Try it again from here: the history goes on by this name from now on. What it was called keeps all that it
/// had, to be gone back to.
struct BeginBranch {
  std::string name;
  static const Schema& schema();
};
/// To where another branch was left.
struct SwitchBranch {
  std::string name;
  static const Schema& schema();
};
/// A remark; changes nothing.
struct Note {
  std::string text;
  static const Schema& schema();
};
/// A session goes on: strokes end, every proxy and force starts afresh.
struct Resume {
  static const Schema& schema();
};
/// Adopts offset fields made of what was left when `serial` was published.
struct AdoptFields {
  std::int64_t serial = 0;
  static const Schema& schema();
};
/// Adopts another set of depth images for an item: it was drawn so.
struct AdoptDepths {
  std::int64_t item = 0, serial = 0;
  glm::dvec3 middle{0.0}, touch{0.0};  ///< mm, of the item's frame, as haptics::depth::DepthView has them
  double edge = 0, time = 0;           ///< mm; s
  std::int64_t hash = 0;               ///< of what came of it
  static const Schema& schema();
};
/// Adopts a picture of an item whose pictures are submitted.
struct AdoptPicture {
  std::int64_t item = 0, serial = 0;
  glm::dvec3 touch{0.0};                     ///< mm, of the item's frame: middle of the clip volume
  double edge = 0, time = 0;                 ///< mm; s
  std::int64_t width = 0, height = 0;        ///< pixels
  double fx = 0, fy = 0, cx = 0, cy = 0;     ///< as haptics::depth::DepthPicture has them
  glm::dvec3 position{0.0};                  ///< mm, of the camera in the item's frame
  std::vector<double> rotation{1, 0, 0, 0};  ///< a unit quaternion, w first
  double nearest = 1, step = 0.1;            ///< mm
  std::string values;
  std::int64_t hash = 0;  ///< of what came of it
  static const Schema& schema();
};
/// The hand lays its instrument down, and only touches.
struct LayDown {
  static const Schema& schema();
};
/// An item that the hand touches (by its index) may hold it, or lets it through.
struct SwitchItem {
  std::int64_t item = 0;
  bool is_touchable = true;
  static const Schema& schema();
};
/// Is it a unit quaternion, w first? The error names the field.
volume::Status check_rotation(const std::vector<double>& rotation, const char* field);
/// A moving model is here from now on, for all hands.
struct PlaceModel {
  std::int64_t mover = 0;
  glm::dvec3 position{0.0};                  ///< mm, world
  std::vector<double> rotation{1, 0, 0, 0};  ///< a unit quaternion, w first
  static const Schema& schema();
};
/// A force in addition to those of surfaces, for the hand; its memory stays while its id does.
struct SetEffect {
  Id effect;
  std::string words;  ///< as haptics::parse_effect reads them; empty: it ends
  static const Schema& schema();
};
/// A job: the hand's tool becomes a ball of this radius, or a point, or a rigid chain of such balls.
struct ToolGeometry {
  double radius = 0;                   ///< mm
  std::vector<glm::dvec3> balls = {};  ///< mm, their middles, seen from the hand
  static const Schema& schema();
};
/// A job: parts of a shape that was cut, and that hang together with nothing any more, come off: bodies from
/// `smallest` on, debris below.
struct FreePieces {
  std::int64_t item = 0;  ///< of the base
  double smallest = 10;   ///< mm3
  static const Schema& schema();
};
/// The hand takes a body, which goes with it from then on.
struct HoldBody {
  Id body;
  static const Schema& schema();
};
/// It lets go of what it holds, which stays where it is.
struct ReleaseBody {
  static const Schema& schema();
};
/// A body that lies is elsewhere from now on; as it stands here: where it came off.
struct PlaceBody {
  Id body;
  glm::dvec3 position{0.0};                  ///< mm, world, of the frame in which it was freed
  std::vector<double> rotation{1, 0, 0, 0};  ///< a unit quaternion, w first
  static const Schema& schema();
};
/// A body is taken away for good.
struct DiscardBody {
  Id body;
  static const Schema& schema();
};
/// Adopts the result of a job, if it still fits; `hash` is that of the result.
struct AdoptJob {
  Id job;
  std::int64_t hash = 0;  ///< the bits of an unsigned one
  static const Schema& schema();
};
struct CancelJob {
  Id job;
  static const Schema& schema();
};

/// Is it issued by the engine to adopt derived data, many times a second, and not by a user?
bool keeps_books(const Value& what) noexcept;

}  // namespace trephine::sim
