#include "apps/view/overlay_layer.h"

#include <algorithm>
#include <array>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <map>
#include <utility>
#include <vtkActor.h>
#include <vtkCellArray.h>
#include <vtkDoubleArray.h>
#include <vtkFloatArray.h>
#include <vtkNew.h>
#include <vtkPlane.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>
#include <vtkSphereSource.h>
#include <vtkUnsignedCharArray.h>

#include "apps/view/bone_mesh.h"
#include "apps/view/instrument_actors.h"

namespace trephine::view {

using glm::dvec3;

namespace {

constexpr double k_handle_radius = 1.3;  // mm

struct Colour {
  double r, g, b;
};
Colour colour_of(volume::Matter matter) {
  switch (matter) {
    case volume::Matter::bone:
      return {0.93, 0.86, 0.74};
    case volume::Matter::soft_tissue:
      return {0.90, 0.72, 0.42};
    case volume::Matter::steel:
      return {0.62, 0.65, 0.70};
    case volume::Matter::scenery:
      return {0.62, 0.60, 0.66};
    case volume::Matter::titanium:
      break;
  }
  return {0.72, 0.75, 0.80};
}
Colour colour_of(const sim::Overlay& overlay) {
  switch (overlay.kind) {
    case sim::Overlay::Kind::object:
      if (overlay.matter == volume::Matter::soft_tissue)
        if (const std::optional<dvec3> colour = usual_structure_colour(overlay.name))
          return {colour->r, colour->g, colour->b};
      return colour_of(overlay.matter);
    case sim::Overlay::Kind::warning:
      return {0.96, 0.78, 0.20};
    case sim::Overlay::Kind::injury:
      return {0.48, 0.03, 0.06};
    case sim::Overlay::Kind::scenery:
      return {0.62, 0.60, 0.66};
    case sim::Overlay::Kind::plan:
    case sim::Overlay::Kind::measure:
      break;
  }
  return {0.35, 0.80, 0.95};
}

ObjectGroup group_of(const sim::Overlay& overlay) {
  if (overlay.is_detached) return ObjectGroup::loose_bone;
  const bool is_metal =
      overlay.kind == sim::Overlay::Kind::object &&
      (overlay.matter == volume::Matter::titanium || overlay.matter == volume::Matter::steel);
  return is_metal ? ObjectGroup::implants : ObjectGroup::models;
}

vtkSmartPointer<vtkPolyData> make_surface(
    const haptics::MeshTree& tree,
    const std::function<OverlayLayer::Vertex(const dvec3&, const dvec3&)>& shade) {
  std::vector<dvec3> normals(tree.vertices().size(), dvec3(0));
  vtkNew<vtkPoints> points;
  vtkNew<vtkCellArray> triangles;
  for (const dvec3& p : tree.vertices()) points->InsertNextPoint(p.x, p.y, p.z);
  const std::vector<std::uint32_t>& corners = tree.triangles();
  for (std::size_t t = 0; t + 2 < corners.size(); t += 3) {
    const std::array<vtkIdType, 3> ids{corners[t], corners[t + 1], corners[t + 2]};
    triangles->InsertNextCell(3, ids.data());
    const dvec3 &a = tree.vertices()[corners[t]], &b = tree.vertices()[corners[t + 1]],
                &c = tree.vertices()[corners[t + 2]];
    const dvec3 doubled = glm::cross(b - a, c - a);  // length: twice the triangle's area
    for (std::size_t i = 0; i < 3; ++i) normals[corners[t + i]] += doubled;
  }
  vtkNew<vtkFloatArray> directions;
  directions->SetNumberOfComponents(3);
  vtkNew<vtkUnsignedCharArray> colours;
  colours->SetNumberOfComponents(3);
  for (std::size_t i = 0; i < normals.size(); ++i) {
    const dvec3& n = normals[i];
    OverlayLayer::Vertex vertex;
    if (glm::length(n) > 0) vertex.normal = glm::normalize(n);
    if (shade) vertex = shade(tree.vertices()[i], vertex.normal);
    directions->InsertNextTuple3(vertex.normal.x, vertex.normal.y, vertex.normal.z);
    const dvec3 colour = 255.0 * vertex.colour;
    if (shade) colours->InsertNextTuple3(colour.x, colour.y, colour.z);
  }
  auto data = vtkSmartPointer<vtkPolyData>::New();
  data->SetPoints(points);
  data->SetPolys(triangles);
  data->GetPointData()->SetNormals(directions);
  if (shade) data->GetPointData()->SetScalars(colours);
  return data;
}

vtkSmartPointer<vtkPolyData> make_lines(const std::vector<std::array<dvec3, 2>>& lines) {
  vtkNew<vtkPoints> points;
  vtkNew<vtkCellArray> cells;
  for (const auto& line : lines) {
    std::array<vtkIdType, 2> ids{};
    for (std::size_t end = 0; end < 2; ++end)
      ids[end] = points->InsertNextPoint(line[end].x, line[end].y, line[end].z);
    cells->InsertNextCell(2, ids.data());
  }
  auto data = vtkSmartPointer<vtkPolyData>::New();
  data->SetPoints(points);
  data->SetLines(cells);
  return data;
}

vtkSmartPointer<vtkPolyData> make_triangles(const std::vector<std::array<dvec3, 3>>& triangles) {
  vtkNew<vtkPoints> points;
  vtkNew<vtkCellArray> cells;
  for (const auto& triangle : triangles) {
    std::array<vtkIdType, 3> ids{};
    for (std::size_t c = 0; c < 3; ++c)
      ids[c] = points->InsertNextPoint(triangle[c].x, triangle[c].y, triangle[c].z);
    cells->InsertNextCell(3, ids.data());
  }
  auto data = vtkSmartPointer<vtkPolyData>::New();
  data->SetPoints(points);
  data->SetPolys(cells);
  return data;
}

vtkSmartPointer<vtkActor> make_actor(vtkPolyData* data, const Colour& colour) {
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(data);
  mapper->ScalarVisibilityOff();
  auto actor = vtkSmartPointer<vtkActor>::New();
  actor->SetMapper(mapper);
  actor->GetProperty()->SetColor(colour.r, colour.g, colour.b);
  actor->GetProperty()->SetSpecular(0.15);
  actor->GetProperty()->SetSpecularPower(25);
  light_reversed_triangles(actor);
  actor->PickableOff();
  return actor;
}

}  // namespace

struct OverlayLayer::Parts {
  Parts(vtkRenderer* drawn_in, vtkRenderer* letters) : renderer(drawn_in), labels(letters) {}

  vtkRenderer* renderer;
  /// Actor of a shown surface; owning the tree prevents reuse of its address.
  struct Surface {
    std::shared_ptr<const haptics::MeshTree> tree;
    vtkSmartPointer<vtkActor> actor;
    ObjectGroup group = ObjectGroup::models;
    bool is_shown = false;
  };
  std::array<double, k_object_groups> opacities{1, 1, 1};
  vtkNew<vtkPlane> clip;
  bool is_clipped = false;

  void apply_opacity(const Surface& surface) const {
    const double opacity = opacities[static_cast<std::size_t>(surface.group)];
    surface.actor->SetVisibility(opacity > 0);
    surface.actor->GetProperty()->SetOpacity(opacity);
    // The far side of a translucent object would be visible as a second surface.
    surface.actor->GetProperty()->SetBackfaceCulling(opacity < 1);
  }
  void apply_clip(const Surface& surface) const {
    vtkMapper* mapper = surface.actor->GetMapper();
    mapper->RemoveAllClippingPlanes();
    if (is_clipped && surface.group != ObjectGroup::implants) mapper->AddClippingPlane(clip);
  }

  std::map<const haptics::MeshTree*, Surface> surfaces;
  /// Other actors; each show() creates them again, because they are few.
  std::vector<vtkSmartPointer<vtkProp>> others;
  LabelLayer labels;
};

OverlayLayer::OverlayLayer(vtkRenderer* renderer, vtkRenderer* letters)
    : parts_(std::make_unique<Parts>(renderer, letters != nullptr ? letters : renderer)) {}
OverlayLayer::~OverlayLayer() = default;

std::size_t OverlayLayer::size() const noexcept {
  return parts_->surfaces.size() + parts_->others.size() + parts_->labels.size();
}
LabelLayer& OverlayLayer::labels() noexcept { return parts_->labels; }

void OverlayLayer::set_opacity(ObjectGroup group, double opacity) {
  parts_->opacities[static_cast<std::size_t>(group)] = opacity;
  for (const auto& [tree, surface] : parts_->surfaces) parts_->apply_opacity(surface);
}

void OverlayLayer::set_clip(const dvec3& origin, const dvec3& normal) {
  Parts& p = *parts_;
  const bool is_clipped = normal != dvec3(0);
  if (is_clipped) {
    p.clip->SetOrigin(origin.x, origin.y, origin.z);
    p.clip->SetNormal(normal.x, normal.y, normal.z);
  }
  if (std::exchange(p.is_clipped, is_clipped) == is_clipped) return;
  for (const auto& [tree, surface] : p.surfaces) p.apply_clip(surface);
}

void OverlayLayer::show(std::span<const sim::Overlay> overlays, std::span<const haptics::Placement> hands) {
  Parts& p = *parts_;
  const auto add = [&](vtkProp* prop) {
    p.renderer->AddViewProp(prop);
    p.others.push_back(prop);
  };
  for (const auto& prop : p.others) p.renderer->RemoveViewProp(prop);
  p.others.clear();
  p.labels.clear();
  for (auto& [tree, surface] : p.surfaces) surface.is_shown = false;
  for (const sim::Overlay& overlay : overlays) {
    const bool is_held = overlay.holder >= 0 && overlay.holder < static_cast<int>(hands.size());
    const haptics::Placement placement =
        is_held ? hands[static_cast<std::size_t>(overlay.holder)] * overlay.grip : overlay.placement;
    const Colour colour = colour_of(overlay);
    if (overlay.surface) {
      Parts::Surface& surface = p.surfaces[overlay.surface.get()];
      if (!surface.actor) {
        const bool is_coloured = shade_bone && overlay.is_detached;
        surface = {overlay.surface,
                   make_actor(make_surface(*overlay.surface, is_coloured ? shade_bone : nullptr), colour)};
        if (is_coloured) surface.actor->GetMapper()->ScalarVisibilityOn();
        surface.group = group_of(overlay);
        p.apply_opacity(surface);
        p.apply_clip(surface);
        p.renderer->AddActor(surface.actor);
      }
      surface.is_shown = true;
      place(surface.actor, placement);
    }
    if (!overlay.lines.empty()) {
      const auto actor = make_actor(make_lines(overlay.lines), colour);
      actor->GetProperty()->LightingOff();
      actor->GetProperty()->SetLineWidth(2.5);
      place(actor, placement);
      add(actor);
      if (overlay.kind == sim::Overlay::Kind::plan || overlay.kind == sim::Overlay::Kind::measure) {
        auto lines = overlay.lines;
        for (auto& line : lines)
          for (dvec3& end : line) end = placement.world_from_local(end);
        p.labels.add_marks(lines);
      }
    }
    if (!overlay.translucent_triangles.empty()) {
      const auto actor = make_actor(make_triangles(overlay.translucent_triangles), colour);
      actor->GetProperty()->LightingOff();
      actor->GetProperty()->SetOpacity(0.28);
      place(actor, placement);
      add(actor);
    }
    for (const sim::Overlay::Handle& handle : overlay.handles) {
      vtkNew<vtkSphereSource> ball;
      ball->SetRadius(k_handle_radius);
      ball->SetCenter(handle.at.x, handle.at.y, handle.at.z);
      ball->SetThetaResolution(24);
      ball->SetPhiResolution(16);
      ball->Update();
      add(make_actor(ball->GetOutput(), colour));
    }
    for (const sim::Overlay::Label& label : overlay.labels) {
      const dvec3 world = placement.world_from_local(label.at);
      const bool is_name = overlay.handles.empty() && overlay.kind != sim::Overlay::Kind::warning &&
                           overlay.kind != sim::Overlay::Kind::measure;
      p.labels.add(world, label.text, {colour.r, colour.g, colour.b}, is_name);
    }
  }
  for (auto it = p.surfaces.begin(); it != p.surfaces.end();) {
    if (!it->second.is_shown) p.renderer->RemoveActor(it->second.actor);
    it = it->second.is_shown ? std::next(it) : p.surfaces.erase(it);
  }
}

}  // namespace trephine::view
