#include "apps/cli/report/report_models.h"

#include <cmath>
#include <glm/matrix.hpp>

#include "apps/view/chunk_meshes.h"
#include "apps/workbench/text.h"
#include "data-tools/meshes/glb_file.h"
#include "modules/fluoroscopy/surface_xray.h"
#include "volume/surface/surface_nets.h"

namespace trephine::cli {

using data_tools::ScenePart;
using glm::dvec3;
using view::DrawMesh;

namespace {

constexpr std::array<float, 3> k_metal{0.42F, 0.46F, 0.50F}, k_soft{0.70F, 0.35F, 0.32F},
    k_cut{0.80F, 0.38F, 0.22F}, k_line{0.05F, 0.35F, 0.60F};

/// Reduces a mesh to at most `limit` triangles: vertices are merged in cubes, which grow up to 12 times until
/// the triangles are few enough. Vertices in `stays` are not merged, unless their triangles are more than
/// half of `limit`.
DrawMesh reduced(const DrawMesh& mesh, std::size_t limit, std::vector<bool> stays) {
  const std::size_t count = mesh.triangles.size() / 3;
  if (count <= limit) return mesh;
  if (limit == 0) return {};
  double area = 0;
  std::size_t kept = 0;
  for (std::size_t t = 0; t + 2 < mesh.triangles.size(); t += 3) {
    const glm::vec3 &a = mesh.vertices[mesh.triangles[t]], &b = mesh.vertices[mesh.triangles[t + 1]],
                    &c = mesh.vertices[mesh.triangles[t + 2]];
    area += 0.5 * static_cast<double>(glm::length(glm::cross(b - a, c - a)));
    kept += stays[mesh.triangles[t]];
  }
  if (2 * kept > limit) {
    stays.assign(stays.size(), false);
    kept = 0;
  }
  // A net in cubes of edge e has about 2 triangles per e^2 of its area.
  double cell = std::sqrt(2 * area / static_cast<double>(limit - kept));
  constexpr int k_max_rounds = 12;
  DrawMesh result;
  for (int round = 0; round < k_max_rounds; ++round, cell *= 1.25) {
    result = view::clustered(mesh, cell, stays);
    if (result.triangles.size() / 3 <= limit) break;
  }
  return result;
}

/// Returns the surface of a shape in a version. Vertices on a cut have a freshness of 1. `stays` (output):
/// true for vertices near a cut of the version `near`.
DrawMesh shape_mesh(const haptics::TouchItem& item, const volume::Version& version,
                    const volume::Version& near, std::vector<bool>& stays) {
  const volume::SurfaceSource source{&item.field, &version, item.bits.get()};
  const volume::Mesh net = volume::surface_net(source);
  const Buffer<glm::vec3> normals = volume::vertex_normals(source, net);
  const volume::Frame& frame = item.field.volume().frame;
  const double half_diagonal = 0.5 * frame.diagonal_mm(),
               on_cut = std::min(half_diagonal, 0.9 * version.band_mm());
  DrawMesh mesh;
  mesh.normals.assign(normals.span().begin(), normals.span().end());
  mesh.triangles.assign(net.triangles.span().begin(), net.triangles.span().end());
  if (glm::determinant(frame.axes()) < 0)
    for (std::size_t t = 0; t + 2 < mesh.triangles.size(); t += 3)
      std::swap(mesh.triangles[t + 1], mesh.triangles[t + 2]);
  for (std::size_t i = 0; i < net.vertices.size(); ++i) {
    const dvec3 p(net.vertices[i]);
    mesh.vertices.emplace_back(frame.world_from_volume(p));
    stays.push_back(near.is_near_cut(p));
    const bool is_cut =
        version.is_near_cut(p) && std::abs(version.distance(p)) < on_cut && item.field.value(p) > 0;
    mesh.freshness.push_back(is_cut ? 1.0F : 0.0F);
  }
  mesh.openness.assign(mesh.vertices.size(), 1.0F);
  mesh.density.assign(mesh.vertices.size(), 1.0F);
  return mesh;
}

/// Adds a mesh as two parts: the original surface, and the cut surface if there is one.
void add_bone(const DrawMesh& mesh, const std::string& name, std::vector<ScenePart>& parts) {
  ScenePart bone{.name = name, .vertices = mesh.vertices};
  ScenePart cut{.name = name + " cut", .colour = k_cut};
  std::vector<std::int64_t> index_of(mesh.vertices.size(), -1);
  for (std::size_t t = 0; t + 2 < mesh.triangles.size(); t += 3) {
    const float freshness = mesh.freshness[mesh.triangles[t]] + mesh.freshness[mesh.triangles[t + 1]] +
                            mesh.freshness[mesh.triangles[t + 2]];
    for (std::size_t k = t; k < t + 3; ++k) {
      const std::uint32_t v = mesh.triangles[k];
      if (freshness < 2.5F) {
        bone.indices.push_back(v);
        continue;
      }
      if (index_of[v] < 0) {
        index_of[v] = static_cast<std::int64_t>(cut.vertices.size());
        cut.vertices.push_back(mesh.vertices[v]);
      }
      cut.indices.push_back(static_cast<std::uint32_t>(index_of[v]));
    }
  }
  parts.push_back(std::move(bone));
  if (!cut.indices.empty()) parts.push_back(std::move(cut));
}

/// Returns the surface of an overlay at its pose.
DrawMesh surface_of(const sim::Overlay& overlay) {
  std::vector<dvec3> vertices;
  for (const dvec3& v : overlay.surface->vertices())
    vertices.push_back(overlay.placement.world_from_local(v));
  DrawMesh mesh;
  mesh.triangles = overlay.surface->triangles();
  for (const dvec3& normal : fluoroscopy::vertex_normals({vertices, mesh.triangles}))
    mesh.normals.emplace_back(normal);
  mesh.vertices.assign(vertices.begin(), vertices.end());
  mesh.freshness.assign(vertices.size(), 0.0F);
  mesh.openness.assign(vertices.size(), 1.0F);
  mesh.density.assign(vertices.size(), 1.0F);
  return mesh;
}

std::array<float, 3> colour_of(const sim::Overlay& overlay) {
  if (overlay.is_detached) return ScenePart().colour;
  return overlay.matter == volume::Matter::soft_tissue ? k_soft : k_metal;
}

/// Adds bodies and models, with at most `limit` triangles in total, and the lines of tracks. Returns the
/// number of triangles.
std::size_t add_overlays(const sim::Overlays& overlays, std::size_t limit, std::vector<ScenePart>& parts) {
  std::size_t total = 0, added = 0;
  for (const sim::Overlay& overlay : overlays)
    if (overlay.surface) total += overlay.surface->triangles().size() / 3;
  for (const sim::Overlay& overlay : overlays) {
    if (overlay.surface && overlay.kind == sim::Overlay::Kind::object) {
      const std::size_t count = overlay.surface->triangles().size() / 3;
      const std::size_t share = total > limit ? count * limit / total : count;
      DrawMesh mesh = surface_of(overlay);
      mesh = reduced(mesh, share, std::vector<bool>(mesh.vertices.size(), false));
      added += mesh.triangles.size() / 3;
      parts.push_back({.name = overlay.name,
                       .colour = colour_of(overlay),
                       .vertices = std::move(mesh.vertices),
                       .indices = std::move(mesh.triangles)});
    }
    if (overlay.lines.empty() || overlay.holder >= 0) continue;
    ScenePart lines{.name = "lines", .colour = k_line, .are_lines = true};
    for (const auto& line : overlay.lines)
      for (const dvec3& p : line) {
        lines.indices.push_back(static_cast<std::uint32_t>(lines.vertices.size()));
        lines.vertices.emplace_back(overlay.placement.world_from_local(p));
      }
    parts.push_back(std::move(lines));
  }
  return added;
}

std::size_t triangle_count(const std::vector<ScenePart>& parts) {
  std::size_t count = 0;
  for (const ScenePart& part : parts)
    if (!part.are_lines) count += part.indices.size() / 3;
  return count;
}

}  // namespace

ReportModels models_of(const workbench::ReportData& data, std::size_t limit) {
  const sim::Engine& engine = data.engine();
  const haptics::TouchScene& scene = engine.scene();
  std::vector<const haptics::TouchItem*> shapes;
  for (const haptics::TouchItem& item : scene.items)
    if (!item.is_mesh() && &item.field.volume() == scene.base.get()) shapes.push_back(&item);
  std::vector<ScenePart> before, after;
  const std::size_t of_overlays = add_overlays(data.overlays, limit / 4, after);
  for (const haptics::TouchItem* shape : shapes) {
    const std::size_t share = (limit - of_overlays) / shapes.size();
    for (auto* parts : {&before, &after}) {
      std::vector<bool> stays;
      const volume::Version& version = parts == &before ? *engine.uncut() : *engine.version();
      const DrawMesh mesh = shape_mesh(*shape, version, *engine.version(), stays);
      add_bone(reduced(mesh, share, std::move(stays)), workbench::words_of(shape->field.shape().name),
               *parts);
    }
  }
  return {data_tools::glb_of(before), data_tools::glb_of(after), triangle_count(before),
          triangle_count(after)};
}

}  // namespace trephine::cli
