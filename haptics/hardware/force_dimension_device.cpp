#include "haptics/hardware/force_dimension_device.h"

#include <chrono>
#include <cstdlib>
#include <glm/gtc/quaternion.hpp>
#include <glm/mat3x3.hpp>
#include <thread>

#include "haptics/hardware/vendor_library.h"

namespace trephine::haptics {

using glm::dvec3;

namespace {

constexpr double k_mm_per_m = 1000;

// The library's frame: x toward the user, y to the right, z up.
dvec3 from_dhd(const dvec3& v) { return {v.y, v.z, v.x}; }
dvec3 to_dhd(const dvec3& v) { return {v.z, v.x, v.y}; }

/// Values of the vendor's data sheets. The stiffness is well below that of the data sheets, which is measured
/// at a rate of 4 kHz.
struct Model {
  const char* name;  ///< part of the name that the library reports
  double max_force, max_torque, workspace_radius;
};
constexpr Model k_models[] = {
    {"omega", 12, 0, 55}, {"delta", 20, 150, 130}, {"sigma", 20, 400, 65}, {"lambda", 20, 200, 85}};
constexpr Model k_unknown_model{"", 8, 0, 50};
constexpr double k_max_stiffness = 2;  // N/mm

}  // namespace

/// Functions of libdhd, in the form that its manual documents. A char identifies a device.
struct ForceDimensionDevice::Functions {
  int (*device_count)();
  int (*open_id)(char);
  int (*close)(char);
  const char* (*system_name)(char);
  const char* (*last_error)();
  bool (*has_wrist)(char);
  bool (*has_active_wrist)(char);
  int (*enable_force)(unsigned char, char);
  int (*pose)(double*, double*, double*, double[3][3], char);
  unsigned (*buttons)(char);
  int (*set_wrench)(double, double, double, double, double, double, double, char);
  bool (*has_gripper)(char);                   ///< may be null
  int (*emulate_button)(unsigned char, char);  ///< may be null

  std::string error() const {
    const char* const text = last_error();
    return text ? text : "";
  }
};

std::vector<std::string> dhd_files() {
  std::vector<std::string> files;
  if (const char* const sdk = std::getenv("FORCEDIM_SDK"); sdk && *sdk == '/')
    for (const char* const folder : {"/lib/release/lin-x86_64-gcc/", "/lib/"})
      for (const char* const name : {"libdhd.so.3", "libdhd.so"})
        files.push_back(std::string(sdk) + folder + name);
  files.insert(files.end(),
               {"libdhd.so.3", "libdhd.so", "/usr/local/lib/libdhd.so.3", "/usr/local/lib/libdhd.so"});
  return files;
}

ForceDimensionDevice::ForceDimensionDevice(ForceDimensionChoice choice) : choice_(std::move(choice)) {
  capabilities_ = {
      .name = "Force Dimension", .degrees_of_freedom = 3, .max_force = k_unknown_model.max_force};
}

ForceDimensionDevice::~ForceDimensionDevice() { close(); }

Status check_dhd_library() { return ForceDimensionDevice({0, dhd_files()}).load(); }

Status ForceDimensionDevice::load() {
  auto library =
      VendorLibrary::load({.device = "omega",
                           .product = "Force Dimension",
                           .files = choice_.files,
                           .remedy = "install the Force Dimension SDK, and set FORCEDIM_SDK to its folder"});
  if (!library) return library.error();
  auto f = std::make_unique<Functions>();
  Binder bind(library.value());
  bind("dhdGetDeviceCount", f->device_count)("dhdOpenID", f->open_id)("dhdClose", f->close)(
      "dhdGetSystemName", f->system_name)("dhdErrorGetLastStr", f->last_error)("dhdHasWrist", f->has_wrist)(
      "dhdHasActiveWrist", f->has_active_wrist)("dhdEnableForce", f->enable_force)(
      "dhdGetPositionAndOrientationFrame", f->pose)("dhdGetButtonMask", f->buttons)(
      "dhdSetForceAndTorqueAndGripperForce", f->set_wrench);
  library.value().bind_optional("dhdHasGripper", f->has_gripper);
  library.value().bind_optional("dhdEmulateButton", f->emulate_button);
  if (!bind.error()) dhd_ = std::move(f);
  return bind.error();
}

Status ForceDimensionDevice::open() {
  close();
  if (!dhd_)
    if (Status error = load()) return error;
  const int count = dhd_->device_count();
  if (count <= static_cast<int>(choice_.index))
    return Error{.what = "the device of Force Dimension was not found",
                 .where = "omega: absent",
                 .found = std::to_string(std::max(count, 0)),
                 .expected = "at least " + std::to_string(choice_.index + 1),
                 .remedy = "plug it in and switch it on; 'trephine doctor --devices' checks its permission",
                 .kind = ErrorKind::missing_here};
  id_ = dhd_->open_id(static_cast<char>(choice_.index));
  if (id_ < 0) {
    id_ = -1;
    return Error{.what = "the device of Force Dimension could not be opened",
                 .where = "omega: busy",
                 .found = dhd_->error(),
                 .remedy = "close other programs that use it, and calibrate it with the vendor's program",
                 .kind = ErrorKind::missing_here};
  }
  const char device = static_cast<char>(id_);
  const char* const name = dhd_->system_name(device);
  const std::string system = name ? name : "";
  Model model = k_unknown_model;
  for (const Model& known : k_models)
    if (system.find(known.name) != std::string::npos) model = known;
  has_wrist_ = dhd_->has_wrist(device), has_torque_ = dhd_->has_active_wrist(device);
  capabilities_ = {.name = system.empty() ? "Force Dimension" : "Force Dimension " + system,
                   .degrees_of_freedom = has_wrist_ ? 6 : 3,
                   .max_force = model.max_force,
                   .max_stiffness = k_max_stiffness,
                   .workspace_radius = model.workspace_radius,
                   .max_torque = has_torque_ ? model.max_torque : 0};
  // A closed gripper is the first button.
  if (dhd_->has_gripper && dhd_->emulate_button && dhd_->has_gripper(device)) dhd_->emulate_button(1, device);
  exchange_.restart();
  if (!send({}) || dhd_->enable_force(1, device) < 0 || !step()) {
    const std::string cause = dhd_->error();
    close();
    return Error{.what = "the device of Force Dimension does not respond",
                 .where = "omega: silent",
                 .found = cause,
                 .remedy = "check its power supply and cable",
                 .kind = ErrorKind::missing_here};
  }
  thread_.start([this] {
    using namespace std::chrono;
    const auto begin = steady_clock::now();
    step();
    // An exchange over USB takes about 250 us. A much shorter exchange failed, or reached no hardware: the
    // pause limits the rate of the loop.
    if (steady_clock::now() - begin < microseconds(100)) std::this_thread::sleep_for(microseconds(250));
    return true;
  });
  return std::nullopt;
}

void ForceDimensionDevice::close() noexcept {
  thread_.stop();
  if (id_ < 0) return;
  send({});
  dhd_->enable_force(0, static_cast<char>(id_));
  dhd_->close(static_cast<char>(id_));
  id_ = -1;
}

/// Sends a wrench in the device frame. Returns false if the library reports an error.
bool ForceDimensionDevice::send(const Wrench& wrench) noexcept {
  const dvec3 force = to_dhd(wrench.force_world);
  const dvec3 torque = has_torque_ ? to_dhd(wrench.torque_world) / k_mm_per_m : dvec3(0);
  return dhd_->set_wrench(force.x, force.y, force.z, torque.x, torque.y, torque.z, 0,
                          static_cast<char>(id_)) >= 0;
}

/// Exchanges pose and wrench. Returns false, and reports nothing, if the library reports an error.
bool ForceDimensionDevice::step() {
  dvec3 position(0);
  double rows[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const char device = static_cast<char>(id_);
  const bool is_read = dhd_->pose(&position.x, &position.y, &position.z, rows, device) >= 0;
  const std::uint32_t buttons = is_read ? dhd_->buttons(device) : 0;
  if (!send(exchange_.wrench()) || !is_read) return false;
  glm::dquat orientation(1, 0, 0, 0);
  if (has_wrist_) {
    glm::dmat3 rotation;
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 3; ++column) rotation[column][row] = rows[row][column];
    const glm::dquat q = glm::quat_cast(rotation);
    const dvec3 axis = from_dhd({q.x, q.y, q.z});
    orientation = unit_of({q.w, axis.x, axis.y, axis.z});
  }
  exchange_.report(k_mm_per_m * from_dhd(position), orientation, buttons);
  return true;
}

}  // namespace trephine::haptics
