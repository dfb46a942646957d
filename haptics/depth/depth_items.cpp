#include "haptics/depth/depth_items.h"

#include "haptics/mesh/mesh_tree.h"

namespace trephine::haptics::depth {

using volume::Error;
using volume::Result;

namespace {

/// Pixels are not an option here: another method is the remedy.
Error with_way_out(Error error, const TouchItem& item, const char* method) {
  error.where = name_of(item);
  error.remedy = std::string("use method ") + method;
  return error;
}

Result<DepthCube> cube_of_model(const TouchItem& item, double pixel) {
  if (!item.tree) return Error{"a mesh has no tree", item.name, "", "", ""};
  if (item.mover >= 0)
    return Error{"this method holds meshes still", item.name, "a mesh that moves", "", "use method scene"};
  glm::ivec3 size(0);
  const auto frame = lattice_around(item.tree->low(), item.tree->high(), pixel, size);
  if (!frame) return with_way_out(frame.error(), item, "scene");
  auto cube = DepthCube::of_triangles(item.tree->vertices(), item.tree->triangles(), frame.value(), size);
  if (!cube) return with_way_out(cube.error(), item, "scene");
  if (cube.value().open_rays() > 0)
    return Error{"a model is not closed: rays leave it that never entered", item.name,
                 std::to_string(cube.value().open_rays()) + " rays", "none",
                 "close it, or use method mesh, which touches sheets"};
  return cube;
}

}  // namespace

Result<std::vector<DepthCube>> cubes_of(const TouchScene& scene, const ItemPixels& pixels) {
  std::vector<DepthCube> cubes;
  for (const TouchItem& item : scene.items) {
    auto cube = item.is_mesh() ? cube_of_model(item, pixels.of_models)
                               : DepthCube::of_voxels(item.field, *item.bits,
                                                      rays_a_voxel(item.field.volume(), pixels.of_volumes));
    if (!cube) return item.is_mesh() ? cube.error() : with_way_out(cube.error(), item, "subvoxel");
    cubes.push_back(std::move(cube).value());
  }
  return cubes;
}

}  // namespace trephine::haptics::depth
