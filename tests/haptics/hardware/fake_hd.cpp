// Stand-in for libHD of OpenHaptics, written from its guide: a scheduler that calls the driver at about 1
// kHz, frames, and a stack of errors. Shares no code with the driver.
#include <chrono>
#include <cstring>
#include <thread>

#include "tests/haptics/hardware/fake_vendor.h"

#define EXPORT __attribute__((visibility("default")))

namespace {

struct ErrorInfo {
  unsigned code;
  int internal_code;
  unsigned device;
};

std::atomic<unsigned> error{0};
std::atomic<int> pending{0};  // errors on the stack
std::thread scheduler;
std::atomic<bool> is_stopping{false};
unsigned (*callback)(void*) = nullptr;
void* callback_data = nullptr;
bool is_in_frame = false;

void raise_error(unsigned code) { error = code, pending = 2; }

}  // namespace

extern "C" {

EXPORT trephine::fake_vendor::State fake_hd;

EXPORT unsigned hdInitDevice(const char* name) {
  if (fake_hd.refuses_to_open || (name && std::strcmp(name, "Right Device") != 0)) {
    raise_error(0x0302);
    return 0xffffffff;
  }
  fake_hd.is_open = true;
  return 7;
}
EXPORT void hdDisableDevice(unsigned) { fake_hd.is_open = false, fake_hd.has_force = false; }
EXPORT void hdBeginFrame(unsigned device) {
  is_in_frame = device == 7;
  if (!is_in_frame) raise_error(0x0400);
}
EXPORT void hdEndFrame(unsigned) {
  if (!is_in_frame) raise_error(0x0401);
  is_in_frame = false;
  if (fake_hd.fails) raise_error(0x0302);
  if (fake_hd.has_hot_motors) raise_error(0x0200);
  ++fake_hd.frames;
}
EXPORT void hdGetDoublev(unsigned name, double* values) {
  if (name == 0x2602) values[0] = 1.02;
  if (name == 0x2603) values[0] = 3.3;
  const double box[] = {-80, -60, -35, 80, 60, 45};
  if (name == 0x2551) std::memcpy(values, box, sizeof(box));
  if (name != 0x2052) return;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) values[4 * column + row] = fake_hd.rotation[3 * row + column];
    values[4 * row + 3] = 0;
    values[12 + row] = fake_hd.position[row];
  }
  values[15] = 1;
}
EXPORT void hdGetIntegerv(unsigned name, int* value) {
  if (name == 0x2000) *value = static_cast<int>(fake_hd.buttons.load());
  if (name == 0x2555) *value = fake_hd.calibration_styles;
}
EXPORT const char* hdGetString(unsigned name) { return name == 0x2501 ? "Touch" : ""; }
EXPORT void hdSetDoublev(unsigned name, const double* values) {
  if (name != 0x2700 || !is_in_frame) return;
  bool is_zero = true;
  for (int i = 0; i < 3; ++i) fake_hd.wrench[i] = values[i], is_zero = is_zero && values[i] == 0;
  if (!is_zero) ++fake_hd.frames_with_force;
}
EXPORT void hdEnable(unsigned name) { fake_hd.has_force = name == 0x4000; }
EXPORT ErrorInfo hdGetError() {
  if (pending > 0) {
    --pending;
    return {error, 0, 7};
  }
  return {0, 0, 0xffffffff};
}
EXPORT const char* hdGetErrorString(unsigned code) {
  return code == 0x0302 ? "An error in communicating with the device" : "other";
}
EXPORT unsigned hdCheckCalibration() {
  return fake_hd.needs_update ? 0x5001 : fake_hd.needs_inkwell ? 0x5002 : 0x5000;
}
EXPORT void hdUpdateCalibration(unsigned style) {
  fake_hd.calibrated_by = static_cast<int>(style);
  if (style == 1 || style == 2) fake_hd.needs_inkwell = fake_hd.needs_update = false;
}
EXPORT unsigned long hdScheduleAsynchronous(unsigned (*function)(void*), void* data, unsigned short) {
  callback = function, callback_data = data;
  return 11;
}
EXPORT void hdUnschedule(unsigned long) {}
EXPORT void hdStartScheduler() {
  is_stopping = false, fake_hd.is_running = true;
  scheduler = std::thread([] {
    unsigned goes_on = 1;  // returned by the callback; 1: it is called again
    while (!is_stopping) {
      if (!fake_hd.is_silent && goes_on == 1) goes_on = callback(callback_data);
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  });
}
EXPORT void hdStopScheduler() {
  is_stopping = true;
  if (scheduler.joinable()) scheduler.join();
  fake_hd.is_running = false;
}
}
