#include "apps/view/opened_structures.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <optional>
#include <string>
#include <sys/resource.h>
#include <unistd.h>

#include "apps/view/structures.h"
#include "volume/base/axes.h"
#include "volume/cuts/removal.h"
#include "volume/scan/traversal.h"

namespace trephine::view {

using glm::dvec3;
using glm::ivec3;
using volume::VoxelBox;

namespace {

constexpr double k_margin = 12;  // mm around an opening in which structures are meshed
constexpr int k_halo = 3;        // voxels around a chunk that its surface and normals depend on
// Level of the surface in the smoothed labels, which are 0 to 64. It is below one half, so that smoothing
// does not remove a nerve of one voxel.
constexpr double k_level = 27;
constexpr int k_membrane = 3;          // voxels; removed structure of at most this depth counts as a membrane
constexpr double k_normal_voxels = 6;  // radius around a vertex in which labels determine its normal
constexpr int k_torn_near = 3;         // voxels around a deep cut within which shallow cuts are drawn too
constexpr double k_two_pi = 6.283185307179586;
constexpr int k_backing = k_membrane + 1;  // voxels within which a membrane needs intact matter

bool is_empty(const VoxelBox& box) { return box.low.x > box.high.x; }

VoxelBox grown(const VoxelBox& box, const ivec3& by, const ivec3& size) {
  return {glm::max(box.low - by, ivec3(0)), glm::min(box.high + by, size - 1)};
}

template <class Is>
bool any_in_ball(const ivec3& v, int radius, const Is& is) {
  for (int z = -radius; z <= radius; ++z)
    for (int y = -radius; y <= radius; ++y)
      for (int x = -radius; x <= radius; ++x)
        if (x * x + y * y + z * z <= radius * radius && is(v + ivec3(x, y, z))) return true;
  return false;
}

template <class Each>
void for_voxels(const VoxelBox& box, const Each& each) {
  for (int z = box.low.z; z <= box.high.z; ++z)
    for (int y = box.low.y; y <= box.high.y; ++y)
      for (int x = box.low.x; x <= box.high.x; ++x) each(ivec3(x, y, z));
}

}  // namespace

/// All structures as one solid. Separate surfaces would coincide between structures that touch.
struct OpenedStructures::Solid {
  Solid(const haptics::TouchScene& touched, const std::vector<int>& labels);
  /// Meshes the structures near changed voxels.
  std::vector<ChunkMesh> mesh(const volume::Version& version, const VoxelBox& changed);
  /// Meshes the structures in natural gaps.
  std::vector<ChunkMesh> mesh_gaps(const volume::Version& version);

 private:
  struct Part {
    ivec3 chunk;
    VoxelBox changed;  ///< voxels
  };
  std::vector<ChunkMesh> mesh_parts(const volume::Version& version, const std::vector<Part>& parts);
  bool is_structure(const ivec3& v) const {
    return base->contains(v) && is_structure_label[base->labels[base->index(v.x, v.y, v.z)]];
  }
  /// Returns true if a voxel is deeper in the structures than a membrane's thickness.
  bool is_deep(const ivec3& v) const;
  /// Returns true if structures remain beneath a removed voxel, close enough for a membrane.
  bool is_backed(const volume::Version& version, const ivec3& v) const;
  /// Sets the drawn labels in a box: 1 in structures, 0 elsewhere and in the cuts that are drawn.
  void cut(const volume::Version& version, const VoxelBox& box);
  /// Smooths the drawn labels in a box, to remove their steps.
  void smooth(const VoxelBox& box);
  /// Returns the distance (mm) within which voxels determine a normal.
  double normal_reach() const {
    const dvec3 spacing = base->frame.spacing();
    return std::max(k_normal_voxels * std::cbrt(base->frame.voxel_mm3()),
                    1.5 * std::max({spacing.x, spacing.y, spacing.z}));
  }
  /// Returns the label of the first structure within two voxels below a point of the surface; nullopt if
  /// there is no structure.
  std::optional<int> label_below(const dvec3& at, const dvec3& normal) const;
  /// Sets the colours of the vertices from the labels below the surface.
  void paint(DrawMesh& mesh) const;
  /// Sets the normals of a mesh from the drawn labels within normal_reach(), and its openness from bone
  /// alone: the surface of the labels is terraced and would shade itself. `light`: the bone.
  void shade(DrawMesh& mesh, const haptics::TouchScene& light, const volume::Version& version) const;

  std::shared_ptr<const volume::Volume> base;
  std::size_t shape;  ///< shape number in the picture
  std::vector<int> labels;
  std::array<bool, 256> is_structure_label{}, is_in_gaps{};    ///< by label value
  std::vector<dvec3> colours;                                  ///< by label value
  std::shared_ptr<volume::Volume> drawn;                       ///< drawn labels; its voxels: smoothed labels
  std::vector<std::shared_ptr<const volume::Occupancy>> bone;  ///< occludes the light
  std::set<std::tuple<int, int, int>> meshed;                  ///< chunks that mesh() has meshed
  std::vector<ivec3> around;  ///< offsets of the voxels that a normal depends on
  volume::NetScratch scratch;
};

OpenedStructures::Solid::Solid(const haptics::TouchScene& touched, const std::vector<int>& values)
    : base(touched.base),
      shape(base_shapes(touched).size()),
      labels(values),
      colours(touched.base->label_names.size()),
      drawn(std::make_shared<volume::Volume>()) {
  const std::array<bool, 256> in_gaps = structures_in_gaps(*base);
  for (const int label : labels) {
    const auto l = static_cast<std::size_t>(label);
    is_structure_label[l] = true;
    is_in_gaps[l] = in_gaps[l];
    colours[l] = structure_colour(*base, label);
  }
  for (const haptics::TouchItem& item : base_shapes(touched)) bone.push_back(item.bits);
  const dvec3 spacing = base->frame.spacing();
  const double reach = normal_reach() + 0.5 * base->frame.diagonal_mm();
  const ivec3 most(glm::ceil(reach / spacing));
  for_voxels({-most, most}, [&](const ivec3& v) {
    if (glm::length(dvec3(v) * spacing) <= reach) around.push_back(v);
  });
  drawn->size = base->size;
  drawn->frame = base->frame;
  drawn->label_names = {"", "structures"};
  drawn->labels = Buffer<std::uint8_t>(base->labels.size());
  drawn->voxels = Buffer<std::int16_t>(base->labels.size());
  std::fill(drawn->voxels.span().begin(), drawn->voxels.span().end(), std::int16_t{0});
  const auto source = base->labels.span();
  std::transform(source.begin(), source.end(), drawn->labels.span().begin(),
                 [&](std::uint8_t label) { return is_in_gaps[label] ? 1 : 0; });
}

bool OpenedStructures::Solid::is_deep(const ivec3& v) const {
  return !any_in_ball(v, k_membrane, [&](const ivec3& near) { return !is_structure(near); });
}

bool OpenedStructures::Solid::is_backed(const volume::Version& version, const ivec3& v) const {
  ivec3 inward(0);  // toward the middle of the structures around v
  any_in_ball(v, k_backing, [&](const ivec3& near) {
    if (is_structure(near)) inward += near - v;
    return false;
  });
  // Only matter within 60 degrees of `inward` counts. The stumps of a cut nerve are to the side and do not
  // count.
  return any_in_ball(v, k_backing, [&](const ivec3& near) {
    if (!is_structure(near) || !version.is_kept(near)) return false;
    const dvec3 offset(near - v), in(inward);
    return 2 * glm::dot(offset, in) > glm::length(offset) * glm::length(in);
  });
}

void OpenedStructures::Solid::cut(const volume::Version& version, const VoxelBox& box) {
  for_voxels(box, [&](const ivec3& v) {
    const bool is_drawn = is_structure(v) && (version.is_kept(v) || is_backed(version, v));
    drawn->labels[drawn->index(v.x, v.y, v.z)] = is_drawn;
  });
  for_voxels(grown(box, ivec3(k_torn_near), base->size), [&](const ivec3& v) {
    if (version.is_kept(v) || !is_deep(v)) return;
    const VoxelBox near = grown({v, v}, ivec3(k_torn_near), base->size);
    for_voxels({glm::max(near.low, box.low), glm::min(near.high, box.high)}, [&](const ivec3& other) {
      if (!version.is_kept(other)) drawn->labels[drawn->index(other.x, other.y, other.z)] = 0;
    });
  });
}

void OpenedStructures::Solid::smooth(const VoxelBox& box) {
  for_voxels(box, [&](const ivec3& v) {
    int sum = 0;
    for (int z = -1; z <= 1; ++z)
      for (int y = -1; y <= 1; ++y)
        for (int x = -1; x <= 1; ++x) {
          const ivec3 p = glm::clamp(v + ivec3(x, y, z), ivec3(0), base->size - 1);
          sum += drawn->labels[drawn->index(p.x, p.y, p.z)] << (3 - x * x - y * y - z * z);
        }
    drawn->voxels[drawn->index(v.x, v.y, v.z)] = static_cast<std::int16_t>(sum);
  });
}

std::vector<ChunkMesh> OpenedStructures::Solid::mesh(const volume::Version& version,
                                                     const VoxelBox& changed) {
  const ivec3 margin(glm::ceil(k_margin / base->frame.spacing()));
  const VoxelBox around = grown(changed, margin, base->size),
                 near = grown(changed, ivec3(k_backing + 1), base->size);
  const volume::ChunkRange range = volume::chunks_touching(around.low, around.high, base->size),
                           outdated = volume::chunks_touching(near.low, near.high, base->size);
  cut(version, grown(changed, ivec3(k_backing), base->size));
  smooth(near);
  // `changed` may contain cuts that are far apart. Only chunks near cuts are meshed, so that the picture does
  // not depend on the way in which changes are grouped.
  const auto is_near_cuts = [&](const VoxelBox& cells) {
    const VoxelBox box = grown(cells, margin, base->size);
    return version.has_brick(version.lattice().low_of(box.low), version.lattice().high_of(box.high));
  };
  std::vector<Part> parts;
  for_voxels({range.first, range.last}, [&](const ivec3& chunk) {
    const VoxelBox cells{volume::k_chunk * chunk, volume::k_chunk * (chunk + 1) - 1};
    const std::tuple key(chunk.x, chunk.y, chunk.z);
    if (!meshed.contains(key) && !is_near_cuts(cells)) return;
    const bool is_new = meshed.insert(key).second;
    if (!is_new && !VoxelBox{outdated.first, outdated.last}.contains(chunk)) return;
    parts.push_back({chunk, is_new ? grown(cells, ivec3(1), base->size) : near});
    if (!is_new) return;
    cut(version, grown(cells, ivec3(k_halo + 1), base->size));
    smooth(grown(cells, ivec3(k_halo), base->size));
  });
  return mesh_parts(version, parts);
}

std::vector<ChunkMesh> OpenedStructures::Solid::mesh_gaps(const volume::Version& version) {
  std::vector<Part> parts;
  for_voxels({ivec3(0), (base->size - 1) / volume::k_chunk}, [&](const ivec3& chunk) {
    const VoxelBox cells =
        grown({volume::k_chunk * chunk, volume::k_chunk * (chunk + 1) - 1}, ivec3(1), base->size);
    bool has_some = false;
    for_voxels(cells, [&](const ivec3& v) { has_some |= drawn->labels[drawn->index(v.x, v.y, v.z)] != 0; });
    if (!has_some) return;
    parts.push_back({chunk, cells});
    smooth(grown(cells, ivec3(k_halo), base->size));
  });
  return mesh_parts(version, parts);
}

std::vector<ChunkMesh> OpenedStructures::Solid::mesh_parts(const volume::Version& version,
                                                           const std::vector<Part>& parts) {
  volume::Shape solid;
  solid.name = "structures";
  solid.low = k_level;
  haptics::TouchScene scene;
  scene.base = drawn;
  const volume::Field field(*drawn, solid);
  auto bits = std::make_shared<const volume::Occupancy>(volume::Occupancy::build(*drawn, solid, 1));
  haptics::TouchScene light;
  light.base = drawn;
  for (const auto& other : bone) light.items.push_back({field, other, {}, haptics::Side::front});
  scene.items = light.items;
  scene.items.insert(scene.items.begin(), {field, bits, {}, haptics::Side::front});

  std::vector<ChunkMesh> meshes;
  for (const auto& [chunk, changed] : parts) {
    const ivec3 middle = glm::min(volume::k_chunk * chunk + volume::k_chunk / 2, base->size - 1);
    if (bits->empty_distance(middle) > volume::k_chunk / 8 + 2) continue;
    ChunkMesh result = make_chunk_mesh(scene, 0, version, chunk, &scratch, CutsOfShape::ignored);
    result.shape = shape;
    paint(result.fine);
    paint(result.coarse);
    shade(result.fine, light, version);
    shade(result.coarse, light, version);
    set_changed(result, base->frame, changed);
    meshes.push_back(std::move(result));
  }
  return meshes;
}

std::optional<int> OpenedStructures::Solid::label_below(const dvec3& at, const dvec3& normal) const {
  const double step = 0.5 * std::cbrt(base->frame.voxel_mm3());
  for (int deep = 1; deep <= 4; ++deep) {
    const ivec3 v = volume::voxel_of(base->frame.volume_from_world(at - deep * step * normal));
    if (is_structure(v)) return base->labels[base->index(v.x, v.y, v.z)];
  }
  return std::nullopt;
}

void OpenedStructures::Solid::paint(DrawMesh& mesh) const {
  // Labels change in steps of a voxel. Mixing the colours by the shares of the labels around a vertex makes
  // the borders smooth. The third power of the shares keeps the borders narrow.
  struct Near {
    double right, up;  ///< offset along the surface, voxels
    double weight;
  };
  static const std::vector<Near> k_near = [] {
    constexpr int k_directions = 8;
    std::vector<Near> all{{0, 0, 1}};
    for (int n = 0; n < k_directions; ++n) {
      const double inner = n * k_two_pi / k_directions, outer = (n + 0.5) * k_two_pi / k_directions;
      all.push_back({std::cos(inner), std::sin(inner), 0.7});
      all.push_back({2 * std::cos(outer), 2 * std::sin(outer), 0.35});
    }
    return all;
  }();
  const double voxel = std::cbrt(base->frame.voxel_mm3());
  mesh.colours.reserve(mesh.vertices.size());
  std::vector<double> shares(colours.size());
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const dvec3 at(mesh.vertices[i]), normal(mesh.normals[i]);
    const dvec3 other = volume::non_parallel_axis(normal), right = glm::normalize(glm::cross(normal, other)),
                up = glm::cross(right, normal);
    std::fill(shares.begin(), shares.end(), 0.0);
    for (const Near& near : k_near)
      if (const auto label = label_below(at + voxel * (near.right * right + near.up * up), normal))
        shares[static_cast<std::size_t>(*label)] += near.weight;
    dvec3 colour(0);
    double sum = 0;
    for (std::size_t label = 0; label < shares.size(); ++label) {
      const double weight = shares[label] * shares[label] * shares[label];
      colour += weight * colours[label], sum += weight;
    }
    mesh.colours.emplace_back(sum > 0 ? colour / sum : colours[static_cast<std::size_t>(labels.front())]);
  }
}

void OpenedStructures::Solid::shade(DrawMesh& mesh, const haptics::TouchScene& light,
                                    const volume::Version& version) const {
  std::fill(mesh.freshness.begin(), mesh.freshness.end(), 0.0f);  // structures have no cut colour
  const double reach = normal_reach();
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const dvec3 at(mesh.vertices[i]), old(mesh.normals[i]);
    const ivec3 middle = volume::voxel_of(base->frame.volume_from_world(at));
    dvec3 outward(0);
    for (const ivec3& offset : around) {
      const ivec3 v = glm::clamp(middle + offset, ivec3(0), base->size - 1);
      if (drawn->labels[drawn->index(v.x, v.y, v.z)] == 0) continue;
      const dvec3 d = base->frame.world_from_volume(dvec3(middle + offset)) - at;
      // The weight falls smoothly to 0, because the set of voxels changes abruptly from vertex to vertex.
      const double weight = std::max(0.0, 1 - glm::dot(d, d) / (reach * reach));
      outward -= weight * weight * d;
    }
    const double length = glm::length(outward);
    // Near edges and in cuts the normal of the mesh is better.
    constexpr double k_turned = 0.2;  // least cosine between the two normals
    if (length > 1e-9 && glm::dot(outward, old) > k_turned * length)
      mesh.normals[i] = glm::vec3(outward / length);
    mesh.openness[i] = openness_at(light, version, base->frame.volume_from_world(at), dvec3(mesh.normals[i]));
  }
}

OpenedStructures::OpenedStructures(const haptics::TouchScene& scene, std::vector<int> labels)
    : scene_(&scene), labels_(std::move(labels)) {
  const std::array<bool, 256> in_gaps = structures_in_gaps(*scene.base);
  are_gaps_waiting_ = std::any_of(labels_.begin(), labels_.end(),
                                  [&](int label) { return in_gaps[static_cast<std::size_t>(label)]; });
}

OpenedStructures::~OpenedStructures() {
  if (job_.valid()) job_.wait();
}

void OpenedStructures::request_all(const std::shared_ptr<const volume::Version>& version) {
  if (labels_.empty()) return;
  if (are_gaps_waiting_) version_ = version, start();
  if (version->is_uncut()) return;
  // Find the box of the cuts chunk by chunk: structures are meshed in whole chunks.
  const volume::CutLattice& lattice = version->lattice();
  VoxelBox opened{ivec3(0), ivec3(-1)};
  for_voxels({ivec3(0), (scene_->base->size - 1) / volume::k_chunk}, [&](const ivec3& chunk) {
    const VoxelBox box{volume::k_chunk * chunk,
                       glm::min(volume::k_chunk * (chunk + 1), scene_->base->size) - 1};
    if (version->has_brick(lattice.low_of(box.low), lattice.high_of(box.high)))
      opened = is_empty(opened) ? box : volume::union_of(opened, box);
  });
  request(version, opened);
}

void OpenedStructures::request(const std::shared_ptr<const volume::Version>& version,
                               const VoxelBox& changed) {
  if (labels_.empty() || is_empty(changed)) return;
  version_ = version;
  waiting_ = is_empty(waiting_) ? changed : volume::union_of(waiting_, changed);
  start();
}

void OpenedStructures::start() {
  if (job_.valid() || (is_empty(waiting_) && !are_gaps_waiting_)) return;
  job_ = std::async(std::launch::async, [this, version = std::move(version_),
                                         changed = std::exchange(waiting_, {ivec3(0), ivec3(-1)}),
                                         has_gaps = std::exchange(are_gaps_waiting_, false)] {
    setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), 10);
    if (!solid_) solid_ = std::make_unique<Solid>(*scene_, labels_);
    std::vector<ChunkMesh> meshes;
    if (has_gaps) meshes = solid_->mesh_gaps(*version);
    if (!is_empty(changed)) std::ranges::move(solid_->mesh(*version, changed), std::back_inserter(meshes));
    return meshes;
  });
}

void OpenedStructures::collect() {
  std::vector<ChunkMesh> meshes = job_.get();
  std::move(meshes.begin(), meshes.end(), std::back_inserter(done_));
  start();
}

std::vector<ChunkMesh> OpenedStructures::take() {
  if (job_.valid() && job_.wait_for(std::chrono::seconds(0)) == std::future_status::ready) collect();
  return std::exchange(done_, {});
}

void OpenedStructures::finish() {
  while (job_.valid()) collect();
}

bool OpenedStructures::is_complete() const { return !job_.valid() && done_.empty(); }

}  // namespace trephine::view
