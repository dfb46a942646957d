#include "haptics/hardware/inverse3_message.h"

#include <cmath>
#include <glm/vector_relational.hpp>
#include <nlohmann/json.hpp>

#include "haptics/device/pose_path.h"

namespace trephine::haptics {

using glm::dvec3;
using Json = nlohmann::json;

namespace {

constexpr double k_mm_per_m = 1000;
constexpr double k_farthest = 10;  // m, largest coordinate of a valid position

// The service's frame: x to the right, y away from the user, z up.
dvec3 from_service(const dvec3& v) { return {v.x, v.z, -v.y}; }
dvec3 to_service(const dvec3& v) { return {v.x, -v.z, v.y}; }

/// Returns a member of an object; null if it is missing.
const Json& member(const Json& object, const char* name) {
  static const Json k_null;
  if (!object.is_object()) return k_null;
  const auto found = object.find(name);
  return found == object.end() ? k_null : *found;
}

/// Returns an element of an array; null if it is missing.
const Json& element(const Json& array, std::size_t index) {
  static const Json k_null;
  return array.is_array() && index < array.size() ? array[index] : k_null;
}

std::optional<double> number(const Json& object, const char* name) {
  const Json& value = member(object, name);
  if (!value.is_number()) return std::nullopt;
  const double result = value.get<double>();
  return std::isfinite(result) ? std::optional(result) : std::nullopt;
}

std::optional<dvec3> vector(const Json& object) {
  const auto x = number(object, "x"), y = number(object, "y"), z = number(object, "z");
  return x && y && z ? std::optional(dvec3(*x, *y, *z)) : std::nullopt;
}

bool is_true(const Json& value) { return value.is_boolean() && value.get<bool>(); }

}  // namespace

std::optional<Inverse3State> parse_inverse3(std::string_view message, std::size_t index) {
  const Json json = Json::parse(message, nullptr, false);
  const Json& device = element(member(json, "inverse3"), index);
  const Json& id = member(device, "device_id");
  const auto position = vector(member(member(device, "state"), "cursor_position"));
  if (!id.is_string() || !position || glm::any(glm::greaterThan(glm::abs(*position), dvec3(k_farthest))))
    return std::nullopt;
  Inverse3State result;
  result.device = id.get<std::string>();
  result.position = k_mm_per_m * from_service(*position);
  const Json& calibrated = member(member(device, "status"), "calibrated");
  result.is_calibrated = !calibrated.is_boolean() || is_true(calibrated);

  const Json* grip = &element(member(json, "wireless_verse_grip"), index);
  if (grip->is_null()) grip = &element(member(json, "verse_grip"), index);
  const Json& state = member(*grip, "state");
  const Json& turn = member(state, "orientation");
  const auto axis = vector(turn);
  const auto w = number(turn, "w");
  if (axis && w) {
    const dvec3 mapped = from_service(*axis);
    result.orientation = unit_of({*w, mapped.x, mapped.y, mapped.z});
  }
  const char* const names[] = {"a", "b", "c"};
  for (std::size_t i = 0; i < 3; ++i)
    if (is_true(member(member(state, "buttons"), names[i]))) result.buttons |= 1u << i;
  if (is_true(member(state, "button"))) result.buttons |= 1;
  return result;
}

std::string inverse3_force(const std::string& device, const dvec3& force) {
  const dvec3 values = to_service(force);
  const Json command{{"values", {{"x", values.x}, {"y", values.y}, {"z", values.z}}}};
  const Json message{
      {"inverse3", Json::array({{{"device_id", device}, {"commands", {{"set_cursor_force", command}}}}})}};
  return message.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace trephine::haptics
