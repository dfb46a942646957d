#include "apps/view/bone_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <map>
#include <string>
#include <utility>
#include <vtkCallbackCommand.h>
#include <vtkCamera.h>
#include <vtkCommand.h>
#include <vtkLight.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>
#include <vtkRenderStepsPass.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkSSAOPass.h>
#include <vtkSmartPointer.h>

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
  std::vector<std::unique_ptr<StylusActors>> styluses;  ///< by hand
  std::unique_ptr<PictureText> text;
  double text_scale = 1, drawn_text_scale = 1;
  bool is_text_stale = true;                 ///< letters, scale bar and labels must be positioned again
  std::uint64_t labelled_revision = 0;       ///< revision of the bone at the last layout of labels
  std::array<double, 18> drawn_view{};       ///< camera and size at the last layout
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

void BoneView::show(const StylusState& stylus, std::size_t hand) {
  Parts& p = *parts_;
  while (p.styluses.size() <= hand) p.styluses.push_back(std::make_unique<StylusActors>(p.on_top));
  p.styluses[hand]->show(stylus);
  std::vector<std::array<dvec3, 2>> axes;
  for (const auto& one : p.styluses)
    if (one->axis()) axes.push_back(*one->axis());
  p.overlays->labels().set_tool(std::move(axes));
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
  imaging::LabelLayout::Obstacles occupied{{{text->corner_box()[0], text->corner_box()[1]}}, {}};
  if (marks && (has_changed || marks->labels().is_stale())) {
    marks->labels().lay_out(occupied);
    has_changed = true;
  }
  if (!has_changed && !overlays->labels().is_stale()) return;
  if (marks) {
    occupied.add(marks->labels().marks());
    occupied.add({marks->labels().boxes(), {}});
  }
  overlays->labels().lay_out(occupied);
}

std::vector<LabelLayer::Box> BoneView::label_boxes() const {
  std::vector<LabelLayer::Box> boxes;
  for (OverlayLayer* layer : {parts_->overlays.get(), parts_->marks.get()}) {
    if (layer == nullptr) continue;
    for (const std::vector<LabelLayer::Box>& more : {layer->labels().boxes(), layer->labels().marks().boxes})
      boxes.insert(boxes.end(), more.begin(), more.end());
  }
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
