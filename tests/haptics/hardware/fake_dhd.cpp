// Stand-in for libdhd of Force Dimension, written from its documentation. Shares no code with the driver.
#include "tests/haptics/hardware/fake_vendor.h"

#define EXPORT __attribute__((visibility("default")))

extern "C" {

EXPORT trephine::fake_vendor::State fake_dhd;

EXPORT int dhdGetDeviceCount() { return fake_dhd.has_no_device ? 0 : 1; }
EXPORT int dhdOpenID(char index) {
  if (index != 0 || fake_dhd.refuses_to_open) return -1;
  fake_dhd.is_open = true;
  return 3;
}
EXPORT int dhdClose(char id) {
  if (id == 3) fake_dhd.is_open = false;
  return id == 3 ? 0 : -1;
}
EXPORT const char* dhdGetSystemName(char) { return "sigma.7"; }
EXPORT const char* dhdErrorGetLastStr() { return "communication error"; }
EXPORT bool dhdHasWrist(char) { return true; }
EXPORT bool dhdHasActiveWrist(char) { return true; }
EXPORT int dhdEnableForce(unsigned char value, char) {
  fake_dhd.has_force = value != 0;
  return 0;
}
EXPORT int dhdGetPositionAndOrientationFrame(double* x, double* y, double* z, double rows[3][3], char id) {
  if (id != 3 || fake_dhd.fails) return -1;
  *x = fake_dhd.position[0], *y = fake_dhd.position[1], *z = fake_dhd.position[2];
  for (int i = 0; i < 9; ++i) rows[i / 3][i % 3] = fake_dhd.rotation[i];
  return 1;  // as documented for a pose that equals the previous one
}
EXPORT unsigned dhdGetButtonMask(char) { return fake_dhd.buttons; }
EXPORT int dhdSetForceAndTorqueAndGripperForce(double fx, double fy, double fz, double tx, double ty,
                                               double tz, double, char id) {
  if (id != 3 || fake_dhd.fails) return -1;
  const double values[] = {fx, fy, fz, tx, ty, tz};
  bool is_zero = true;
  for (int i = 0; i < 6; ++i) fake_dhd.wrench[i] = values[i], is_zero = is_zero && values[i] == 0;
  ++fake_dhd.frames;
  if (!is_zero) ++fake_dhd.frames_with_force;
  return 2;  // as documented for saturated motors
}
}
