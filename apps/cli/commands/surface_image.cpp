#include "apps/cli/commands/surface_image.h"

#include <cmath>

#include "apps/workbench/text.h"
#include "data-tools/meshes/mesh_reading.h"
#include "modules/fluoroscopy/volume_xray.h"
#include "volume/surface/surface_nets.h"

namespace trephine::cli {

using fluoroscopy::View;
using glm::dvec3;
using workbench::format_text;

namespace {

/// Returns the mean attenuation of the voxels of a shape before the operation, 1/mm. `energy`: keV.
double mean_weight(const volume::Volume& scan, const volume::Shape& shape, double energy) {
  const volume::VoxelWeights weights = fluoroscopy::weights_of_hounsfield(energy);
  double sum = 0, count = 0;
  for (std::size_t i = 0; i < scan.voxels.size(); ++i) {
    const bool is_solid =
        shape.is_label() ? scan.labels[i] == shape.label : shape.is_solid(scan.window_voxels()[i]);
    if (is_solid) sum += weights.of(scan.voxels[i]), ++count;
  }
  return count > 0 ? sum / count : 0;
}

/// Returns the current surface of a shape as an object. `weight`: its attenuation, 1/mm.
fluoroscopy::SurfaceObject surface_of(const volume::Volume& scan, const volume::Shape& shape,
                                      const volume::Version& version, double weight) {
  const volume::Field field(scan, shape);
  const volume::Mesh net = volume::surface_net({&field, &version});
  fluoroscopy::SurfaceObject bone;
  bone.vertices_world.reserve(net.vertices.size());
  std::vector<std::uint8_t> is_border(net.vertices.size());
  for (std::size_t i = 0; i < net.vertices.size(); ++i) {
    const glm::vec3& v = net.vertices[i];
    bone.vertices_world.push_back(scan.frame.world_from_volume(dvec3(v)));
    for (int axis = 0; axis < 3; ++axis)
      is_border[i] |= v[axis] < 0 || v[axis] > static_cast<float>(scan.size[axis] - 1);
  }
  bone.triangles.assign(net.triangles.span().begin(), net.triangles.span().end());
  for (std::size_t t = 0; t + 2 < bone.triangles.size(); t += 3)
    bone.is_on_border.push_back(is_border[bone.triangles[t]] || is_border[bone.triangles[t + 1]] ||
                                is_border[bone.triangles[t + 2]]);
  bone.normals_world = fluoroscopy::vertex_normals({bone.vertices_world, bone.triangles});
  bone.weight = weight;
  return bone;
}

}  // namespace

Result<fluoroscopy::SurfaceXray> surface_image(const workbench::Moment& moment, const View& view,
                                               double energy, const SurfaceChoice& choice) {
  if (!moment.shape)
    return Error{
        .what = "no shape chosen as bone", .where = "surface", .expected = "--iso, --range or --label"};
  const volume::Volume& scan = *moment.scan;
  std::vector<fluoroscopy::SurfaceObject> objects{
      surface_of(scan, *moment.shape, *moment.version, mean_weight(scan, *moment.shape, energy))};
  objects[0].edge = choice.edge;
  if (choice.has_body) {
    volume::Shape body{"body", fluoroscopy::k_tissue_from};
    objects.push_back(surface_of(scan, body, *moment.version,
                                 fluoroscopy::attenuation(fluoroscopy::Matter::soft_tissue, energy)));
    objects[0].weight -= objects[1].weight;  // the body contains the bone
  }
  const double bone_weight = objects[0].weight;
  for (const workbench::Moment::Object& source : moment.objects) {
    if (source.matter == volume::Matter::scenery) continue;
    fluoroscopy::SurfaceObject& object = objects.emplace_back();
    for (const dvec3& v : source.tree->vertices())
      object.vertices_world.push_back(source.placement.world_from_local(v));
    object.triangles = source.tree->triangles();
    object.normals_world = fluoroscopy::vertex_normals({object.vertices_world, object.triangles});
    object.weight = source.is_piece ? bone_weight : fluoroscopy::attenuation(source.matter, energy);
    object.edge = source.is_piece ? choice.edge : 0;
  }
  return fluoroscopy::project_surfaces(view, objects);
}

Likeness likeness(std::span<const double> a, std::span<const double> b) {
  double n = 0, ma = 0, mb = 0;
  for (std::size_t i = 0; i < a.size(); ++i) ma += a[i], mb += b[i], ++n;
  ma /= n, mb /= n;
  double aa = 0, bb = 0, ab = 0, share = 0, count = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    aa += (a[i] - ma) * (a[i] - ma), bb += (b[i] - mb) * (b[i] - mb), ab += (a[i] - ma) * (b[i] - mb);
    if (a[i] > 0.01) share += std::abs(b[i] - a[i]) / a[i], ++count;
  }
  return {aa > 0 && bb > 0 ? ab / std::sqrt(aa * bb) : 0, count > 0 ? 100 * share / count : 0};
}

}  // namespace trephine::cli
