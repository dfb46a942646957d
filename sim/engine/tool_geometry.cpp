#include "sim/engine/tool_geometry.h"

#include <algorithm>

#include "haptics/methods/methods.h"
#include "haptics/tool/point_shell.h"
#include "sim/engine/field_samples.h"
#include "volume/base/text.h"

namespace trephine::sim {

Status check_tool_radius(const volume::Volume& base, double radius) {
  const glm::dvec3& spacing = base.frame.spacing();
  const double least = 0.02 * std::min({spacing.x, spacing.y, spacing.z});
  if (radius == 0 || (radius >= least && radius <= 6)) return std::nullopt;
  return Error{.what = "the tool's radius is out of range",
               .where = "tool radius",
               .found = rounded_text(radius) + " mm",
               .expected = "0, or " + rounded_text(least) + " to 6 mm",
               .remedy = radius > 6 ? "use a smaller ball, or a point" : "use a point, or a larger ball"};
}

std::shared_ptr<const PreparedTool> make_geometry(const HandTool& tool,
                                                  const Result<haptics::SharedTool>& request,
                                                  const volume::Version& version,
                                                  const volume::VoxelBox& cut) {
  auto result = std::make_shared<PreparedTool>();
  auto scene = std::make_shared<haptics::TouchScene>(*tool.scene);
  if (!request) {
    result->failed = request.error();
    return result;
  }
  const double radius = request.value()->radius();
  if ((result->failed = haptics::set_tool(*scene, request.value()))) return result;
  // Uses the hand's initial method if it supports the new tool.
  const haptics::MethodInfo* initial = haptics::find_method(tool.initial_method);
  const bool is_same = !initial || (initial->freedom == scene->tool->freedom() &&
                                    initial->takes_shells == (scene->tool->shell() != nullptr));
  auto method =
      haptics::make_method(is_same ? tool.initial_method : haptics::general_method(*scene->tool).name);
  if (!method) {
    result->failed = method.error();
    return result;
  }
  if ((result->failed = method.value()->prepare(*scene))) return result;
  result->scene = std::move(scene);
  result->method = std::move(method).value();
  if (radius > 0 && cut.low.x <= cut.high.x)
    for (const haptics::TouchItem& shape : haptics::base_shapes(*result->scene))
      result->offsets.push_back(
          shape.offset->updated(shape.field, *shape.bits, version, cut, 0, nullptr, shape.soft.get()));
  constexpr int k_samples = 1 << 16;  // per field; they take about 1 ms
  MixHash hash;
  hash.add(radius);
  for (const haptics::ToolShape::Ball& ball : result->scene->tool->balls())
    for (int a = 0; a < 3; ++a) hash.add(ball.centre[a]);
  if (result->scene->tool->shell()) hash.add(result->scene->tool->shell()->hash());
  if (radius > 0)
    for (std::size_t s = 0; s < base_shapes(*result->scene).size(); ++s) {
      const volume::OffsetField& field =
          result->offsets.empty() ? *result->scene->items[s].offset : *result->offsets[s];
      add_samples(hash, field, {glm::ivec3(0), field.size() - 1}, k_samples);
    }
  result->fingerprint = hash.value();
  return result;
}

}  // namespace trephine::sim
