// A stand-in for 3D Systems' library HD, written from its documented interface: the same names, a scheduler, a mass
// behind them on a spring, faults by hd_stand_in() or the environment (script.h). TACTUS_STAND_IN_SWAY_MM, of the
// environment, lets the spring's end go down and up by so much, twice a second, for runs by hand.
// TACTUS_WITHOUT_CALIBRATION leaves a function out, as another version may.
#include "tests/hal/sdk/stand_in/hd.h"

#include <pthread.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <deque>
#include <mutex>
#include <string_view>
#include <thread>

#include "tests/hal/sdk/stand_in/script.h"

namespace {

HdStandIn g_device;
stand_in_script::Script g_script;

struct Error {
  std::uint32_t code;
  std::int32_t internal_code;
  std::uint32_t handle;
};

constexpr double kMass_kg = 0.2, kDamping_Ns_per_m = 2, kStiffness_N_per_m = 100, kStep_s = 1e-3;
constexpr std::uint32_t kHandle = 7;

std::mutex g_errors_mutex;
std::deque<std::uint32_t> g_errors;  // the newest in front
double g_speed_mm_per_s[3]{}, g_frame_force_N[3]{}, g_frame_torque_mNm[3]{};
double g_stamp_s = 0, g_sway_mm = 0, g_time_s = 0;
std::thread g_scheduler;
std::atomic<bool> g_running{false};
unsigned (*g_callback)(void*) = nullptr;
void* g_context = nullptr;

void raise(std::uint32_t code) {
  const std::scoped_lock lock(g_errors_mutex);
  g_errors.push_front(code);
}

void obey_script() {
  const bool pushes = g_device.force_N[0] != 0 || g_device.force_N[1] != 0 || g_device.force_N[2] != 0;
  if (!g_script.begins(g_device.forces_on, pushes)) return;
  const std::string_view kind = g_script.kind();
  if (kind == "blocks") g_device.blocks_us = 50'000;
  if (kind == "stops") g_device.calls = false;
  if (kind == "errors") g_device.error = 0x0101;
  if (kind == "fast") g_device.error = 0x0203;
  if (kind == "gone") g_device.error = 0x0302;
  if (kind == "backwards") g_device.backwards = true;
  if (kind == "off") g_device.refuses_force = true;
  if (kind == "off") g_device.forces_on = false;
}

void step() {
  g_time_s += kStep_s;
  const double down_mm = 0.5 * g_sway_mm * (1 - std::cos(4 * 3.14159265358979 * g_time_s));
  for (int i = 0; i < 3; ++i) {
    const double stretch_m = 1e-3 * (g_device.position_mm[i] + (i == 1 ? down_mm - g_device.hand_y_mm : 0)),
                 speed = 1e-3 * g_speed_mm_per_s[i];
    const double force = (g_device.forces_on ? g_device.force_N[i].load() : 0.0) - kStiffness_N_per_m * stretch_m -
                         kDamping_Ns_per_m * speed;
    g_speed_mm_per_s[i] += 1e3 * kStep_s * force / kMass_kg;
    g_device.position_mm[i].store(g_device.position_mm[i] + kStep_s * g_speed_mm_per_s[i]);
  }
}

// As a maker's scheduler: ahead of other threads, where that is allowed.
void schedule() {
  sched_param priority{};
  priority.sched_priority = 85;
  (void)pthread_setschedparam(pthread_self(), SCHED_FIFO, &priority);
  for (auto next = std::chrono::steady_clock::now(); g_running;) {
    next += std::chrono::milliseconds(1);
    if (g_device.calls && g_callback != nullptr && g_callback(g_context) == 0) g_callback = nullptr;
    step();
    std::this_thread::sleep_until(next);
  }
}

}  // namespace

extern "C" {

HdStandIn* hd_stand_in() { return &g_device; }

std::uint32_t hdInitDevice(const char* name) {
  for (int i = 0; i < 3; ++i) g_speed_mm_per_s[i] = 0;
  const char* const sway = std::getenv("TACTUS_STAND_IN_SWAY_MM");
  g_sway_mm = sway != nullptr ? std::atof(sway) : 0;
  g_time_s = 0;
  if (name != nullptr && std::string_view(name) != "Left Device") raise(0x0302);
  if (g_device.init_error == 0) return kHandle;
  raise(g_device.init_error);
  return 0xffffffff;
}
void hdDisableDevice(std::uint32_t) {
  ++g_device.disabled;
  stand_in_script::tell_end(g_device.forces_on);
}
void hdMakeCurrentDevice(std::uint32_t) {}
void hdBeginFrame(std::uint32_t) {
  if (g_device.blocks_us > 0) usleep(g_device.blocks_us);
  g_device.frame = true;
}
void hdEndFrame(std::uint32_t) {
  g_device.frame = false;
  ++g_device.frames;
  for (int i = 0; i < 3; ++i) {
    g_device.force_N[i].store(g_frame_force_N[i]);
    g_device.torque_mNm[i].store(g_frame_torque_mNm[i]);
  }
  obey_script();
  const unsigned error = g_device.error;
  if (error == 0) return;
  if (error >= 0x0200 && error < 0x0300) g_device.forces_on = false;
  raise(error);
  raise(0x0402);  // what follows from it
}
Error hdGetError() {
  const std::scoped_lock lock(g_errors_mutex);
  if (g_errors.empty()) return {};
  const Error error{g_errors.front(), 1, kHandle};
  g_errors.pop_front();
  return error;
}
const char* hdGetErrorString(std::uint32_t code) { return code == 0x0600 ? "invalid license" : "some error"; }
void hdEnable(std::uint32_t capability) {
  if (capability != 0x4000) return;
  if (g_device.refuses_force)
    raise(0x0102);
  else
    g_device.forces_on = true;
}
void hdDisable(std::uint32_t capability) {
  if (capability == 0x4000) g_device.forces_on = false;
}
unsigned char hdIsEnabled(std::uint32_t capability) { return capability == 0x4000 && g_device.forces_on ? 1 : 0; }
void hdGetDoublev(std::uint32_t parameter, double* values) {
  constexpr double kUsable[6] = {-80, -60, -35, 80, 60, 35}, kWhole[6] = {-210, -110, -85, 210, 205, 130};
  if (parameter == 0x2603) *values = g_device.largest_force_N;
  if (parameter == 0x2604) *values = 0.88;
  for (int i = 0; i < 6; ++i) {
    if (parameter == 0x2550) values[i] = kWhole[i];
    if (parameter == 0x2551) values[i] = kUsable[i];
  }
  if (parameter != 0x2052) return;
  if (!g_device.frame) ++g_device.outside_of_frames;
  const double c = std::cos(g_device.turn_rad), s = std::sin(g_device.turn_rad), wrong = g_device.broken_matrix ? 0 : 1;
  const double columns[16] = {c * wrong, 0, -s * wrong, 0, 0, wrong, 0, 0, s, 0, c, 0, 0, 0, 0, 1};
  for (int i = 0; i < 16; ++i) values[i] = columns[i];
  for (int i = 0; i < 3; ++i) values[12 + i] = g_device.position_mm[i] + (i == 0 ? g_device.glitch_mm.load() : 0.0);
}
void hdGetIntegerv(std::uint32_t parameter, int* values) {
  if (parameter == 0x2000) *values = 2;
  if (parameter == 0x2554) *values = g_device.output_dof;
  if (parameter == 0x2555) *values = 4;
  if (parameter == 0x2600) *values = g_device.rate_Hz;
}
void hdSetDoublev(std::uint32_t parameter, const double* values) {
  if (!g_device.frame) ++g_device.outside_of_frames;
  for (int i = 0; i < 3; ++i) {
    if (parameter == 0x2700) g_frame_force_N[i] = values[i];
    if (parameter == 0x2701) g_frame_torque_mNm[i] = values[i];
  }
}
const char* hdGetString(std::uint32_t parameter) {
  static char version[] = "3.4.0";
  version[0] = g_device.version;
  return parameter == 0x2500 ? version : parameter == 0x2501 ? "Touch" : parameter == 0x2504 ? "1234" : nullptr;
}
#ifndef TACTUS_WITHOUT_CALIBRATION
std::uint32_t hdCheckCalibration() { return g_device.calibration; }
#endif
void hdUpdateCalibration(std::uint32_t style) {
  if (style != 4) return raise(0x0101);
  ++g_device.calibrations;
  if (g_device.forces_on) ++g_device.calibrations_in_force;
  g_device.calibration = 0x5000;
}
void hdStartScheduler() {
  if (!g_running.exchange(true)) g_scheduler = std::thread(schedule);
}
void hdStopScheduler() {
  ++g_device.stopped;
  if (g_running.exchange(false)) g_scheduler.join();
}
void hdSetSchedulerRate(unsigned long rate_Hz) {
  ++g_device.rates_set;
  if (rate_Hz != 1000) raise(0x0101);
}
unsigned long hdScheduleAsynchronous(unsigned (*callback)(void*), void* context, unsigned short) {
  g_callback = callback;
  g_context = context;
  return 9;
}
void hdUnschedule(unsigned long) { g_callback = nullptr; }
double hdGetSchedulerTimeStamp() { return g_stamp_s += g_device.backwards ? -1e-5 : 1e-5; }

}  // extern "C"
