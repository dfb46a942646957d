#include "apps/view/view_window.h"

#include <cctype>
#include <cmath>
#include <cstdio>
#include <dlfcn.h>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <vtkCallbackCommand.h>
#include <vtkNew.h>
#include <vtkRenderWindow.h>
#include <vtkRenderWindowInteractor.h>
#include <vtkRenderer.h>

#include "apps/view/device_page.h"
#include "apps/view/operation_controller.h"
#include "apps/view/render_window.h"
#include "apps/view/start_page.h"
#include "apps/view/stylus_style.h"
#include "apps/view/tool_appearance.h"
#include "apps/view/virtual_device_page.h"
#include "apps/workbench/clock.h"
#include "apps/workbench/operation.h"
#include "apps/workbench/plan_overlays.h"

namespace trephine::view {

using workbench::Clock;
using workbench::seconds_since;

using glm::dvec3;

namespace {

/// Shows detached bodies and the overlays of modules at their current poses.
void show_overlays(const sim::Replay& replay, Viewport& picture) {
  sim::Overlays overlays = replay.engine().overlays();
  for (sim::Overlay& overlay : overlays) overlay.holder = -1;  // the engine's poses include held bodies
  picture.show(overlays, {});
}

/// Shows the tool in the state of the replay, seen from its side of the bone.
void show_replay(const sim::Replay& replay, const workbench::SessionSummary& summary,
                 const haptics::TouchScene& scene, Viewport& picture) {
  const haptics::ServoRecord& record = replay.record(summary.hand_at(replay.next_tick()));
  const volume::Volume& base = *scene.base;
  const glm::dvec3 middle = base.frame.world_from_volume(0.5 * glm::dvec3(base.size - 1));
  const glm::dvec3 tip = record.has_contact ? record.proxy_world : record.pose.position_world;
  glm::dvec3 low, high, from = tip - middle;
  picture.view().bounds(low, high);
  from = glm::length(from) > 1 ? glm::normalize(from) : glm::dvec3(0, -1, 0);
  // Turn slightly toward front, left and above, so that a straight hole is not seen end-on.
  from = glm::normalize(from + 0.6 * glm::normalize(glm::dvec3(0.55, -0.75, 0.38)));
  picture.view().aim_camera(0.5 * (low + high), from, {0, 0, 1}, BoneView::distance_of(low, high));
  picture.show_stylus(record, appearance_of(replay.engine().state().settings.hands[record.hand].parameters),
                      *replay.engine().version(), from);
  show_overlays(replay, picture);
}

/// Places the stylus on the surface in the middle of the picture.
void rest_stylus(const volume::Version& version, const ToolAppearance& tool, Viewport& picture) {
  const Ray ray = picture.ray_at(0.5, 0.5);
  const double hit = picture.resting_position(version, ray).distance;
  if (hit < 0) return;
  haptics::ServoRecord record;
  record.has_contact = true;
  record.proxy_world = record.pose.position_world = ray.origin + hit * ray.direction;
  record.normal_world = -ray.direction;
  if (const std::optional<glm::dvec3> normal = picture.mean_surface_normal(version, ray);
      normal && !tool.is_ball)
    record.pose.orientation = glm::dquat(dvec3(0, 0, 1), *normal);
  picture.show_stylus(record, tool, version, -ray.direction);
}

Result<WindowReport> draw_once(const haptics::TouchScene& scene, const WindowOptions& options) {
  const auto start = Clock::now();
  auto surface = make_offscreen(1200, 900);
  if (!surface) return surface.error();
  // Only a live picture has the layers that draw translucent bone, and is drawn for two eyes.
  const bool is_live = !options.opacities.empty() || !options.display.is_plain() || options.head_tracker;
  Viewport picture(scene, surface.value()->window(), is_live);
  if (Status error = picture.set_opacities(options.opacities)) return *error;
  DisplayMode display = options.display;
  if (display.eyes == DisplayMode::Eyes::headset) display.eyes = DisplayMode::Eyes::one;
  picture.view().set_display(display, options.head_tracker);
  const auto version = options.version ? options.version : haptics::uncut_version(scene);
  picture.request_all(version);
  picture.wait();
  picture.look_from(options.side);
  if (options.plan) picture.set_plan(workbench::plan_overlays(*options.plan, scene));
  if (options.start) picture.show(options.start->engine.overlays(), {});
  if (options.replay && options.replay->next_tick() > 0)
    show_replay(*options.replay, options.summary, scene, picture);
  else if (options.replay)
    show_overlays(*options.replay, picture);  // a session of commands alone has no hand motion
  else if (options.has_tool)
    rest_stylus(*version,
                options.start ? appearance_of(options.start->engine.state().settings.hands[0].parameters)
                              : ball_appearance(2),
                picture);
  picture.show_text(options.title, "");
  if (is_live)
    picture.complete();
  else
    picture.draw();
  WindowReport report;
  report.frames = 1;
  report.triangles = picture.triangle_count();
  report.first_frame_seconds = seconds_since(start);
  if (!options.screenshot.empty())
    if (Status error = write_png(surface.value()->window(), options.screenshot)) return *error;
  return report;
}

void change_tool(OperationController& operation, int steps) {
  sim::Value tool = operation.tool();
  if (step_first_number(tool, steps)) operation.apply(std::move(tool));
}

void act(OperationController& operation, const std::string& key, bool has_control,
         vtkRenderWindowInteractor* interactor) {
  if ((has_control && key == "z") || key == "u")
    operation.undo();
  else if ((has_control && key == "y") || key == "y")
    operation.redo();
  else if (key == "f")
    operation.reset_faults();
  else if (key == "q" || key == "Escape")
    interactor->TerminateApp();
  else if (key == "Up" || key == "Down")
    operation.set_depth(operation.depth() + (key == "Up" ? 0.5 : -0.5));
  else if (key == "plus" || key == "minus")
    change_tool(operation, key == "plus" ? 1 : -1);
  else if (key.size() == 1 && std::string("aplrsiAPLRSI").find(key[0]) != std::string::npos)
    operation.viewport().look_from(static_cast<char>(std::toupper(key[0])));
  else if (key == "0")
    operation.viewport().look_from(0);
}

std::string status_text(const OperationController& operation, double rate_hz) {
  const sim::LiveState& s = operation.state();
  char text[400];
  std::snprintf(
      text, sizeof text,
      "force %.2f N\nremoved %.0f mm\xc2\xb3 in %zu change%s\ndepth %.1f mm\nservo %.0f Hz, step %.1f "
      "\xc2\xb5s%s%s",
      glm::length(s.newest.force_world), s.removed_mm3, s.strokes, s.strokes == 1 ? "" : "s",
      operation.depth(), rate_hz, operation.servo().step_p50_us, operation.fault_text().empty() ? "" : "\n",
      operation.fault_text().c_str());
  const std::string notices = operation.notices().shown(operation.seconds());
  return notices.empty() ? text : text + ("\n\n" + notices);
}

/// Completes the picture and writes it.
Status save_picture(OperationController& operation, vtkRenderWindow* window, const std::string& path) {
  if (!operation.viewport().complete())
    return Error{.what = "the screenshot failed: the window was not drawn",
                 .where = "screenshot",
                 .remedy = "write the picture without a window (omit option seconds)",
                 .kind = ErrorKind::missing_here};
  return write_png(window, path);
}

}  // namespace

Result<WindowReport> run_plain_window(const haptics::TouchScene& scene, const WindowOptions& options) {
  const auto start = Clock::now();
  vtkNew<vtkRenderWindow> window;
  window->SetSize(static_cast<int>(options.width), static_cast<int>(options.height));
  window->SetWindowName(options.title.c_str());
  OperationController operation(scene, options, window);
  operation.viewport().look_from(options.side);
  if (Status error = operation.viewport().set_opacities(options.opacities)) return *error;
  operation.viewport().view().set_display(options.display, options.head_tracker, options.hmd);
  if (Status error = operation.start()) return *error;
  if (options.plan) operation.viewport().set_plan(workbench::plan_overlays(*options.plan, scene));

  vtkNew<vtkRenderWindowInteractor> interactor;
  vtkNew<StylusStyle> style;
  interactor->SetRenderWindow(window);
  interactor->SetInteractorStyle(style);
  style->SetDefaultRenderer(operation.viewport().view().renderer());
  style->on_press = [&](bool is_down) { operation.press(is_down); };
  style->on_wheel = [&](int steps) { operation.set_depth(operation.depth() + 0.5 * steps); };
  style->on_tilt = [&](bool is_down) { operation.hold_tip(is_down); };
  style->on_tilt_move = [&](double right, double up) { operation.tilt(0.3 * right, 0.3 * up); };
  style->on_roll = [&](int steps) { operation.roll(steps); };
  style->on_zoom = [&](int direction, double x, double y) {
    operation.viewport().zoom(*operation.version(), direction > 0 ? 1.15 : 1 / 1.15, x, y);
  };
  style->on_turn = [&](double right, double up) { operation.viewport().turn(0.3 * right, -0.3 * up); };
  style->on_key = [&](const std::string& key, bool has_control) {
    act(operation, key, has_control, interactor);
  };
  interactor->Initialize();
  operation.frame();
  const double first_frame = seconds_since(start);

  struct Loop {
    OperationController* operation;
    vtkRenderWindowInteractor* interactor;
    const WindowOptions* options;
    Clock::time_point started;
    Status screenshot_error = std::nullopt;
  } loop{&operation, interactor, &options, Clock::now()};
  vtkNew<vtkCallbackCommand> tick;
  tick->SetClientData(&loop);
  tick->SetCallback([](vtkObject*, unsigned long, void* data, void*) {
    auto* l = static_cast<Loop*>(data);
    const int* at = l->interactor->GetEventPosition();
    const int* size = l->interactor->GetRenderWindow()->GetSize();
    l->operation->set_cursor(static_cast<double>(at[0]) / size[0], static_cast<double>(at[1]) / size[1]);
    l->operation->viewport().show_text(
        status_text(*l->operation, l->options->rate_hz),
        size[0] < 900 ? "left: drill   wheel: depth   right: turn   u: undo   y: redo   q: quit"
                      : "left: press and drill   wheel: depth   right: turn   middle: tilt   "
                        "Ctrl+wheel: zoom   u: undo   "
                        "y: redo   a p l r s i: views   q: quit");
    l->operation->frame();
    if (EyeDisplay* eyes = l->operation->viewport().view().eyes())
      if (const Status problem = eyes->take_problem()) l->operation->show_refusal(problem->message().c_str());
    if ((l->options->seconds && seconds_since(l->started) > *l->options->seconds) ||
        l->options->should_close()) {
      // Write the picture now: the event loop destroys the graphics context at its end, and with it the bone.
      if (!l->options->screenshot.empty())
        l->screenshot_error =
            save_picture(*l->operation, l->interactor->GetRenderWindow(), l->options->screenshot);
      l->interactor->TerminateApp();
    }
  });
  interactor->AddObserver(vtkCommand::TimerEvent, tick);
  interactor->CreateRepeatingTimer(16);
  interactor->Start();

  WindowReport report = operation.finish();
  report.window = "plain";
  report.first_frame_seconds = first_frame;
  if (loop.screenshot_error) return *loop.screenshot_error;
  return report;
}

namespace {

/// Returns an entry point of the window's library; null if the library is not installed. The library remains
/// loaded, because Qt does not support unloading before the program ends.
void* window_entry(const char* name) {
  void* library = dlopen(TREPHINE_WINDOW_LIBRARY, RTLD_NOW | RTLD_GLOBAL);
  return library ? dlsym(library, name) : nullptr;
}

}  // namespace

Status open_with_page(const DevicePageOptions& options) {
  if (has_display())
    if (void* entry = window_entry(k_device_page_entry))
      return reinterpret_cast<OpenWithPage>(entry)(options);
  return options.open([](const std::string&) {}, [] { return false; });
}

Status show_virtual_device(workbench::VirtualDeviceHost& host, const VirtualDevicePageOptions& options) {
  if (!has_display() && options.screenshot.empty()) return no_display();
  if (void* entry = window_entry(k_virtual_device_entry))
    return reinterpret_cast<ShowVirtualDevice>(entry)(host, options);
  return Error{.what = "the virtual device needs the full window",
               .found = "libtrephine-window is not installed",
               .remedy = "install trephine-window, or play a motion: --device virtual:PATH.csv",
               .kind = ErrorKind::missing_here};
}

Result<StartChoice> choose_start(const StartPageOptions& options) {
  if (!has_display() && !options.is_offscreen()) return no_display();
  if (void* entry = window_entry(k_start_page_entry)) return reinterpret_cast<ChooseStart>(entry)(options);
  return Error{.what = "the start page needs the full window",
               .found = "libtrephine-window is not installed",
               .remedy = "install trephine-window, or open a case with trephine view",
               .kind = ErrorKind::missing_here};
}

Result<WindowReport> run_window(std::shared_ptr<const haptics::TouchScene> scene,
                                const WindowOptions& options) {
  if (options.start) scene = options.start->scene();
  if (options.is_offscreen) return draw_once(*scene, options);
  if (!has_display()) return no_display();
  if (void* entry = window_entry(k_qt_window_entry))
    return reinterpret_cast<RunQtWindow>(entry)(std::move(scene), options);
  if (options.replay)
    return Error{.what = "replay needs the full window",
                 .found = "libtrephine-window is not installed",
                 .remedy = "install trephine-window, or replay without a window",
                 .kind = ErrorKind::missing_here};
  return run_plain_window(*scene, options);
}

}  // namespace trephine::view
