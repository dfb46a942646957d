#include "apps/view/view_window.h"

#include <algorithm>
#include <cctype>
#include <chrono>
#include <cstdio>
#include <functional>
#include <glm/geometric.hpp>
#include <vtkCallbackCommand.h>
#include <vtkCamera.h>
#include <vtkInteractorStyleTrackballCamera.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkRenderWindow.h>
#include <vtkRenderWindowInteractor.h>
#include <vtkRenderer.h>

#include "apps/view/mouse_device.h"
#include "apps/view/render_window.h"
#include "haptics/implicit_proxy.h"
#include "sim/live_session.h"
#include "volume/traversal.h"

namespace trephine::view {

using glm::dvec3;
using volume::Error;
using volume::Result;
using Clock = std::chrono::steady_clock;

namespace {

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

struct Ray {
  dvec3 origin, direction;  // world, unit direction
};

/// Where the ray meets the solid of any shape, mm along it; negative when it does not.
double distance_to_solid(const haptics::TouchScene& scene, const volume::Version& version, const Ray& ray) {
  constexpr double k_far = 5000;
  const volume::Frame& frame = scene.base->frame;
  double hit = -1;
  volume::traverse(frame.volume_from_world(ray.origin),
                   frame.volume_from_world(ray.origin + k_far * ray.direction),
                   {glm::ivec3(0), scene.base->size - 1}, [&](const volume::VoxelVisit& v) {
                     for (const haptics::TouchShape& shape : scene.shapes)
                       if (shape.bits->is_solid(v.voxel) && version.is_kept(v.voxel)) {
                         hit = k_far * v.t_enter;
                         return false;
                       }
                     return true;
                   });
  return hit;
}

/// Mouse and keys, turned into calls; VTK's own key bindings stay out.
class StylusStyle : public vtkInteractorStyleTrackballCamera {
 public:
  static StylusStyle* New();
  vtkTypeMacro(StylusStyle, vtkInteractorStyleTrackballCamera)

      std::function<void(bool)> on_press;
  std::function<void(int)> on_wheel;
  std::function<void(const std::string&, bool)> on_key;

  void OnLeftButtonDown() override { on_press(true); }
  void OnLeftButtonUp() override { on_press(false); }
  void OnRightButtonDown() override { pick_renderer(), StartRotate(); }
  void OnRightButtonUp() override { EndRotate(); }
  void OnMiddleButtonDown() override { pick_renderer(), StartPan(); }
  void OnMiddleButtonUp() override { EndPan(); }
  void OnMouseWheelForward() override { wheel(1); }
  void OnMouseWheelBackward() override { wheel(-1); }
  void OnKeyPress() override {
    on_key(Interactor->GetKeySym() ? Interactor->GetKeySym() : "", Interactor->GetControlKey() != 0);
  }
  void OnChar() override {}

 private:
  void pick_renderer() {
    FindPokedRenderer(Interactor->GetEventPosition()[0], Interactor->GetEventPosition()[1]);
  }
  void wheel(int way) {
    if (!Interactor->GetControlKey()) return on_wheel(way);
    way > 0 ? Superclass::OnMouseWheelForward() : Superclass::OnMouseWheelBackward();
  }
};
vtkStandardNewMacro(StylusStyle)

    /// Everything that lives while a window is open.
    class Window {
 public:
  Window(const haptics::TouchScene& scene, const WindowOptions& options, vtkRenderWindow* target)
      : scene_(scene),
        options_(options),
        target_(target),
        view_(target, options.is_offscreen),
        worker_(scene, 0, options.is_offscreen ? 2 : 1) {}

  /// The first picture: everything meshed and in view.
  void fill(const std::shared_ptr<const volume::Version>& version) {
    worker_.request_all(version);
    worker_.finish();
    for (const ChunkMesh& mesh : worker_.take()) view_.show(mesh);
    view_.look_from(0);
  }

  Result<WindowReport> draw_once(Clock::time_point start) {
    const auto version =
        options_.version ? options_.version : std::make_shared<const volume::Version>(scene_.base);
    fill(version);
    // The stylus rests on what is in the middle of the picture.
    const Ray ray = ray_at(0.5, 0.5);
    if (const double hit = distance_to_solid(scene_, *version, ray); hit >= 0) {
      StylusLook look;
      look.has_contact = true;
      look.proxy_world = look.hip_world = ray.origin + hit * ray.direction;
      look.shaft_direction = -ray.direction;
      orient(look, *version);
      look.burr_radius = options_.burr.radius;
      look.burr_centre_world = look.proxy_world + look.burr_radius * look.shaft_direction;
      view_.show(look);
    }
    view_.show_text(options_.title, "");
    view_.render();
    WindowReport report;
    report.frames = 1;
    report.triangles = view_.triangle_count();
    report.first_frame_seconds = seconds_since(start);
    if (!options_.screenshot.empty())
      if (volume::Status error = write_png(target_, options_.screenshot)) return *error;
    return report;
  }

  Result<WindowReport> run(Clock::time_point start) {
    haptics::ImplicitProxy method;
    if (volume::Status error = method.prepare(scene_)) return *error;
    drilling::Burr own_burr(options_.burr);
    drilling::Burr* burr = options_.start ? options_.start->burr : &own_burr;
    sim::EditSession edits =
        options_.start ? options_.start->edits : sim::EditSession(scene_, burr, 1 / options_.rate_hz);
    const std::shared_ptr<const volume::Version> first = edits.current();
    fill(first);
    MouseDevice mouse(outside_point());
    haptics::ServoOptions servo;
    servo.rate_hz = options_.rate_hz;
    haptics::Device* devices[] = {&mouse};
    sim::LiveSession live(devices, scene_, method, std::move(edits), servo, options_.recorder,
                          options_.start ? options_.start->first_tick : 0);
    live_ = &live;
    mouse_ = &mouse;
    version_ = first;

    vtkNew<vtkRenderWindowInteractor> interactor;
    vtkNew<StylusStyle> style;
    interactor->SetRenderWindow(target_);
    interactor->SetInteractorStyle(style);
    style->SetDefaultRenderer(view_.renderer());
    style->on_press = [this](bool is_down) { is_pressed_ = is_down; };
    style->on_wheel = [this](int way) { depth_mm_ = std::clamp(depth_mm_ + 0.5 * way, 0.5, 12.0); };
    style->on_key = [this, &interactor](const std::string& key, bool has_control) {
      act(key, has_control, interactor);
    };
    interactor->Initialize();
    view_.render();
    report_.first_frame_seconds = seconds_since(start);
    if (volume::Status error = live.start()) return *error;

    interactor_ = interactor;
    started_ = Clock::now();
    vtkNew<vtkCallbackCommand> tick;
    tick->SetClientData(this);
    tick->SetCallback(
        [](vtkObject*, unsigned long, void* self, void*) { static_cast<Window*>(self)->frame(); });
    interactor->AddObserver(vtkCommand::TimerEvent, tick);
    interactor->CreateRepeatingTimer(16);
    interactor->Start();

    live.stop();
    const sim::LiveState last = live.look();
    report_.servo = live.servo_report();
    if (options_.recorder) report_.recording = options_.recorder->finish(live.edits(), report_.servo.dropped);
    report_.removed_mm3 = last.removed_mm3;
    report_.strokes = last.strokes;
    report_.triangles = view_.triangle_count();
    std::sort(frame_ms_.begin(), frame_ms_.end());
    if (!frame_ms_.empty()) {
      report_.frame_p50_ms = frame_ms_[frame_ms_.size() / 2];
      report_.frame_p99_ms = frame_ms_[std::min(frame_ms_.size() - 1, frame_ms_.size() * 99 / 100)];
    }
    if (!options_.screenshot.empty())
      if (volume::Status error = write_png(target_, options_.screenshot)) return *error;
    return report_;
  }

 private:
  dvec3 outside_point() const {
    dvec3 low, high;
    view_.bounds(low, high);
    return 0.5 * (low + high) + dvec3(0, 0, glm::length(high - low));
  }
  /// Through the picture at (x, y), shares of its width and height from the lower left.
  Ray ray_at(double x, double y) {
    vtkRenderer* renderer = view_.renderer();
    const int* size = target_->GetSize();
    dvec3 ends[2];
    for (int i = 0; i < 2; ++i) {
      renderer->SetDisplayPoint(x * size[0], y * size[1], i);
      renderer->DisplayToWorld();
      double world[4];
      renderer->GetWorldPoint(world);
      ends[i] = dvec3(world[0], world[1], world[2]) / world[3];
    }
    return {ends[0], glm::normalize(ends[1] - ends[0])};
  }
  /// Leans the shaft between the surface's normal and the viewer, as a hand would.
  void orient(StylusLook& look, const volume::Version& version) const {
    int cells = 0;
    const dvec3 normal = haptics::outward_normal(
        scene_.shapes[0], version, scene_.base->frame.volume_from_world(look.proxy_world), cells);
    if (glm::dot(normal, normal) > 0)
      look.shaft_direction = glm::normalize(0.7 * normal + 0.5 * look.shaft_direction + dvec3(0, 0, 0.25));
  }

  void act(const std::string& key, bool has_control, vtkRenderWindowInteractor* interactor) {
    if ((has_control && key == "z") || key == "u")
      live_->undo();
    else if ((has_control && key == "y") || key == "y")
      live_->redo();
    else if (key == "f")
      live_->reset_faults();
    else if (key == "q" || key == "Escape")
      interactor->TerminateApp();
    else if (key == "Up")
      depth_mm_ = std::min(12.0, depth_mm_ + 0.5);
    else if (key == "Down")
      depth_mm_ = std::max(0.5, depth_mm_ - 0.5);
    else if (key.size() == 1 && std::string("aplrsiAPLRSI").find(key[0]) != std::string::npos)
      view_.look_from(static_cast<char>(std::toupper(key[0])));
    else if (key == "0")
      view_.look_from(0);
  }

  void frame() {
    const auto begin = Clock::now();
    // The hand's wish: on the surface under the cursor, and into it while the button is down.
    const int* at = interactor_->GetEventPosition();
    const int* size = target_->GetSize();
    const Ray ray = ray_at(static_cast<double>(at[0]) / size[0], static_cast<double>(at[1]) / size[1]);
    const double hit = distance_to_solid(scene_, *version_, ray);
    if (hit >= 0) reach_ = hit;
    const double along = hit >= 0 ? hit + (is_pressed_ ? depth_mm_ : 0.3) : std::max(0.0, reach_ - 8);
    const dvec3 wish = ray.origin + along * ray.direction;
    mouse_->set(wish, is_pressed_ && hit >= 0);
    // A cursor that jumps lifts the stylus over; it is not dragged through the bone.
    constexpr double k_jump_mm = 8;
    if (glm::length(wish - wish_) > k_jump_mm) {
      const double above = hit >= 0 ? std::max(0.0, hit - 1.5 * scene_.base->frame.diagonal_mm()) : along;
      live_->set_down(scene_.base->frame.volume_from_world(ray.origin + above * ray.direction));
      mouse_->jump();
    }
    wish_ = wish;

    // News from the other threads: the version, its changed chunks, the newest tick.
    const sim::LiveState state = live_->look();
    version_ = state.version;
    if (state.changed.low.x <= state.changed.high.x)
      worker_.request(state.version, state.changed.low, state.changed.high);
    for (const ChunkMesh& mesh : worker_.take()) view_.show(mesh);
    StylusLook look;
    look.hip_world = state.newest.pose.position_world;
    look.has_contact = state.newest.has_contact;
    look.proxy_world = look.has_contact ? state.newest.proxy_world : look.hip_world;
    look.force_world = state.newest.force_world;
    look.burr_radius = options_.burr.radius;
    look.shaft_direction = -ray.direction;
    orient(look, *version_);
    look.burr_centre_world =
        look.proxy_world +
        look.burr_radius * (look.has_contact ? state.newest.normal_world : look.shaft_direction);
    // The depth cue: where the burr would land.
    const Ray down{look.burr_centre_world + 20.0 * look.shaft_direction, -look.shaft_direction};
    if (const double landing = distance_to_solid(scene_, *version_, down); landing >= 0) {
      look.has_ring = true;
      look.ring_world = down.origin + landing * down.direction;
      int cells = 0;
      look.ring_normal_world = haptics::outward_normal(
          scene_.shapes[0], *version_, scene_.base->frame.volume_from_world(look.ring_world), cells);
    }
    view_.show(look);
    const haptics::ServoReport servo = live_->servo_report();
    char text[400];
    std::snprintf(text, sizeof text,
                  "force %.2f N\nremoved %.0f mm\xc2\xb3 in %zu stroke%s\ndepth %.1f mm\nservo %.0f Hz, step "
                  "%.1f \xc2\xb5s%s",
                  glm::length(state.newest.force_world), state.removed_mm3, state.strokes,
                  state.strokes == 1 ? "" : "s", depth_mm_, options_.rate_hz, servo.step_p50_us,
                  servo.faults & haptics::k_latched_faults
                      ? "\nFAULT: the force is off; press f when its cause is gone"
                      : "");
    view_.show_text(text,
                    "left: press and drill   wheel: depth   right: turn   middle: move   Ctrl+wheel: zoom   "
                    "u: undo   y: redo   a p l r s i: views   q: quit");
    view_.render();
    ++report_.frames;
    frame_ms_.push_back(1e3 * seconds_since(begin));
    if (options_.seconds && seconds_since(started_) > *options_.seconds) interactor_->TerminateApp();
  }

  const haptics::TouchScene& scene_;
  WindowOptions options_;
  vtkRenderWindow* target_;
  BoneView view_;
  ChunkWorker worker_;
  sim::LiveSession* live_ = nullptr;
  MouseDevice* mouse_ = nullptr;
  vtkRenderWindowInteractor* interactor_ = nullptr;
  std::shared_ptr<const volume::Version> version_;
  bool is_pressed_ = false;
  double depth_mm_ = 2, reach_ = 300;
  dvec3 wish_{1e9};
  Clock::time_point started_;
  std::vector<double> frame_ms_;
  WindowReport report_;
};

}  // namespace

Result<WindowReport> run_window(const haptics::TouchScene& scene, const WindowOptions& options) {
  const auto start = Clock::now();
  if (options.is_offscreen) {
    auto surface = make_offscreen(1200, 900);
    if (!surface) return surface.error();
    return Window(scene, options, surface.value()->window()).draw_once(start);
  }
  if (!has_display()) return no_display();
  vtkNew<vtkRenderWindow> window;
  window->SetSize(1200, 900);
  window->SetMultiSamples(4);
  window->SetWindowName(options.title.c_str());
  return Window(scene, options, window).run(start);
}

}  // namespace trephine::view
