#include "apps/view/bone_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <map>
#include <string>
#include <utility>
#include <vtkActor.h>
#include <vtkArrowSource.h>
#include <vtkCallbackCommand.h>
#include <vtkCamera.h>
#include <vtkCellArray.h>
#include <vtkCommand.h>
#include <vtkDiskSource.h>
#include <vtkLight.h>
#include <vtkLineSource.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkRenderStepsPass.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkSSAOPass.h>
#include <vtkSmartPointer.h>
#include <vtkSphereSource.h>
#include <vtkTransform.h>
#include <vtkTransformPolyDataFilter.h>
#include <vtkTubeFilter.h>

#include "apps/view/instrument_actors.h"
#include "apps/view/picture_text.h"
#include "volume/base/work_counters.h"

namespace trephine::view {

using glm::dvec3;

namespace {
constexpr double k_half_angle = glm::radians(14.0);  // half of the camera's vertical view angle
}  // namespace

struct BoneView::Parts {
  vtkRenderWindow* window;
  vtkNew<vtkRenderer> renderer;  // the bone; if not live, everything
  vtkNew<vtkRenderer> behind;    // live only: whole structures behind translucent bone
  vtkNew<vtkRenderer> front;     // live only: objects on top of the kept picture
  vtkNew<vtkRenderer> letters;   // live only: text and marks, over translucent bone
  std::unique_ptr<StructureLayer> structures;
  std::unique_ptr<BoneLayer> bone;
  std::unique_ptr<OverlayLayer> overlays;
  std::unique_ptr<OverlayLayer> marks;  ///< overlays in front of everything; null if not live
  /// Scenery of a live window: drawn between bone and instruments, so that its depth can be read.
  struct Scenery {
    vtkNew<vtkRenderer> renderer;
    std::unique_ptr<OverlayLayer> layer;
    ScreenDepth depth;
  };
  std::unique_ptr<Scenery> scenery;
  std::unique_ptr<EyeDisplay> eyes;  ///< null: one plain picture
  vtkRenderer* on_top;
  vtkSmartPointer<vtkActor> shaft, grip, proxy, arrow, hip_proxy_line, ring;
  std::vector<ToolPart> drawn;  ///< parts of the tool that the actors in `tool` show
  std::vector<vtkSmartPointer<vtkActor>> tool;
  std::unique_ptr<PictureText> text;
  double text_scale = 1, drawn_text_scale = 1;
  bool is_text_stale = true;            ///< letters, scale bar and labels must be positioned again
  std::uint64_t labelled_revision = 0;  ///< revision of the bone at the last layout of labels
  std::array<double, 18> drawn_view{};  ///< camera and size at the last layout
  vtkNew<vtkLineSource> hip_proxy_source;
  vtkSmartPointer<vtkActor> edge;  ///< line that a guide marks: an edge of bone or a trajectory
  vtkNew<vtkPolyData> edge_line;
  std::vector<dvec3> drawn_edge;             ///< points of `edge_line`
  std::array<unsigned long, 2> observers{};  ///< of the window

  void fit_text();
  void lay_out();
};

BoneView::BoneView(vtkRenderWindow* window, bool is_live, bool has_scenery)
    : parts_(std::make_unique<Parts>()) {
  ++work_counters().gl_contexts;
  Parts& p = *parts_;
  p.window = window;
  window->AddRenderer(p.renderer);
  if (is_live) {
    window->SetMultiSamples(0);  // the kept picture has one sample per pixel
    const auto add = [&](vtkRenderer* renderer) {
      window->AddRenderer(renderer);
      renderer->SetActiveCamera(p.renderer->GetActiveCamera());
      renderer->SetTwoSidedLighting(true);
      renderer->AutomaticLightCreationOff();
    };
    const auto add_over = [&](vtkRenderer* renderer) {
      add(renderer);
      renderer->PreserveColorBufferOn();
      renderer->PreserveDepthBufferOn();
    };
    add(p.behind);
    p.structures = std::make_unique<StructureLayer>(window, p.behind);
    if (has_scenery) {
      p.scenery = std::make_unique<Parts::Scenery>();
      add_over(p.scenery->renderer);
      p.scenery->layer = std::make_unique<OverlayLayer>(p.scenery->renderer);
    }
    add_over(p.front);
    p.front->UseFXAAOn();
    add_over(p.letters);
    vtkNew<vtkCallbackCommand> blend;
    blend->SetClientData(&p);
    blend->SetCallback(
        [](vtkObject*, unsigned long, void* parts, void*) { static_cast<Parts*>(parts)->bone->blend(); });
    p.letters->AddObserver(vtkCommand::StartEvent, blend);
  }
  vtkRenderer* first_over = p.scenery ? p.scenery->renderer.Get() : p.front.Get();
  p.bone = std::make_unique<BoneLayer>(window, p.renderer, first_over, is_live);
  if (p.scenery) {
    // These observers have a lower priority than those of the bone layer: the kept picture is restored first.
    const auto observe = [&](unsigned long event, auto callback) {
      vtkNew<vtkCallbackCommand> command;
      command->SetClientData(&p);
      command->SetCallback(callback);
      p.scenery->renderer->AddObserver(event, command, -1);
    };
    observe(vtkCommand::StartEvent, [](vtkObject*, unsigned long, void* data, void*) {
      auto* parts = static_cast<Parts*>(data);
      parts->scenery->depth.read_before(parts->scenery->renderer, parts->window);
    });
    observe(vtkCommand::EndEvent, [](vtkObject*, unsigned long, void* data, void*) {
      auto* parts = static_cast<Parts*>(data);
      parts->scenery->depth.read_after(parts->scenery->renderer, parts->window);
    });
  }
  vtkRenderer* on_top = p.on_top = is_live ? p.front.Get() : p.renderer.Get();
  vtkRenderer* letters = is_live ? p.letters.Get() : on_top;
  p.overlays = std::make_unique<OverlayLayer>(on_top, letters);
  if (is_live) p.marks = std::make_unique<OverlayLayer>(letters);
  for (vtkRenderer* renderer : {p.renderer.Get(), p.behind.Get()}) {
    renderer->SetBackground(0.10, 0.12, 0.16);
    renderer->SetBackground2(0.30, 0.34, 0.40);
    renderer->GradientBackgroundOn();
  }
  p.renderer->SetTwoSidedLighting(true);

  // A soft key light from the upper left of the viewer, a fill from the right, and a rim light show depth.
  p.renderer->AutomaticLightCreationOff();
  const auto light = [&](double x, double y, double z, double strength, double warmth) {
    vtkNew<vtkLight> l;
    l->SetLightTypeToCameraLight();
    l->SetPosition(x, y, z);
    l->SetIntensity(strength);
    l->SetColor(1.0, 0.98 - 0.05 * warmth, 0.96 - 0.12 * warmth);
    p.renderer->AddLight(l);
    if (is_live) p.front->AddLight(l), p.behind->AddLight(l), p.letters->AddLight(l);
    if (p.scenery) p.scenery->renderer->AddLight(l);
  };
  light(-0.7, 0.9, 1.0, 0.82, 1);
  light(1.0, 0.1, 0.7, 0.32, 0);
  light(0.1, -1.0, 0.3, 0.14, 0);

  if (!is_live) {
    vtkNew<vtkRenderStepsPass> steps;
    vtkNew<vtkSSAOPass> shading;
    shading->SetRadius(9);  // mm; size of hollows to darken
    shading->SetBias(0.35);
    shading->SetKernelSize(96);
    shading->BlurOn();
    shading->SetDelegatePass(steps);
    p.renderer->SetPass(shading);
  }

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
    on_top->AddActor(a);
  }

  p.text = std::make_unique<PictureText>(letters);

  // After a resize the window system draws the window without a call of render(). The camera's angle is
  // fitted first, because the bone layer compares it with the angle of its last picture.
  constexpr float k_first = 1;  // priority
  vtkNew<vtkCallbackCommand> fit_camera, lay_out;
  fit_camera->SetClientData(this), lay_out->SetClientData(&p);
  fit_camera->SetCallback(
      [](vtkObject*, unsigned long, void* view, void*) { static_cast<BoneView*>(view)->fit_camera(); });
  lay_out->SetCallback(
      [](vtkObject*, unsigned long, void* data, void*) { static_cast<Parts*>(data)->lay_out(); });
  p.observers = {window->AddObserver(vtkCommand::StartEvent, fit_camera, k_first),
                 window->AddObserver(vtkCommand::StartEvent, lay_out)};
}

BoneView::~BoneView() {
  for (const unsigned long observer : parts_->observers) parts_->window->RemoveObserver(observer);
  if (parts_->scenery && is_drawable()) parts_->scenery->depth.release();
}

bool BoneView::is_drawable() {
  parts_->window->MakeCurrent();
  return parts_->window->IsCurrent();
}

vtkRenderer* BoneView::renderer() { return parts_->renderer; }
BoneLayer& BoneView::bone() { return *parts_->bone; }
OverlayLayer* BoneView::scenery() { return parts_->scenery ? parts_->scenery->layer.get() : nullptr; }
ScreenDepth* BoneView::screen_depth() { return parts_->scenery ? &parts_->scenery->depth : nullptr; }
void BoneView::set_marks(std::span<const sim::Overlay> marks) {
  if (!parts_->marks) return;
  parts_->marks->show(marks, {});
  // With marks, the renderer clears the depth of the objects that were drawn before, so that they do not hide
  // the marks.
  parts_->letters->SetPreserveDepthBuffer(marks.empty());
}

StructureLayer* BoneView::structures() { return parts_->structures.get(); }

void BoneView::set_bone_opacity(std::optional<double> opacity) {
  Parts& p = *parts_;
  if (!p.structures) return;
  p.structures->set_active(opacity.has_value());
  p.letters->SetUseFXAA(opacity.has_value());
  p.bone->set_opacity(opacity.value_or(1), opacity ? std::function<void()>([&p] { p.structures->restore(); })
                                                   : std::function<void()>());
}

OverlayLayer& BoneView::overlays() { return *parts_->overlays; }
const BoneLayer& BoneView::bone() const { return *parts_->bone; }

void BoneView::show(const StylusState& s) {
  Parts& p = *parts_;
  if (p.drawn != s.tool.parts) {
    for (vtkActor* part : p.tool) p.on_top->RemoveActor(part);
    p.tool.clear();
    p.drawn = s.tool.parts;
    for (const ToolPart& part : p.drawn) {
      vtkNew<vtkPolyDataMapper> mapper;
      mapper->SetInputData(make_revolution(part.profile, part.is_fluted));
      const auto actor =
          make_actor(mapper, part.is_cutting ? dvec3(0.72, 0.75, 0.80) : dvec3(0.60, 0.63, 0.68));
      actor->GetProperty()->SetSpecular(0.55);
      actor->PickableOff();
      p.on_top->AddActor(actor);
      p.tool.push_back(actor);
    }
  }
  for (std::size_t i = 0; i < p.tool.size(); ++i) {
    p.tool[i]->SetVisibility(s.is_visible);
    place(p.tool[i], s.tool_world + s.turn * p.drawn[i].at, s.turn * p.drawn[i].along);
  }
  p.shaft->SetVisibility(s.is_visible);
  const double size = s.tool.radius;
  const dvec3 shaft = s.turn * dvec3(0, 0, 1);
  const dvec3 shaft_begin = s.tool_world + s.tool.shaft_from * shaft;
  // mm by which the shaft starts before `shaft_from`, inside the tool: two coincident faces would flicker.
  constexpr double k_inside = 0.5;
  place(p.shaft, shaft_begin - k_inside * shaft, shaft, 34 + k_inside, s.tool.shaft_radius);
  const double grip_radius = std::max(4.5, 2.6 * s.tool.shaft_radius);
  place(p.grip, shaft_begin + 30.0 * shaft, shaft, 70, grip_radius);
  constexpr double k_tool_length = 100, k_near = 90;  // mm
  p.overlays->labels().set_tool(
      s.is_visible ? std::vector<std::array<dvec3, 2>>{{s.tool_world, shaft_begin + k_tool_length * shaft}}
                   : std::vector<std::array<dvec3, 2>>{});
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
  p.grip->SetVisibility(s.is_visible && !(is_near && is_end_on) && view_height > 0.5 * k_near &&
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

void BoneView::show_text(const std::string& corner, const std::string& foot) {
  parts_->text->show(corner, foot);
}

void BoneView::set_text_scale(double factor) { parts_->text_scale = factor; }

/// Limits the text size in a small picture.
void BoneView::Parts::fit_text() {
  constexpr double k_width = 420;  // pixels
  const double scale = std::min(text_scale, std::max(1.0, window->GetSize()[0] / k_width));
  if (scale == drawn_text_scale) return;
  drawn_text_scale = scale;
  is_text_stale = true;
  text->set_scale(scale);
  overlays->labels().set_text_scale(scale);
  if (marks) marks->labels().set_text_scale(scale);
}

/// Positions letters, scale bar and labels again if the view, the text or the bone changed. Both eyes have
/// them at the same positions, which are those of the middle between the eyes.
void BoneView::Parts::lay_out() {
  if (eyes && eyes->is_drawing_eye()) return;
  fit_text();
  std::array<double, 18> view;
  vtkCamera* camera = renderer->GetActiveCamera();
  std::copy_n(camera->GetModelViewTransformMatrix()->GetData(), 16, view.begin());
  view[15] = camera->GetViewAngle();
  view[16] = window->GetSize()[0], view[17] = window->GetSize()[1];
  bool has_changed = std::exchange(drawn_view, view) != view;
  has_changed |= std::exchange(is_text_stale, false);
  if (has_changed) text->update();
  // Redrawn bone may hide labels, or no longer hide them.
  const std::uint64_t revision = bone->revision();
  has_changed |= std::exchange(labelled_revision, revision) != revision;
  // Names avoid the lines in the corner, and the labels of marks and of overlays in front of everything.
  std::vector<LabelLayer::Box> occupied{{text->corner_box()[0], text->corner_box()[1]}};
  if (marks && (has_changed || marks->labels().is_stale())) {
    marks->labels().lay_out(occupied);
    has_changed = true;
  }
  if (!has_changed && !overlays->labels().is_stale()) return;
  if (marks)
    for (const LabelLayer::Box& box : marks->labels().boxes()) occupied.push_back(box);
  overlays->labels().lay_out(occupied);
}

std::vector<LabelLayer::Box> BoneView::label_boxes() const {
  std::vector<LabelLayer::Box> boxes = parts_->overlays->labels().boxes();
  if (!parts_->marks) return boxes;
  const std::vector<LabelLayer::Box> more = parts_->marks->labels().boxes();
  boxes.insert(boxes.end(), more.begin(), more.end());
  return boxes;
}

double BoneView::distance_of(const dvec3& low, const dvec3& high) {
  // The longest side must fit into the picture, with a margin because the nearer half appears larger.
  const dvec3 size = high - low;
  const double tallest = 1.12 * std::max({size.x, size.y, size.z});
  return std::max(0.86 * glm::length(size), tallest) / (2 * std::tan(k_half_angle));
}

void BoneView::fit_camera() {
  if (parts_->eyes && parts_->eyes->is_drawing_eye()) return;
  constexpr double k_narrow = 0.9;  // width over height below which the width determines the angle
  const int* size = parts_->window->GetSize();
  const double aspect = std::max(1, size[0]) / static_cast<double>(std::max(1, size[1]));
  const double angle = glm::degrees(2 * std::atan(std::tan(k_half_angle) * std::max(1.0, k_narrow / aspect)));
  vtkCamera* camera = parts_->renderer->GetActiveCamera();
  if (camera->GetViewAngle() == angle) return;
  camera->SetViewAngle(angle);
  parts_->renderer->ResetCameraClippingRange();
}

void BoneView::aim_camera(const dvec3& target, const dvec3& from, const dvec3& up, double distance) {
  vtkCamera* camera = parts_->renderer->GetActiveCamera();
  const dvec3 position = target + distance * glm::normalize(from);
  camera->SetFocalPoint(target.x, target.y, target.z);
  camera->SetPosition(position.x, position.y, position.z);
  // If the view is parallel to `up`, as straight from above, the patient's front is upward. If `up` itself is
  // along y, the head is upward.
  const bool is_upright = std::abs(glm::dot(up, glm::normalize(from))) < 0.99 * glm::length(up);
  const dvec3 upward = is_upright ? up : std::abs(up.y) < 0.5 ? dvec3(0, -1, 0) : dvec3(0, 0, 1);
  camera->SetViewUp(upward.x, upward.y, upward.z);
  fit_camera();
  parts_->renderer->ResetCameraClippingRange();
}

void BoneView::bounds(dvec3& low, dvec3& high) const {
  parts_->bone->bounds(low, high);
  if (low.x > high.x) low = dvec3(-50), high = dvec3(50);
}

void BoneView::look_from(char side, const dvec3& low, const dvec3& high) {
  // LPS: +x left, +y back, +z up.
  dvec3 from(0.55, -0.75, 0.38), up(0, 0, 1);
  switch (side) {
    case 'A':
      from = {0, -1, 0};
      break;
    case 'P':
      from = {0, 1, 0};
      break;
    case 'L':
      from = {1, 0, 0};
      break;
    case 'R':
      from = {-1, 0, 0};
      break;
    case 'S':
      from = {0, 0, 1}, up = {0, -1, 0};
      break;
    case 'I':
      from = {0, 0, -1}, up = {0, -1, 0};
      break;
    default:
      break;
  }
  aim_camera(0.5 * (low + high), from, up, distance_of(low, high));
}

bool BoneView::render() {
  Parts& p = *parts_;
  p.lay_out();
  const auto draw = [&p] { return p.bone->render(p.scenery != nullptr); };
  return p.eyes ? p.eyes->render(*p.bone, draw) : draw();
}

void BoneView::set_display(const DisplayMode& mode, std::shared_ptr<HeadTracker> tracker,
                           std::shared_ptr<Hmd> hmd) {
  Parts& p = *parts_;
  if (!p.structures) return;
  p.eyes.reset();
  if (!mode.is_plain() || tracker)
    p.eyes = std::make_unique<EyeDisplay>(p.window, p.renderer, p.letters, mode, std::move(tracker),
                                          std::move(hmd));
  p.is_text_stale = true;
  p.bone->begin_new_picture();
}

EyeDisplay* BoneView::eyes() const { return parts_->eyes.get(); }

}  // namespace trephine::view
