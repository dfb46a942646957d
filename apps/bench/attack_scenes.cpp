#include "apps/bench/attack_scenes.h"

#include <algorithm>
#include <memory>

#include "apps/bench/scenes/scenes.h"
#include "haptics/mesh/mesh_tree.h"
#include "volume/base/deterministic_math.h"
#include "volume/base/mix_hash.h"
#include "volume/surface/surface_nets.h"

namespace trephine::bench {

using glm::dvec3;

haptics::TouchScene attack_scene(const std::string& phantom, double psf, bool is_binary, bool is_noisy,
                                 std::map<std::string, double> parameters, double slice) {
  data_tools::PhantomOptions o;
  if (slice == 1)
    o.size = glm::ivec3(64);
  else
    o.spacing_mm = 120.0 / 64 * dvec3(0.7, 0.7, 0.7 * slice);
  o.psf_sigma_voxels = psf;
  o.shear_degrees = 7;
  o.parameters = std::move(parameters);
  volume::Volume result = data_tools::make_phantom(phantom, o).value();
  for (std::size_t i = 0; i < result.voxels.size(); ++i) {
    auto& v = result.voxels[i];
    if (is_binary) v = v >= 300 ? 1600 : -1000;
    if (is_noisy) v = static_cast<std::int16_t>(std::clamp(v + 200 * hash_normal(3, i), -1024.0, 3071.0));
  }
  haptics::TouchScene scene = scenes::scene_of(std::move(result));
  haptics::soften(scene);
  return scene;
}

haptics::TouchScene two_shapes_scene() {
  haptics::TouchScene scene = attack_scene("gyroid", 1.5, false, false);
  volume::Shape rind;
  rind.name = "rind", rind.low = -400, rind.high = 300;
  haptics::TouchItem second = scene.items[0];
  second.field = volume::Field(*scene.base, rind);
  second.bits = std::make_shared<const volume::Occupancy>(volume::Occupancy::build(*scene.base, rind));
  second.soft = nullptr;
  scene.items.push_back(std::move(second));
  return scene;
}

/// A ball in sheared voxels, divided into three labels by two planes.
haptics::TouchScene three_labels_scene() {
  data_tools::PhantomOptions o;
  o.size = glm::ivec3(64);
  o.psf_sigma_voxels = 0;
  o.shear_degrees = 7;
  volume::Volume result = data_tools::make_phantom("sphere", o).value();
  result.label_names = {"background", "part1", "part2", "part3"};
  result.labels = Buffer<std::uint8_t>(result.voxels.size());
  for (int z = 0; z < result.size.z; ++z)
    for (int y = 0; y < result.size.y; ++y)
      for (int x = 0; x < result.size.x; ++x) {
        const std::size_t i = result.index(x, y, z);
        const dvec3 p = result.frame.world_from_volume({x, y, z});
        const bool is_behind = p.y > 0.3 * p.x, is_left = p.x > 0.2 * p.y + 0.1 * p.z;
        result.labels[i] = static_cast<std::uint8_t>(result.voxels[i] < 300 ? 0
                                                     : is_behind            ? 1
                                                     : is_left              ? 2
                                                                            : 3);
      }
  haptics::TouchScene scene;
  scene.base = std::make_shared<const volume::Volume>(std::move(result));
  for (int label = 1; label <= 3; ++label) {
    volume::Shape shape;
    shape.name = scene.base->label_names[static_cast<std::size_t>(label)];
    shape.label = label;
    scene.items.push_back(
        {volume::Field(*scene.base, shape),
         std::make_shared<const volume::Occupancy>(volume::Occupancy::build(*scene.base, shape)),
         haptics::Material{}, haptics::Side::front});
  }
  haptics::soften(scene);
  return scene;
}

haptics::TouchScene touched_from_inside_scene() {
  haptics::TouchScene scene = attack_scene("gyroid", 1, false, false);
  scene.items[0].sides = haptics::Side::back;
  return scene;
}

haptics::TouchScene pierced_scene() {
  haptics::TouchScene scene = attack_scene("gyroid", 0.7, false, false);
  const haptics::TouchScene torus = attack_scene("torus", 0.7, false, false);
  const volume::Mesh net = volume::surface_net({&torus.items[0].field, nullptr, torus.items[0].bits.get()});
  const volume::Frame& frame = scene.base->frame;
  std::vector<dvec3> vertices;
  for (const glm::vec3& v : net.vertices.span()) vertices.push_back(frame.world_from_volume(dvec3(v)));
  scene.items.push_back(haptics::mesh_item(
      "torus",
      std::make_shared<haptics::MeshTree>(
          std::move(vertices),
          std::vector<std::uint32_t>(net.triangles.data(), net.triangles.data() + net.triangles.size()))));
  return scene;
}

}  // namespace trephine::bench
