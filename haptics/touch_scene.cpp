#include "haptics/touch_scene.h"

#include <cmath>
#include <string>

namespace trephine::haptics {

using volume::Error;

volume::Status check_material(const Material& m) {
  const auto wrong = [](const char* what, double found, const char* expected) {
    return Error{what, "material", std::to_string(found), expected, ""};
  };
  if (!(m.stiffness > 0 && m.stiffness <= 100))
    return wrong("the stiffness is out of range", m.stiffness, "above 0, at most 100 N/mm");
  if (!(m.damping >= 0 && m.damping <= 1))
    return wrong("the damping is out of range", m.damping, "0 to 1 N s/mm");
  if (!(m.static_friction >= 0 && m.static_friction <= 2))
    return wrong("the static friction is out of range", m.static_friction, "a coefficient of 0 to 2");
  if (!(m.dynamic_friction >= 0 && m.dynamic_friction <= m.static_friction))
    return wrong("the dynamic friction is out of range", m.dynamic_friction,
                 "a coefficient of 0 to the static one");
  return std::nullopt;
}

namespace {
template <class Touchable>
const Material& material_on(const Touchable& touchable, int side) noexcept {
  return side < 0 && touchable.back_material ? *touchable.back_material : touchable.material;
}
}  // namespace

const Material& material_of(const TouchScene& scene, int shape, int side) noexcept {
  const auto s = static_cast<std::size_t>(shape);
  if (s < scene.shapes.size()) return material_on(scene.shapes[s], side);
  return material_on(scene.meshes[s - scene.shapes.size()], side);
}

const std::string& name_of(const TouchScene& scene, int shape) noexcept {
  const auto s = static_cast<std::size_t>(shape);
  return s < scene.shapes.size() ? scene.shapes[s].field.shape().name
                                 : scene.meshes[s - scene.shapes.size()].name;
}

volume::Status set_tool_radius(TouchScene& scene, double radius, int threads) {
  if (radius == 0) {
    scene.tool_radius = 0;
    for (TouchShape& shape : scene.shapes) shape.offset = nullptr;
    return std::nullopt;
  }
  if (!(radius > 0 && radius <= 6))
    return Error{"the tool's radius is out of range", "radius", std::to_string(radius) + " mm", "0 to 6 mm",
                 ""};
  for (const TouchShape& shape : scene.shapes)
    if (holds(shape.sides, Sides::back))
      return Error{"a tool with a radius cannot be held from within", shape.field.shape().name,
                   "its back is touchable", "shapes touched from the front",
                   "use a point, or touch the front alone"};
  for (TouchShape& shape : scene.shapes) {
    auto made = volume::OffsetField::build(shape.field, *shape.bits, nullptr, radius, threads);
    if (!made) return made.error();
    shape.offset = std::move(made).value();
  }
  scene.tool_radius = radius;
  return std::nullopt;
}

volume::Result<volume::Shape> window_of_opacity(std::span<const double> intensities,
                                                std::span<const double> opacities, double threshold) {
  const auto wrong = [](const char* what, double found, const char* expected) {
    return Error{what, "opacity ramp", std::to_string(found), expected, ""};
  };
  if (!(threshold >= 0 && threshold < 1))
    return wrong("the threshold is out of range", threshold, "0 or more, below 1");
  for (std::size_t i = 0; i < intensities.size(); ++i) {
    if (!std::isfinite(intensities[i]) || !(opacities[i] >= 0 && opacities[i] <= 1))
      return wrong("a point is out of range", opacities[i], "finite intensities, opacities of 0 to 1");
    if (i > 0 && !(intensities[i] > intensities[i - 1]))
      return wrong("the intensities do not rise", intensities[i], "strictly rising intensities");
  }
  // The stretch above the threshold; beyond the ends the function goes on as it ends.
  volume::Shape window;
  window.low = window.high = 0;
  int stretches = 0;
  bool is_above = false;
  const auto crossing = [&](std::size_t i) {
    const double share = (threshold - opacities[i - 1]) / (opacities[i] - opacities[i - 1]);
    return intensities[i - 1] + share * (intensities[i] - intensities[i - 1]);
  };
  for (std::size_t i = 0; i < intensities.size(); ++i) {
    const bool is_now = opacities[i] > threshold;
    if (is_now && !is_above) {
      ++stretches;
      window.low = i == 0 ? -std::numeric_limits<double>::infinity() : crossing(i);
    }
    if (!is_now && is_above) window.high = crossing(i);
    is_above = is_now;
  }
  if (is_above) window.high = std::numeric_limits<double>::infinity();
  if (stretches == 0)
    return wrong("nothing is opaque enough to be touched", threshold,
                 "an opacity above the threshold somewhere");
  if (stretches > 1)
    return Error{"the opaque intensities are not one stretch", "opacity ramp",
                 std::to_string(stretches) + " stretches", "one; make a shape of each", ""};
  return window;
}

}  // namespace trephine::haptics
