#include "haptics/hardware/touch_device.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <glm/gtc/quaternion.hpp>
#include <glm/mat3x3.hpp>
#include <optional>
#include <thread>

#include "haptics/device/device_kind.h"
#include "haptics/hardware/vendor_library.h"

namespace trephine::haptics {

using glm::dvec3;

namespace {

// Constants of the library, as in its programmer's guide.
constexpr unsigned k_current_buttons = 0x2000, k_current_transform = 0x2052, k_current_force = 0x2700;
constexpr unsigned k_model_type = 0x2501, k_usable_workspace = 0x2551, k_calibration_style = 0x2555;
constexpr unsigned k_max_stiffness = 0x2602, k_max_force = 0x2603;
constexpr unsigned k_force_output = 0x4000;
constexpr unsigned k_calibration_ok = 0x5000, k_calibration_needs_update = 0x5001;
constexpr unsigned k_first_force_error = 0x0200, k_last_force_error = 0x0204;
constexpr int k_encoder_reset = 1, k_automatic = 2, k_inkwell = 4;  // bits of the calibration style
constexpr unsigned k_invalid_device = 0xffffffff;
constexpr unsigned k_call_again = 1, k_call_no_more = 0;
constexpr unsigned short k_priority = 500;

constexpr int k_pause_ticks = 500;   // without force, after an error of the force
constexpr int k_most_errors = 64;    // largest number of errors read at once
constexpr int k_closing_frames = 3;  // frames without force before the device is closed

struct HdError {
  unsigned code;
  int internal_code;
  unsigned device;
};

}  // namespace

/// Functions of libHD, in the form that its guide documents.
struct TouchDevice::Functions {
  unsigned (*init_device)(const char*);
  void (*disable_device)(unsigned);
  void (*begin_frame)(unsigned);
  void (*end_frame)(unsigned);
  void (*get_doubles)(unsigned, double*);
  void (*get_integers)(unsigned, int*);
  const char* (*get_string)(unsigned);
  void (*set_doubles)(unsigned, const double*);
  void (*enable)(unsigned);
  HdError (*get_error)();
  const char* (*error_text)(unsigned);
  unsigned (*check_calibration)();
  void (*update_calibration)(unsigned);
  unsigned long (*schedule)(unsigned (*)(void*), void*, unsigned short);
  void (*unschedule)(unsigned long);
  void (*start)();
  void (*stop)();
};

TouchDevice::TouchDevice(TouchChoice choice) : choice_(std::move(choice)), id_(k_invalid_device) {
  capabilities_ = {.name = "3D Systems Touch", .degrees_of_freedom = 6, .max_force = 3.3};
}

TouchDevice::~TouchDevice() { close(); }

Status check_touch_library() { return TouchDevice(TouchChoice()).load(); }

Status TouchDevice::load() {
  auto library =
      VendorLibrary::load({.device = "touch",
                           .product = "OpenHaptics",
                           .files = choice_.files,
                           .remedy = "install OpenHaptics and the Touch device driver of 3D Systems"});
  if (!library) return library.error();
  auto f = std::make_unique<Functions>();
  Binder bind(library.value());
  bind("hdInitDevice", f->init_device)("hdDisableDevice", f->disable_device)("hdBeginFrame", f->begin_frame)(
      "hdEndFrame", f->end_frame)("hdGetDoublev", f->get_doubles)("hdGetIntegerv", f->get_integers)(
      "hdGetString", f->get_string)("hdSetDoublev", f->set_doubles)("hdEnable", f->enable)(
      "hdGetError", f->get_error)("hdGetErrorString", f->error_text)(
      "hdCheckCalibration", f->check_calibration)("hdUpdateCalibration", f->update_calibration)(
      "hdScheduleAsynchronous", f->schedule)("hdUnschedule", f->unschedule)("hdStartScheduler", f->start)(
      "hdStopScheduler", f->stop);
  if (!bind.error()) hd_ = std::move(f);
  return bind.error();
}

/// Removes the errors from the library's queue, at most k_most_errors, and returns their summary.
TouchDevice::Errors TouchDevice::take_errors() noexcept {
  Errors errors;
  for (int i = 0; i < k_most_errors; ++i) {
    const HdError error = hd_->get_error();
    if (error.code == 0) break;
    const bool is_of_force = error.code >= k_first_force_error && error.code <= k_last_force_error;
    (is_of_force ? errors.is_of_force : errors.is_of_device) = true;
    if (errors.code == 0 || !is_of_force) errors.code = error.code;
  }
  return errors;
}

Status TouchDevice::open() {
  close();
  if (!hd_)
    if (Status error = load()) return error;
  const auto failed = [&](const char* what, const char* part, unsigned code, const char* remedy) {
    const char* const text = code != 0 ? hd_->error_text(code) : nullptr;
    return Error{.what = what,
                 .where = std::string("touch: ") + part,
                 .found = text ? text : "",
                 .remedy = remedy,
                 .kind = ErrorKind::missing_here};
  };
  take_errors();
  id_ = hd_->init_device(choice_.name.empty() ? nullptr : choice_.name.c_str());
  if (const unsigned code = take_errors().code; code != 0 || id_ == k_invalid_device) {
    id_ = k_invalid_device;
    return failed("the Touch could not be opened", "absent", code,
                  "plug it in, pair it with the vendor's setup program, and check the permission of its "
                  "/dev/ttyACM file");
  }
  read_capabilities();
  hd_->enable(k_force_output);
  exchange_.restart();
  is_closing_ = false, closing_ticks_ = 0, pause_ticks_ = 0;
  schedule_ = hd_->schedule(&TouchDevice::tick, this, k_priority);
  is_scheduled_ = true;
  hd_->start();
  if (const unsigned code = take_errors().code; code != 0) {
    close();
    return failed("the scheduler of OpenHaptics does not start", "busy", code,
                  "close other programs that use the device");
  }
  if (Status error = calibrate()) {
    close();
    return error;
  }
  // The first report arrives within a few ticks of the scheduler.
  Pose pose;
  for (int i = 0; i < 1000; ++i) {
    if (exchange_.read(0, pose)) return std::nullopt;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  close();
  return failed("the Touch does not respond", "silent", 0, "check its cable and power supply");
}

/// Waits until the device is calibrated. Some models require that the user puts the stylus into the inkwell,
/// or holds the arm at its reset position.
Status TouchDevice::calibrate() {
  using namespace std::chrono;
  int style = 0;
  hd_->get_integers(k_calibration_style, &style);
  style = (style & k_automatic) != 0 ? k_automatic : (style & k_inkwell) != 0 ? k_inkwell : k_encoder_reset;
  const auto end = steady_clock::now() + duration<double>(choice_.calibration_seconds);
  const duration<double> reset_time(choice_.reset_seconds);
  std::optional<steady_clock::time_point> asked_at;
  while (true) {
    const unsigned state = hd_->check_calibration();
    if (state == k_calibration_ok) return std::nullopt;
    if (state == k_calibration_needs_update) {
      hd_->update_calibration(static_cast<unsigned>(style));
    } else if (!asked_at) {
      choice_.notice(style == k_encoder_reset
                         ? "Touch: hold the arm at its reset position for some seconds."
                         : "Touch: put the stylus into the inkwell until the device is calibrated.");
      asked_at = steady_clock::now();
    } else if (style == k_encoder_reset && steady_clock::now() - *asked_at > reset_time) {
      hd_->update_calibration(static_cast<unsigned>(style));
    }
    if (choice_.should_stop()) return cancelled("touch");
    if (steady_clock::now() > end)
      return Error{.what = "the Touch was not calibrated in time",
                   .where = "touch: not homed",
                   .remedy = "put the stylus into the inkwell, or hold the arm at its reset position",
                   .kind = ErrorKind::missing_here};
    std::this_thread::sleep_for(milliseconds(20));
  }
}

/// Reads limits of the device. Values that are impossible are replaced by those of the Touch.
void TouchDevice::read_capabilities() {
  const auto in_range = [](double value, double least, double most, double otherwise) {
    return value >= least && value <= most ? value : otherwise;
  };
  double force = 0, stiffness = 0;
  std::array<double, 6> box{};
  hd_->get_doubles(k_max_force, &force);
  hd_->get_doubles(k_max_stiffness, &stiffness);
  hd_->get_doubles(k_usable_workspace, box.data());
  take_errors();
  const dvec3 low(box[0], box[1], box[2]), high(box[3], box[4], box[5]);
  const dvec3 size = high - low;
  const double least = std::min({size.x, size.y, size.z});
  const bool is_box = least > 10 && least < 2000 && std::isfinite(size.x + size.y + size.z);
  centre_ = is_box ? 0.5 * (low + high) : dvec3(0);
  const char* const model = hd_->get_string(k_model_type);
  capabilities_ = {.name = model && *model ? "3D Systems " + std::string(model) : "3D Systems Touch",
                   .degrees_of_freedom = 6,
                   .max_force = in_range(force, 0.5, 40, 3.3),
                   .max_stiffness = in_range(stiffness, 0.05, 10, 0.5),
                   .workspace_radius = is_box ? 0.5 * least : 35};
}

void TouchDevice::close() noexcept {
  if (id_ == k_invalid_device) return;
  if (is_scheduled_) {
    // Waits until the scheduler has sent the last frames without force; at most 0.1 s, since the scheduler
    // may have stopped.
    is_closing_ = true;
    for (int i = 0; i < 100 && closing_ticks_ < k_closing_frames; ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    hd_->unschedule(schedule_);
    hd_->stop();
    is_scheduled_ = false;
  }
  hd_->disable_device(id_);
  take_errors();
  id_ = k_invalid_device;
}

unsigned TouchDevice::tick(void* device) noexcept {
  auto& self = *static_cast<TouchDevice*>(device);
  const bool is_closing = self.is_closing_;
  self.step();
  return !is_closing || ++self.closing_ticks_ < k_closing_frames ? k_call_again : k_call_no_more;
}

/// Exchanges one frame. After an error of the force, the next frames are without force. Returns false, and
/// reports nothing, after any other error of the library.
bool TouchDevice::step() noexcept {
  std::array<double, 16> columns{};
  int buttons = 0;
  hd_->begin_frame(id_);
  hd_->get_doubles(k_current_transform, columns.data());
  hd_->get_integers(k_current_buttons, &buttons);
  dvec3 force = exchange_.wrench().force_world;
  if (pause_ticks_ > 0) --pause_ticks_, force = dvec3(0);
  if (is_closing_) force = dvec3(0);
  hd_->set_doubles(k_current_force, &force.x);
  hd_->end_frame(id_);
  const Errors errors = take_errors();
  if (errors.is_of_force) pause_ticks_ = k_pause_ticks;
  if (errors.is_of_device) return false;
  glm::dmat3 rotation;
  for (int column = 0; column < 3; ++column)
    for (int row = 0; row < 3; ++row)
      rotation[column][row] = columns[static_cast<std::size_t>(4 * column + row)];
  const dvec3 position(columns[12], columns[13], columns[14]);
  exchange_.report(position - centre_, unit_of(glm::quat_cast(rotation)),
                   static_cast<std::uint32_t>(buttons));
  return true;
}

}  // namespace trephine::haptics
