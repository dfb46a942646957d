#include "apps/bench/scenes/guaranteed_solid.h"

#include "apps/verify/cell_mesh.h"
#include "haptics/depth/depth_net.h"

namespace trephine::scenes {

using haptics::MethodInfo;

std::shared_ptr<const volume::OffsetField> touch_offset_field(const haptics::TouchScene& scene,
                                                              const haptics::TouchState* touch_state,
                                                              std::size_t shape) {
  if (scene.tool->radius() <= 0) return nullptr;
  return touch_state ? touch_state->shared_offset(scene, shape) : scene.items[shape].offset;
}

verify::SmoothSolid touched_smooth_solid(const haptics::TouchScene& scene,
                                         std::shared_ptr<const haptics::TouchState> touch_state,
                                         std::size_t shape) {
  if (const auto offset = touch_offset_field(scene, touch_state.get(), shape))
    return verify::SmoothSolid([offset](int x, int y, int z) { return offset->at(x, y, z); },
                               {[offset](const glm::ivec3& cube) { return offset->sheets_at(cube); },
                                [offset](int sheet, const glm::ivec3& cube, const glm::ivec3& at) {
                                  return offset->sheet_at(sheet, cube, at);
                                }});
  const haptics::TouchItem& touched = scene.items[shape];
  return verify::smooth_solid(scene.base, touched.field.shape(), touch_state ? touch_state->version : nullptr,
                              touched.soft);
}

GuaranteedSolid::GuaranteedSolid(const MethodInfo& method, const haptics::TouchScene& scene,
                                 std::shared_ptr<const haptics::TouchState> touch_state, std::size_t index)
    : base_(scene.base) {
  using Solid = MethodInfo::Solid;
  const haptics::TouchItem& shape = scene.items[index];
  if (!method.takes_cuts) touch_state = nullptr;
  const std::shared_ptr<const volume::Version> version = touch_state ? touch_state->version : nullptr;
  // Methods without cuts have another shape for a round tool than the offset field. For them, judge only that
  // the tool's centre stays outside the shape itself.
  if (method.takes_cuts) offset_ = touch_offset_field(scene, touch_state.get(), index);
  if (method.solid == Solid::smooth) {
    smooth_ = std::make_unique<verify::SmoothSolid>(touched_smooth_solid(scene, touch_state, index));
    return;
  }
  if (method.solid == Solid::cubes || method.solid == Solid::nothing) {
    cubes_ = offset_ ? std::make_unique<verify::FallThroughJudge>(
                           offset_->size(),
                           [field = offset_](int x, int y, int z) { return field->at(x, y, z) >= 0; })
                     : std::make_unique<verify::FallThroughJudge>(
                           base_->size, verify::solid_voxels(base_, shape.field.shape(), version));
    return;
  }
  if (method.solid == Solid::images) {
    // This net is for volumes; the test DepthNet.OfAVolumeEqualsItsSurfaceNet compares it with the surface
    // net. Models that are touched by images are not judged here, but by their triangles.
    using namespace haptics::depth;
    const DepthNet net(DepthCube::of_voxels(shape.field, *shape.bits, glm::ivec3(1)).value(),
                       DepthNet::Thin::separate);
    const volume::Mesh mesh = verify::mesh_of_cells(volume::LocalNet{DepthSamples(net)}, net.cube().size());
    lattice_ = net.cube().frame();
    triangles_ = std::make_unique<verify::MeshWall>(mesh.vertices.span(), mesh.triangles.span());
    return;
  }
  const volume::SurfaceSource source{&shape.field, version.get(), shape.bits.get(), false, true};
  using volume::LocalCubes, volume::LocalNet, verify::mesh_of_cells;
  const bool is_net = method.solid == Solid::net;
  const volume::Mesh mesh =
      offset_ ? (is_net ? mesh_of_cells(LocalNet{volume::OffsetSamples(*offset_)}, offset_->size())
                        : mesh_of_cells(LocalCubes{volume::OffsetSamples(*offset_)}, offset_->size(), false))
              : (is_net ? volume::surface_net(source)
                        : mesh_of_cells(LocalCubes{volume::VoxelSamples(source)}, base_->size, false,
                                        shape.bits.get()));
  triangles_ = std::make_unique<verify::MeshWall>(mesh.vertices.span(), mesh.triangles.span());
}

bool GuaranteedSolid::meets(const glm::dvec3& from, const glm::dvec3& to) const {
  const auto in_samples = [this](const glm::dvec3& p) {
    if (!offset_ && !lattice_) return p;
    return (offset_ ? offset_->frame() : *lattice_).volume_from_world(base_->frame.world_from_volume(p));
  };
  const glm::dvec3 a = in_samples(from), b = in_samples(to);
  if (smooth_) return !smooth_->is_free(a, b);
  if (cubes_) return cubes_->meets_solid(a, b);
  return a == b ? triangles_->is_inside(a) : triangles_->is_crossed(a, b);
}

}  // namespace trephine::scenes
