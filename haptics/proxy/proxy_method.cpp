#include "haptics/proxy/proxy_method.h"

#include <algorithm>
#include <cstdio>
#include <glm/geometric.hpp>

#include "volume/base/text.h"

namespace trephine::haptics {

Status check_cuts(const TouchScene& scene, const MethodInfo& method) {
  if (method.takes_cuts || !(scene.smallest_burr > 0)) return std::nullopt;
  return Error{.what = "this method does not support cuts",
               .where = "method",
               .found = std::string(method.name) + ", which ignores cuts",
               .remedy = "use method subvoxel"};
}

Status check_offsets(const TouchScene& scene, const MethodInfo& method) {
  if (!method.takes(*scene.tool)) {
    using Kind = ToolShape::Kind;
    const Kind kind = scene.tool->kind();
    return Error{.what = "this method does not support the tool of the scene",
                 .where = "method",
                 .found = std::string(method.name) + ", with " +
                          (kind == Kind::shell   ? "the surface of a whole tool"
                           : kind == Kind::balls ? std::to_string(scene.tool->balls().size()) + " balls"
                           : kind == Kind::ball  ? "one ball"
                                                 : "a point"),
                 .remedy = std::string("use method ") + (kind == Kind::shell   ? "shell"
                                                         : kind == Kind::balls ? "chain"
                                                                               : "subvoxel")};
  }
  if (scene.tool->radius() > 0)
    for (const TouchItem& shape : scene.items)
      if (!shape.is_mesh() && (!shape.offset || shape.offset->radius_mm() != scene.tool->radius()))
        return Error{.what = "a shape has no offset field for the tool's radius",
                     .where = shape.field.shape().name,
                     .remedy = "call set_tool_radius() first"};
  return std::nullopt;
}

Status check_smallest_burr(const TouchScene& scene, double min_mm) {
  // A round tool touches offset fields, which contain cuts exactly.
  if (scene.tool->radius() > 0 || scene.smallest_burr <= 0 || scene.smallest_burr >= min_mm)
    return std::nullopt;
  const auto mm = [](double value) {
    char words[32];
    std::snprintf(words, sizeof words, "%.3g mm", value);
    return std::string(words);
  };
  return Error{.what = "this method is too coarse for the smallest burr",
               .where = "smallest burr",
               .found = mm(scene.smallest_burr),
               .expected = "at least " + mm(1.001 * min_mm) + " on these voxels",
               .remedy = "use method subvoxel"};
}

Status check_burr_opens_voxels(const TouchScene& scene) {
  if (scene.smallest_burr <= 0) return std::nullopt;  // no cuts, and perhaps no volume
  const glm::dmat3& axes = scene.base->frame.axes();
  double diagonal = 0;
  for (const double y : {-1.0, 1.0})
    for (const double z : {-1.0, 1.0})
      diagonal = std::max(diagonal, glm::length(axes[0] + y * axes[1] + z * axes[2]));
  return check_smallest_burr(scene, diagonal);
}

Status check_has_no_depth(const TouchScene& scene) {
  for (const TouchItem& item : scene.items)
    if (item.depth)
      return Error{.what = "this method does not support depth images",
                   .where = item.name,
                   .found = "an item touched by depth images",
                   .expected = "no item with depth images",
                   .remedy = "use method scene"};
  return std::nullopt;
}

Status check_touchable(const TouchScene& scene, const MethodInfo& method) {
  if (Status error = check_has_no_depth(scene)) return error;
  std::size_t shapes = 0;
  for (const TouchItem& shape : scene.items) {
    if (shape.is_mesh() && !method.takes_meshes)
      return Error{.what = "this method supports volumes only",
                   .where = "method",
                   .found = shape.name,
                   .expected = "no mesh",
                   .remedy = "use method scene"};
    if (shape.is_mesh()) continue;
    ++shapes;
    if (&shape.field.volume() != scene.base.get())
      return Error{.what = "this method supports one volume only",
                   .where = shape.field.shape().name,
                   .found = "a second volume",
                   .remedy = "use method scene"};
  }
  if (scene.tool->radius() > 0 && !method.takes_ball && !method.takes_sets_of_balls)
    return Error{.what = "this method supports points only",
                 .where = "tool radius",
                 .found = rounded_text(scene.tool->radius()) + " mm",
                 .expected = "0, a point",
                 .remedy = "use method subvoxel for a round tool"};
  if (shapes > TouchScene::k_max_shapes)
    return Error{.what = "too many shapes to touch at once",
                 .where = "scene",
                 .found = std::to_string(shapes),
                 .expected = "at most " + std::to_string(TouchScene::k_max_shapes),
                 .remedy = "make fewer shapes touchable"};
  for (const TouchItem& shape : scene.items)
    if (!shape.is_mesh() && !shape.bits)
      return Error{.what = "a touchable shape has no occupancy",
                   .where = shape.field.shape().name,
                   .remedy = "build it with Occupancy::build()"};
  return check_offsets(scene, method);
}

}  // namespace trephine::haptics
