#include "haptics/proxy/proxy_method.h"

#include <algorithm>
#include <cstdio>
#include <glm/geometric.hpp>

namespace trephine::haptics {

volume::Status check_stays_whole(const TouchScene& scene, const char* method) {
  if (!(scene.smallest_burr > 0)) return std::nullopt;
  return volume::Error{"this method does not feel cuts", "method",
                       std::string(method) + ", which touches what was there at first", "",
                       "use method subvoxel"};
}

volume::Status check_offsets(const TouchScene& scene, bool has_balls) {
  if (!scene.tool_balls.empty() && !has_balls)
    return volume::Error{"this method touches with one ball, or a point", "method",
                         std::to_string(scene.tool_balls.size()) + " balls", "", "use method chain"};
  if (scene.tool_radius > 0)
    for (const TouchItem& shape : scene.items)
      if (!shape.is_mesh() && (!shape.offset || shape.offset->radius_mm() != scene.tool_radius))
        return volume::Error{"a shape has no offset field for the tool's radius", shape.field.shape().name,
                             "", "", "set_tool_radius() makes it"};
  return std::nullopt;
}

volume::Status check_smallest_burr(const TouchScene& scene, double least) {
  // A round tool feels offset fields, which know cuts as they are.
  if (scene.tool_radius > 0 || scene.smallest_burr <= 0 || scene.smallest_burr >= least) return std::nullopt;
  const auto mm = [](double value) {
    char words[32];
    std::snprintf(words, sizeof words, "%.3g mm", value);
    return std::string(words);
  };
  return volume::Error{"this method is too coarse for the smallest burr", "smallest burr",
                       mm(scene.smallest_burr), "no less than " + mm(1.001 * least) + " on these voxels",
                       "use method subvoxel, which feels every cut as it is"};
}

volume::Status check_burr_opens_voxels(const TouchScene& scene) {
  if (scene.smallest_burr <= 0) return std::nullopt;  // nothing cuts; there may be no volume either
  const glm::dmat3& axes = scene.base->frame.axes();
  double diagonal = 0;
  for (const double y : {-1.0, 1.0})
    for (const double z : {-1.0, 1.0})
      diagonal = std::max(diagonal, glm::length(axes[0] + y * axes[1] + z * axes[2]));
  return check_smallest_burr(scene, diagonal);
}

volume::Status check_has_no_depth(const TouchScene& scene) {
  for (const TouchItem& item : scene.items)
    if (item.depth)
      return volume::Error{"this method does not touch objects by depth images", item.name,
                           "an item touched by depth images", "none", "use method scene"};
  return std::nullopt;
}

volume::Status check_touchable(const TouchScene& scene, bool has_radius, bool has_meshes) {
  if (volume::Status error = check_has_no_depth(scene)) return error;
  std::size_t shapes = 0;
  for (const TouchItem& shape : scene.items) {
    if (shape.is_mesh() && !has_meshes)
      return volume::Error{"this method touches volumes alone", "method", shape.name, "no mesh",
                           "use method scene"};
    if (shape.is_mesh()) continue;
    ++shapes;
    if (&shape.field.volume() != scene.base.get())
      return volume::Error{"this method touches one volume", shape.field.shape().name, "a second volume", "",
                           "use method scene"};
  }
  if (scene.tool_radius > 0 && !has_radius)
    return volume::Error{"this method has no radius", "tool radius",
                         std::to_string(scene.tool_radius) + " mm", "0, a point",
                         "use method subvoxel for a round tool"};
  if (shapes > TouchScene::k_max_shapes)
    return volume::Error{"too many shapes to touch at once", "scene", std::to_string(shapes),
                         "at most " + std::to_string(TouchScene::k_max_shapes),
                         "make fewer shapes touchable"};
  for (const TouchItem& shape : scene.items)
    if (!shape.is_mesh() && !shape.bits)
      return volume::Error{"a touchable shape has no bits", shape.field.shape().name, "", "", ""};
  return check_offsets(scene);
}

}  // namespace trephine::haptics
