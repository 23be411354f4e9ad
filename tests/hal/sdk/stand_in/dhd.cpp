// A stand-in for Force Dimension's library, written from its documented interface: the same names, a mass behind them,
// faults by stand_in() or the environment (script.h). TACTUS_WITHOUT_STATUS leaves a function out, as another version
// of the library may.
#include "tests/hal/sdk/stand_in/dhd.h"

#include <unistd.h>

#include <cmath>

#include "tests/hal/sdk/stand_in/script.h"

namespace {

StandIn g_device;
stand_in_script::Script g_script;

constexpr double kMass_kg = 0.2, kDamping_Ns_per_m = 2, kStiffness_N_per_m = 100, kStep_s = 1e-3;

void obey_script() {
  const bool pushes = g_device.force_N[0] != 0 || g_device.force_N[1] != 0 || g_device.force_N[2] != 0;
  if (!g_script.begins(g_device.forces_on, pushes)) return;
  const std::string_view kind = g_script.kind();
  if (kind == "blocks") g_device.blocks_us = 50'000;
  if (kind == "hangs") g_device.hangs = true;
  if (kind == "errors") g_device.result = -1;
  if (kind == "old") g_device.result = 1;
  if (kind == "gone") g_device.gone = true;
  if (kind == "off") g_device.refuses_force = true;
  if (kind == "off") g_device.forces_on = false;
}

int answer() { return g_device.gone ? -1 : static_cast<int>(g_device.result); }

}  // namespace

extern "C" {

StandIn* stand_in() { return &g_device; }

int dhdOpenID(char) { return g_device.in_use ? -1 : 3; }
int dhdOpenSerial(int serial) {
  g_device.serial_asked = serial;
  return serial == 1234 ? 3 : -1;
}
int dhdClose(char) {
  ++g_device.closed;
  stand_in_script::tell_end(g_device.forces_on);
  return 0;
}
int dhdGetDeviceCount() { return g_device.count; }
const char* dhdErrorGetLastStr() { return g_device.says_nothing ? nullptr : "device is in use"; }
void dhdGetSDKVersion(int* major, int* minor, int* release, int* revision) {
  *major = g_device.major;
  *minor = g_device.minor;
  *release = 5;
  *revision = 0;
}
const char* dhdGetSystemName(char) { return g_device.says_nothing ? nullptr : "omega.3"; }
int dhdGetSystemType(char) { return g_device.type; }
int dhdGetSerialNumber(unsigned short* serial, char) {
  *serial = 1234;
  return 0;
}
bool dhdHasWrist(char) { return g_device.wrist; }
bool dhdHasActiveWrist(char) { return g_device.wrist; }
int dhdGetPositionAndOrientationFrame(double* x, double* y, double* z, double matrix[3][3], char) {
  while (g_device.hangs) usleep(1000);
  if (g_device.blocks_us > 0) usleep(g_device.blocks_us);
  for (int i = 0; i < 3; ++i) {
    const double stretch_m = g_device.position_m[i] - (i == 2 ? g_device.hand_z_m.load() : 0.0);
    const double force = (g_device.forces_on ? g_device.force_N[i].load() : 0.0) - kStiffness_N_per_m * stretch_m -
                         kDamping_Ns_per_m * g_device.speed_m_per_s[i];
    g_device.speed_m_per_s[i] += kStep_s * force / kMass_kg;
    g_device.position_m[i] += kStep_s * g_device.speed_m_per_s[i];
  }
  *x = g_device.position_m[0];
  *y = g_device.position_m[1];
  *z = g_device.position_m[2];
  const double c = std::cos(g_device.turn_rad), s = std::sin(g_device.turn_rad);  // about the library's z
  const double turned[3][3]{{c, -s, 0}, {s, c, 0}, {0, 0, 1}};
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) matrix[i][k] = turned[i][k];
  return answer();
}
int dhdSetForceAndTorqueAndGripperForce(double fx, double fy, double fz, double tx, double ty, double tz, double,
                                        char) {
  const double force[6]{fx, fy, fz, tx, ty, tz};
  for (int i = 0; i < 6; ++i) g_device.force_N[i].store(force[i]);
  ++g_device.exchanges;
  obey_script();
  return g_device.gone ? -1 : 0;
}
unsigned dhdGetButtonMask(char) { return 5; }
int dhdEnableForce(unsigned char on, char) {
  if (g_device.refuses_force) return -1;
  g_device.forces_on = on != 0;
  return 0;
}
int dhdSetBrakes(int, char) { return 0; }
int dhdStop(char) {
  g_device.forces_on = false;
  ++g_device.stops;
  return 0;
}
#ifndef TACTUS_WITHOUT_STATUS
int dhdGetStatus(int status[17], char) {
  for (int i = 0; i < 17; ++i) status[i] = 0;
  status[1] = g_device.gone ? 0 : 1;
  status[5] = g_device.forces_on ? 1 : 0;
  return 0;
}
#endif
int dhdEnableExpertMode() { return g_device.refuses_expert ? -1 : 0; }
int dhdSetTimeGuard(int time_us, char) {
  if (g_device.refuses_expert) return -1;
  g_device.time_guard_us = time_us;
  return 0;
}
int dhdSetWatchdog(unsigned char steps, char) {
  if (g_device.refuses_expert) return -1;
  g_device.watchdog_steps = steps;
  return 0;
}
bool drdIsInitialized(char) { return g_device.initialised; }

}  // extern "C"
