#include "haptics/depth/depth_items.h"

#include "haptics/mesh/mesh_tree.h"

namespace trephine::haptics::depth {

namespace {

/// Sets another method as the remedy, since the pixel size is not an option here.
Error suggest_method(Error error, const TouchItem& item, const char* method) {
  error.where = name_of(item);
  error.remedy = std::string("use method ") + method;
  return error;
}

Result<DepthCube> cube_of_model(const TouchItem& item, double pixel) {
  if (!item.tree) return Error{.what = "a mesh has no search tree", .where = item.name};
  if (item.mover >= 0)
    return Error{.what = "this method does not support moving meshes",
                 .where = item.name,
                 .found = "a mesh that moves",
                 .remedy = "use method scene"};
  glm::ivec3 size(0);
  const auto frame = lattice_around(item.tree->low(), item.tree->high(), pixel, size);
  if (!frame) return suggest_method(frame.error(), item, "scene");
  auto cube = DepthCube::of_triangles(item.tree->vertices(), item.tree->triangles(), frame.value(), size);
  if (!cube) return suggest_method(cube.error(), item, "scene");
  if (cube.value().open_rays() > 0)
    return Error{.what = "the model is not closed: rays do not leave it as often as they enter it",
                 .where = item.name,
                 .found = std::to_string(cube.value().open_rays()) + " rays",
                 .expected = "none",
                 .remedy = "close the surface, or use method mesh, which supports open surfaces"};
  return cube;
}

}  // namespace

Result<std::vector<DepthCube>> cubes_of(const TouchScene& scene, const ItemPixels& pixels) {
  std::vector<DepthCube> cubes;
  for (const TouchItem& item : scene.items) {
    auto cube = item.is_mesh() ? cube_of_model(item, pixels.of_models)
                               : DepthCube::of_voxels(item.field, *item.bits,
                                                      rays_per_voxel(item.field.volume(), pixels.of_volumes));
    if (!cube) return item.is_mesh() ? cube.error() : suggest_method(cube.error(), item, "subvoxel");
    cubes.push_back(std::move(cube).value());
  }
  return cubes;
}

}  // namespace trephine::haptics::depth
