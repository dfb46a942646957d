#include "apps/view/stylus_actors.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <vtkActor.h>
#include <vtkArrowSource.h>
#include <vtkCamera.h>
#include <vtkCellArray.h>
#include <vtkDiskSource.h>
#include <vtkLineSource.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>
#include <vtkSphereSource.h>
#include <vtkTransform.h>
#include <vtkTransformPolyDataFilter.h>
#include <vtkTubeFilter.h>

#include "apps/view/instrument_actors.h"
#include "haptics/device/pose_path.h"

namespace trephine::view {

using glm::dvec3;

struct StylusActors::Parts {
  vtkRenderer* renderer;
  vtkSmartPointer<vtkActor> shaft, grip, proxy, arrow, hip_proxy_line, ring;
  std::vector<ToolPart> drawn;  ///< parts of the tool that the actors in `tool` show
  std::vector<vtkSmartPointer<vtkActor>> tool;
  std::shared_ptr<const haptics::MeshTree> drawn_mesh;  ///< that `mesh` shows
  vtkSmartPointer<vtkActor> mesh, hand_mesh;  ///< at the pose of the tool; as wireframe, at that of the hand
  vtkNew<vtkLineSource> hip_proxy_source;
  vtkSmartPointer<vtkActor> edge;  ///< line that a guide marks: an edge of bone or a trajectory
  vtkNew<vtkPolyData> edge_line;
  std::vector<dvec3> drawn_edge;  ///< points of `edge_line`
};

StylusActors::StylusActors(vtkRenderer* renderer) : parts_(std::make_unique<Parts>()) {
  Parts& p = *parts_;
  p.renderer = renderer;
  vtkNew<vtkSphereSource> dot;
  dot->SetThetaResolution(48), dot->SetPhiResolution(32), dot->SetRadius(1);
  vtkNew<vtkLineSource> axis;
  axis->SetPoint1(0, 0, 0);
  axis->SetPoint2(1, 0, 0);
  vtkNew<vtkTubeFilter> rod;
  rod->SetInputConnection(axis->GetOutputPort());
  rod->SetRadius(1);
  rod->SetNumberOfSides(32);
  rod->CappingOn();
  vtkNew<vtkArrowSource> arrow;
  arrow->SetTipResolution(32);
  arrow->SetShaftResolution(32);
  p.shaft = make_actor(rod->GetOutputPort(), 0.78, 0.80, 0.84);
  p.grip = make_actor(rod->GetOutputPort(), 0.26, 0.47, 0.74);
  p.proxy = make_actor(dot->GetOutputPort(), 0.98, 0.80, 0.10);
  p.arrow = make_actor(arrow->GetOutputPort(), 0.10, 0.62, 0.90);
  p.hip_proxy_line = make_actor(p.hip_proxy_source->GetOutputPort(), 0.98, 0.80, 0.10);
  p.hip_proxy_line->GetProperty()->SetLineWidth(2);
  // Turn the disk's axis from z to +x, like the other sources.
  vtkNew<vtkDiskSource> disk;
  disk->SetInnerRadius(0.82);
  disk->SetOuterRadius(1);
  disk->SetCircumferentialResolution(48);
  vtkNew<vtkTransform> turn;
  turn->RotateY(90);
  vtkNew<vtkTransformPolyDataFilter> turned_disk;
  turned_disk->SetInputConnection(disk->GetOutputPort());
  turned_disk->SetTransform(turn);
  p.ring = make_actor(turned_disk->GetOutputPort(), 0.98, 0.80, 0.10);
  p.ring->GetProperty()->LightingOff();
  vtkNew<vtkTubeFilter> band;
  band->SetInputData(p.edge_line);
  band->SetRadius(0.35);
  band->SetNumberOfSides(12);
  band->CappingOn();
  p.edge = make_actor(band->GetOutputPort(), 0.25, 0.86, 0.38);
  p.edge->GetProperty()->LightingOff();
  for (vtkActor* a : {p.arrow.Get(), p.grip.Get(), p.shaft.Get()}) a->GetProperty()->SetAmbient(0.35);
  p.proxy->GetProperty()->SetAmbient(0.4);
  for (vtkActor* a : {p.shaft.Get(), p.grip.Get(), p.proxy.Get(), p.arrow.Get(), p.hip_proxy_line.Get(),
                      p.ring.Get(), p.edge.Get()}) {
    a->VisibilityOff();
    a->PickableOff();
    p.renderer->AddActor(a);
  }
}

StylusActors::~StylusActors() = default;

void StylusActors::show(const StylusState& s) {
  Parts& p = *parts_;
  if (p.drawn != s.tool.parts) {
    for (vtkActor* part : p.tool) p.renderer->RemoveActor(part);
    p.tool.clear();
    p.drawn = s.tool.parts;
    for (const ToolPart& part : p.drawn) {
      vtkNew<vtkPolyDataMapper> mapper;
      mapper->SetInputData(make_revolution(part.profile, part.is_fluted));
      const auto actor =
          make_actor(mapper, part.is_cutting ? dvec3(0.72, 0.75, 0.80) : dvec3(0.60, 0.63, 0.68));
      actor->GetProperty()->SetSpecular(0.55);
      actor->PickableOff();
      p.renderer->AddActor(actor);
      p.tool.push_back(actor);
    }
  }
  for (std::size_t i = 0; i < p.tool.size(); ++i) {
    p.tool[i]->SetVisibility(s.is_visible);
    place(p.tool[i], s.tool_world + s.turn * p.drawn[i].at, s.turn * p.drawn[i].along);
  }
  if (p.drawn_mesh != s.tool.mesh) {
    if (p.mesh) p.renderer->RemoveActor(p.mesh), p.renderer->RemoveActor(p.hand_mesh);
    p.mesh = p.hand_mesh = nullptr;
    p.drawn_mesh = s.tool.mesh;
    if (p.drawn_mesh) {
      vtkNew<vtkPolyDataMapper> mapper;
      mapper->SetInputData(make_mesh(*p.drawn_mesh));
      p.mesh = make_actor(mapper, dvec3(0.45, 0.60, 0.78));
      p.mesh->GetProperty()->SetSpecular(0.35);
      p.hand_mesh = make_actor(mapper, dvec3(0.95, 0.96, 1.0));
      p.hand_mesh->GetProperty()->SetRepresentationToWireframe();
      p.hand_mesh->GetProperty()->SetOpacity(0.25);
      p.hand_mesh->GetProperty()->LightingOff();
      for (vtkActor* actor : {p.mesh.Get(), p.hand_mesh.Get()})
        actor->PickableOff(), p.renderer->AddActor(actor);
    }
  }
  if (p.mesh) {
    p.mesh->SetVisibility(s.is_visible);
    place(p.mesh, haptics::Placement{s.tool_world, s.turn});
    // A wireframe shows the pose of the hand while contact keeps the tool from it.
    constexpr double k_apart = 1, k_turned = 0.05;  // mm; about radians
    const bool is_apart = glm::length(s.tool_world - s.hip_world) > k_apart ||
                          glm::length(haptics::turn_between(s.hand_turn, s.turn)) > k_turned;
    p.hand_mesh->SetVisibility(s.is_visible && s.has_contact && is_apart);
    place(p.hand_mesh, haptics::Placement{s.hip_world, s.hand_turn});
  }
  const bool has_shaft = s.is_visible && s.tool.has_shaft;
  p.shaft->SetVisibility(has_shaft);
  const double size = s.tool.radius;
  const dvec3 shaft = s.turn * dvec3(0, 0, 1);
  const dvec3 shaft_begin = s.tool_world + s.tool.shaft_from * shaft;
  // mm by which the shaft starts before `shaft_from`, inside the tool: two coincident faces would flicker.
  constexpr double k_inside = 0.5;
  place(p.shaft, shaft_begin - k_inside * shaft, shaft, 34 + k_inside, s.tool.shaft_radius);
  const double grip_radius = std::max(4.5, 2.6 * s.tool.shaft_radius);
  place(p.grip, shaft_begin + 30.0 * shaft, shaft, 70, grip_radius);
  constexpr double k_tool_length = 100, k_near = 90;  // mm
  axis_.reset();
  if (s.is_visible) axis_ = {s.tool_world, shaft_begin + k_tool_length * shaft};
  // A handle seen end-on or from nearby hides the tool's work: draw it translucent, or not at all.
  vtkCamera* camera = p.renderer->GetActiveCamera();
  const double* position = camera->GetPosition();
  const dvec3 viewer = dvec3(position[0], position[1], position[2]) - s.tool_world;
  // Height of the picture at the tool, mm.
  const double view_height = 2 * glm::length(viewer) * std::tan(0.5 * glm::radians(camera->GetViewAngle()));
  const bool is_end_on = glm::dot(shaft, viewer) > 0.93 * glm::length(viewer), is_near = view_height < k_near;
  // Width of the grip's near end as a share of the picture's height there.
  const dvec3 grip_end = shaft_begin + k_tool_length * shaft - s.tool_world;
  const double grip_depth = std::max(1.0, glm::dot(viewer - grip_end, glm::normalize(viewer)));
  const double grip_share = 2 * grip_radius * glm::length(viewer) / (grip_depth * view_height);
  constexpr double k_wide = 0.06, k_widest = 0.12;
  p.grip->SetVisibility(has_shaft && !(is_near && is_end_on) && view_height > 0.5 * k_near &&
                        grip_share < k_widest);
  p.grip->GetProperty()->SetOpacity(is_near || grip_share > k_wide ? 0.15 : is_end_on ? 0.3 : 1);
  p.shaft->GetProperty()->SetOpacity(is_end_on ? 0.35 : 1);
  const bool is_touching = s.is_visible && s.has_contact;
  for (vtkActor* a : {p.proxy.Get(), p.hip_proxy_line.Get()}) a->SetVisibility(is_touching);
  place(p.proxy, s.proxy_world, {1, 0, 0}, 0.7, 0.7);
  p.hip_proxy_source->SetPoint1(s.proxy_world.x, s.proxy_world.y, s.proxy_world.z);
  p.hip_proxy_source->SetPoint2(s.hip_world.x, s.hip_world.y, s.hip_world.z);
  p.ring->SetVisibility(s.is_visible && s.has_ring);
  const double height = glm::length(s.tool_world - s.ring_world);
  const double ring_radius = 1.15 * size + 0.25 * std::max(0.0, height - size);
  place(p.ring, s.ring_world + 0.4 * s.ring_normal_world, s.ring_normal_world, ring_radius, ring_radius);
  p.edge->SetVisibility(s.edge.size() > 1);
  if (s.edge.size() > 1 && s.edge != p.drawn_edge) {
    p.drawn_edge = s.edge;
    vtkNew<vtkPoints> points;
    vtkNew<vtkCellArray> lines;
    lines->InsertNextCell(static_cast<int>(s.edge.size()));
    for (const dvec3& at : s.edge) lines->InsertCellPoint(points->InsertNextPoint(at.x, at.y, at.z));
    p.edge_line->SetPoints(points);
    p.edge_line->SetLines(lines);
  }
  const double force = glm::length(s.force_world);
  p.arrow->SetVisibility(is_touching && force > 0.02);
  // 12 mm per newton, starting at the side of the burr, so that the burr does not hide the arrow.
  const dvec3 sideways = glm::length(glm::cross(shaft, s.force_world)) > 1e-9
                             ? glm::normalize(glm::cross(shaft, s.force_world))
                             : glm::normalize(glm::cross(shaft, dvec3(0.3, 1, 0.2)));
  // Seen from nearby, the arrow becomes shorter, so that its size in the picture does not grow.
  const double zoom = std::min(1.0, view_height / 180);
  place(p.arrow, s.proxy_world + (size + 2.5 * zoom) * sideways, s.force_world,
        zoom * std::clamp(12 * force, 3.0, 60.0), zoom * 11);
}

}  // namespace trephine::view
