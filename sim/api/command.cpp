#include "sim/api/command.h"

#include <cmath>

#include "haptics/scene/shape_set.h"
#include "haptics/scene/touch_scene.h"
#include "volume/base/text.h"

namespace trephine::sim {

const Schema& Undo::schema() {
  static constexpr Schema table{"undo"};
  return table;
}
const Schema& Redo::schema() {
  static constexpr Schema table{"redo"};
  return table;
}
const Schema& BeginBranch::schema() {
  static constexpr Field fields[] = {field<&BeginBranch::name>("name", {.label = "Name of the new branch"})};
  static constexpr Schema table{"begin-branch", 1, fields};
  return table;
}
const Schema& SwitchBranch::schema() {
  static constexpr Field fields[] = {
      field<&SwitchBranch::name>("name", {.label = "Branch", .names = FieldInfo::Names::branch})};
  static constexpr Schema table{"switch-branch", 1, fields};
  return table;
}
const Schema& Note::schema() {
  static constexpr Field fields[] = {field<&Note::text>("text")};
  static constexpr Schema table{"note", 1, fields};
  return table;
}
const Schema& GoToStep::schema() {
  static constexpr Field fields[] = {field<&GoToStep::step>("step", {.help = "name of the next step"})};
  static constexpr Schema table{"go-to-step", 1, fields};
  return table;
}
const Schema& Resume::schema() {
  static constexpr Schema table{"resume"};
  return table;
}
const Schema& Adopt::schema() {
  static constexpr std::string_view kinds[] = {"offset-fields", "depth-images", "depth-picture"};
  static constexpr Field fields[] = {
      field<&Adopt::kind>("kind", {.choices = kinds}),
      field<&Adopt::item>("item", {.low = 0, .high = haptics::ShapeSet::k_max - 1}),
      field<&Adopt::serial>("serial", {.low = 0, .high = 0x1p53}), field<&Adopt::input>("input"),
      field<&Adopt::hash>("hash")};
  static constexpr Schema table{"adopt", 1, fields};
  return table;
}
const Schema& RemoveInstrument::schema() {
  static constexpr Schema table{"remove-instrument"};
  return table;
}
const Schema& SwitchItem::schema() {
  static constexpr Field fields[] = {
      field<&SwitchItem::item>("item", {.low = 0, .high = haptics::ShapeSet::k_max - 1}),
      field<&SwitchItem::is_touchable>("touchable")};
  static constexpr Schema table{"switch-item", 1, fields};
  return table;
}
Status check_rotation(const std::vector<double>& q, const char* field) {
  double length_squared = 0;
  for (const double component : q) length_squared += component * component;
  if (q.size() == 4 && std::abs(length_squared - 1) < 1e-6) return std::nullopt;
  const std::string found = std::to_string(q.size()) + " numbers" +
                            (q.size() == 4 ? " with norm " + rounded_text(std::sqrt(length_squared)) : "");
  return Error{.what = "the rotation is not a unit quaternion",
               .where = field,
               .found = found,
               .expected = "w, x, y, z with norm 1",
               .remedy = q.size() == 4 && length_squared > 0 ? "divide each number by the norm"
                                                             : "pass w, x, y and z of a unit quaternion"};
}
const Schema& PlaceModel::schema() {
  static constexpr Field fields[] = {
      field<&PlaceModel::mover>("mover", {.low = 0, .high = haptics::TouchScene::k_max_movers - 1}),
      field<&PlaceModel::position>("position", {.unit = "mm", .low = -1e6, .high = 1e6}),
      field<&PlaceModel::rotation>("rotation", {.low = -1, .high = 1})};
  static constexpr Schema table{"place-model", 1, fields};
  return table;
}
const Schema& SetEffect::schema() {
  static constexpr Field fields[] = {field<&SetEffect::effect>("effect"), field<&SetEffect::words>("words")};
  static constexpr Schema table{"set-effect", 1, fields};
  return table;
}
const Schema& ToolGeometry::schema() {
  static constexpr Field fields[] = {
      field<&ToolGeometry::radius>("radius", {.unit = "mm", .low = 0, .high = 6}),
      field<&ToolGeometry::balls>("balls", {.unit = "mm", .low = -300, .high = 300}),
      field<&ToolGeometry::profile>("profile", {.unit = "mm", .low = -300, .high = 300}),
      field<&ToolGeometry::spacing>("spacing", {.unit = "mm", .low = 0, .high = 10})};
  static constexpr Schema table{"tool-geometry", 1, fields};
  return table;
}
ToolGeometry ToolGeometry::of(const haptics::ToolShape& tool) {
  ToolGeometry result{tool.radius(), tool.centres(), {}, 0};
  for (const haptics::ToolProfile::Ring& ring : tool.profile().rings)
    result.profile.insert(result.profile.end(), {ring.along, ring.radius});
  if (!result.profile.empty()) result.spacing = tool.profile().spacing;
  return result;
}
Result<haptics::SharedTool> ToolGeometry::tool() const {
  if (profile.empty()) return haptics::make_tool(radius, balls);
  if (radius != 0 || !balls.empty() || profile.size() % 2 != 0)
    return Error{.what = "the geometry of the tool is ambiguous",
                 .where = "tool-geometry profile",
                 .found = profile.size() % 2 != 0 ? "an odd number of values"
                                                  : "a radius or balls in addition to a profile",
                 .expected = "a profile of pairs of position and radius, without the fields radius and balls",
                 .remedy = "pass either radius and balls, or a profile"};
  haptics::ToolProfile result;
  for (std::size_t i = 0; i + 1 < profile.size(); i += 2)
    result.rings.push_back({profile[i], profile[i + 1]});
  result.spacing = spacing;
  auto tool = std::make_shared<const haptics::ToolShape>(std::move(result));
  if (Status error = haptics::check(*tool)) return *error;
  return haptics::SharedTool(std::move(tool));
}
const Schema& TakeInstrument::schema() {
  static constexpr Field fields[] = {field<&TakeInstrument::instrument>("instrument"),
                                     field<&TakeInstrument::parameters>("parameters")};
  static constexpr Schema table{"take-instrument", 1, fields};
  return table;
}
const Schema& FreePieces::schema() {
  static constexpr Field fields[] = {
      field<&FreePieces::item>("item", {.low = 0, .high = haptics::ShapeSet::k_max - 1}),
      field<&FreePieces::smallest>("smallest", {.unit = "mm3", .low = 0, .high = 1e9})};
  static constexpr Schema table{"free-pieces", 1, fields};
  return table;
}
const Schema& HoldBody::schema() {
  static constexpr Field fields[] = {field<&HoldBody::body>("body")};
  static constexpr Schema table{"hold-body", 1, fields};
  return table;
}
const Schema& ReleaseBody::schema() {
  static constexpr Schema table{"release-body"};
  return table;
}
const Schema& PlaceBody::schema() {
  static constexpr Field fields[] = {
      field<&PlaceBody::body>("body"),
      field<&PlaceBody::position>("position", {.unit = "mm", .low = -1e6, .high = 1e6}),
      field<&PlaceBody::rotation>("rotation", {.low = -1, .high = 1})};
  static constexpr Schema table{"place-body", 1, fields};
  return table;
}
const Schema& DiscardBody::schema() {
  static constexpr Field fields[] = {field<&DiscardBody::body>("body")};
  static constexpr Schema table{"discard-body", 1, fields};
  return table;
}
const Schema& AdoptJob::schema() {
  static constexpr Field fields[] = {field<&AdoptJob::job>("job"), field<&AdoptJob::hash>("hash")};
  static constexpr Schema table{"adopt-job", 1, fields};
  return table;
}
const Schema& CancelJob::schema() {
  static constexpr Field fields[] = {field<&CancelJob::job>("job")};
  static constexpr Schema table{"cancel-job", 1, fields};
  return table;
}

}  // namespace trephine::sim
