#include "hal/sdk/hd_port.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "hal/sdk/sdk_faults.h"
#include "rt/base/rotation_axes.h"

namespace tactus::hal {
namespace {

constexpr std::uint32_t kInvalidHandle = 0xffffffff;
constexpr unsigned kMostErrors = 16;  // taken in one frame
constexpr unsigned kGoOn = 1;         // what a scheduled function returns to be called again
constexpr unsigned short kFirst = 0xffff;

// Parameters, capabilities and answers, by their documented numbers.
enum Parameter : std::uint32_t {
  kButtons = 0x2000,
  kTransform = 0x2052,  // 16 values by column, mm
  kVersion = 0x2500,
  kModel = 0x2501,
  kSerial = 0x2504,
  kWholeWorkspace = 0x2550,   // 6 values, mm: the lowest x, y, z, and the highest
  kUsableWorkspace = 0x2551,  // the same
  kOutputDof = 0x2554,
  kCalibrationStyle = 0x2555,
  kUpdateRate = 0x2600,  // Hz
  kLargestForce = 0x2603,
  kContinuousForce = 0x2604,
  kForce = 0x2700,   // N
  kTorque = 0x2701,  // mN m
};
enum Capability : std::uint32_t { kForceOutput = 0x4000, kForceClamping = 0x4001 };
enum Calibration : std::uint32_t { kCalibrated = 0x5000, kWantsUpdate = 0x5001 };
enum Code : std::uint32_t {
  kHdGood = 0,
  kInvalidValue = 0x0101,
  kWarmMotors = 0x0200,
  kForceBeyond = 0x0201,
  kImpulseBeyond = 0x0202,
  kSpeedBeyond = 0x0203,
  kForceError = 0x0204,
  kDeviceFault = 0x0300,
  kDeviceInUse = 0x0301,
  kBusError = 0x0302,
  kBusConfiguration = 0x0303,
  kNoLicence = 0x0600,
};

// The fault for an error of the library; 0: an error that costs at most a sample.
std::uint32_t fault_of(std::uint32_t code) noexcept {
  switch (code) {
    case kWarmMotors:
      return kSdkMotorsWarm;
    case kForceBeyond:
      return kSdkForceTooLarge;
    case kImpulseBeyond:
      return kSdkForceTooSudden;
    case kSpeedBeyond:
      return kSdkTooFast;
    case kForceError:
      return kSdkForceError;
    case kDeviceFault:
    case kDeviceInUse:
      return kSdkDeviceFault;
    case kBusError:
    case kBusConfiguration:
      return kSdkConnectionLost;
    case kNoLicence:
      return kSdkLicenceRefused;
    default:
      return 0;
  }
}

bool is_gone(std::uint32_t fault) noexcept { return fault == kSdkDeviceFault || fault == kSdkConnectionLost; }

Vec3d from_hd(const Vec3d& v) noexcept { return {v.x, -v.z, v.y}; }
Vec3d to_hd(const Vec3d& v) noexcept { return {v.x, v.z, -v.y}; }

// A name may be null, as that of a library that failed.
std::string text_or(const char* text, const char* otherwise) {
  return text != nullptr && *text != '\0' ? text : otherwise;
}

struct Box {
  Vec3d low, high;  // m
  bool makes_sense() const noexcept {
    for (int i = 0; i < 3; ++i)
      if (!(high[i] - low[i] > 0.01 && high[i] - low[i] < 3)) return false;
    return true;
  }
  // From `centre` to the corner that is the farthest away.
  double radius_about(const Vec3d& centre) const noexcept {
    Vec3d farthest;
    for (int i = 0; i < 3; ++i) farthest[i] = std::max(high[i] - centre[i], centre[i] - low[i]);
    return norm(farthest);
  }
};

}  // namespace

Result<std::unique_ptr<HdPort>> HdPort::open(std::unique_ptr<HdLibrary> library, const std::string& name) {
  std::unique_ptr<HdPort> port(new HdPort(std::move(library)));
  if (Status status = port->prepare(name); !status.ok()) return status;
  return port;
}

Status HdPort::refused(const char* what, std::uint32_t code) const {
  return Status::error(
      fmt::format("openhaptics: {}: {} (error {:#06x})", what, text_or(f_.hdGetErrorString(code), "no reason"), code));
}

Status HdPort::prepare(const std::string& name) {
  (void)take_error();
  handle_ = f_.hdInitDevice(name.empty() ? nullptr : name.c_str());
  const std::uint32_t code = take_error();
  if (handle_ == kInvalidHandle || code != kHdGood) {
    open_ = handle_ != kInvalidHandle;
    return refused("the device cannot be opened; see that the maker's setup program finds it", code);
  }
  open_ = true;
  f_.hdMakeCurrentDevice(handle_);
  if (Status status = read_identity(); !status.ok()) return status;
  if (Status status = read_figures(); !status.ok()) return status;
  f_.hdEnable(kForceClamping);
  (void)take_error();  // the library may lack this limit; tactus limits the force too
  if (!enable_forces(false)) return Status::error("openhaptics: the device's forces cannot be switched off");
  return Status::good();
}

Status HdPort::read_identity() {
  const std::string version = text_or(f_.hdGetString(kVersion), "of no known version");
  const std::size_t digit = version.find_first_of("0123456789");
  unsigned major = 0;
  const char* const first = version.data() + std::min(digit, version.size());
  const bool numbered = std::from_chars(first, version.data() + version.size(), major).ec == std::errc();
  if (numbered && major != 3)
    return Status::error(fmt::format("openhaptics: the library is HD {}; accepted: OpenHaptics 3.0 to 3.5", version));
  identity_ = fmt::format("3D Systems {}, serial {}, HD {}", text_or(f_.hdGetString(kModel), "device"),
                          text_or(f_.hdGetString(kSerial), "unknown"), version);
  (void)take_error();
  return Status::good();
}

// The device's own figures, as far as the library has them; mass, damping, friction and quantum are estimates, on the
// safe side over the models.
Status HdPort::read_figures() {
  double force_N = 0, continuous_N = 0;
  int outputs = 0;
  f_.hdGetDoublev(kLargestForce, &force_N);
  f_.hdGetDoublev(kContinuousForce, &continuous_N);
  f_.hdGetIntegerv(kOutputDof, &outputs);
  const auto box_of = [&](Parameter which) {
    double mm[6]{};
    f_.hdGetDoublev(which, mm);
    return Box{Vec3d{mm[0], mm[1], mm[2]} * 1e-3, Vec3d{mm[3], mm[4], mm[5]} * 1e-3};
  };
  const Box usable = box_of(kUsableWorkspace);
  Box whole = box_of(kWholeWorkspace);
  if (!whole.makes_sense()) whole = usable;
  const std::uint32_t code = take_error();
  if (code != kHdGood) return refused("the device's figures cannot be read", code);
  if (!(force_N >= 0.5 && force_N <= 60 && continuous_N >= 0 && continuous_N <= force_N) || !usable.makes_sense())
    return Status::error(
        fmt::format("openhaptics: the library's figures of the device make no sense ({} N, {} N for long, {} m wide); "
                    "accepted: 0.5 to 60 N, a workspace",
                    force_N, continuous_N, usable.high.x - usable.low.x));
  constexpr int kAllAxes = 6;
  centre_ = (usable.low + usable.high) * 0.5;
  // Rotation is used only if the wrist is actuated: a passive wrist applies no torque to the hand.
  properties_.has_rotation = outputs == kAllAxes;
  properties_.workspace_radius_m = whole.radius_about(centre_);
  properties_.max_speed_m_per_s = 1.5;
  properties_.max_force_N = force_N;
  properties_.continuous_force_N = continuous_N;
  properties_.max_torque_Nm = properties_.has_rotation ? 0.188 : 0;  // CHAI3D's figure for a Premium 6-DoF
  properties_.continuous_torque_Nm = 0.25 * properties_.max_torque_Nm;
  properties_.position_quantum_m = 5.5e-5;
  properties_.mass_kg = 0.045;
  properties_.damping_Ns_per_m = 0.2;
  properties_.coulomb_friction_N = 0.04;
  return Status::good();
}

HdPort::~HdPort() {
  stop_calls();
  if (open_) f_.hdDisableDevice(handle_);
}

// The first that was raised since the last call: the cause of the others. The library gives the newest first.
std::uint32_t HdPort::take_error() const noexcept {
  std::uint32_t first = kHdGood;
  for (unsigned i = 0; i < kMostErrors; ++i) {
    const std::uint32_t code = f_.hdGetError().code;
    if (code == kHdGood) break;
    first = code;
  }
  return first;
}

bool HdPort::enable_forces(bool on) noexcept {
  f_.hdMakeCurrentDevice(handle_);
  if (on)
    f_.hdEnable(kForceOutput);
  else
    f_.hdDisable(kForceOutput);
  const bool good = take_error() == kHdGood && (f_.hdIsEnabled(kForceOutput) != 0) == on;
  forces_ = on && good;
  return good;
}

std::string HdPort::watchdog() const {
  return "none is known in the device: it keeps its last force while its library is stuck, and may when a program is "
         "killed";
}

Status HdPort::start_calls(const SdkCall& call, std::int64_t period_ns) {
  call_ = call;
  period_s_ = 1e-9 * static_cast<double>(period_ns);
  const double rate_Hz = 1 / period_s_;
  f_.hdSetSchedulerRate(static_cast<unsigned long>(std::lround(rate_Hz)));
  if (const std::uint32_t code = take_error(); code != kHdGood && code != kInvalidValue)
    return refused("the rate of the library's scheduler cannot be set", code);
  const auto on_call = [](void* port) {
    const SdkCall& call_of_port = static_cast<HdPort*>(port)->call_;
    call_of_port.function(call_of_port.context);
    return kGoOn;
  };
  scheduled_ = f_.hdScheduleAsynchronous(on_call, this, kFirst);
  if (const std::uint32_t code = take_error(); code != kHdGood)
    return refused("the library's scheduler takes no function", code);
  running_ = true;
  f_.hdStartScheduler();
  if (const std::uint32_t code = take_error(); code != kHdGood)
    return refused("the library's scheduler does not start", code);
  int told_Hz = 0;
  f_.hdGetIntegerv(kUpdateRate, &told_Hz);
  (void)take_error();
  if (told_Hz > 0 && std::abs(told_Hz - rate_Hz) > 0.01 * rate_Hz)
    return Status::error(
        fmt::format("openhaptics: the library's scheduler runs at {} Hz; accepted: --rate {}", told_Hz, told_Hz));
  return Status::good();
}

void HdPort::stop_calls() noexcept {
  if (!running_) return;
  running_ = false;
  f_.hdStopScheduler();
  f_.hdUnschedule(scheduled_);
}

double HdPort::time_s() const noexcept {
  return f_.hdGetSchedulerTimeStamp != nullptr ? f_.hdGetSchedulerTimeStamp() : 0.0;
}

void HdPort::look_at_calibration(SdkState& state) noexcept {
  const std::uint32_t told = f_.hdCheckCalibration();
  if (told == kCalibrated) return;
  state.fault = kSdkNotCalibrated;
  if (told != kWantsUpdate || forces_) return;
  int style = 0;
  f_.hdGetIntegerv(kCalibrationStyle, &style);
  f_.hdUpdateCalibration(static_cast<std::uint32_t>(style));
}

// False: it is no pose, or too far from the last one.
bool HdPort::read_pose(SdkState& state) noexcept {
  double m[16]{};
  f_.hdGetDoublev(kTransform, m);
  int buttons = 0;
  f_.hdGetIntegerv(kButtons, &buttons);
  state.buttons = static_cast<std::uint32_t>(buttons);
  const Vec3d place = Vec3d{m[12], m[13], m[14]} * 1e-3;
  const bool near = !placed_ || norm(place - last_) <= kJump_m_per_s * period_s_;
  placed_ = is_finite(place);
  last_ = place;
  state.device_from_tool.position = from_hd(place - centre_);
  // The columns may have lost their right angles by rounding.
  const Vec3d first{m[0], m[1], m[2]}, second{m[4], m[5], m[6]};
  const Vec3d x = first * (1 / norm(first)), across = second - x * dot(x, second), y = across * (1 / norm(across));
  const Quatd turn = quat_from_axes(x, y, cross(x, y));
  const Vec3d axis = from_hd(turn.vec());
  state.device_from_tool.rotation = {turn.w, axis.x, axis.y, axis.z};
  return near && is_finite(state.device_from_tool);
}

void HdPort::send(const Wrenchd& wrench) const noexcept {
  const Vec3d force = to_hd(wrench.force);
  const double force_N[3] = {force.x, force.y, force.z};
  f_.hdSetDoublev(kForce, force_N);
  if (!properties_.has_rotation) return;
  const Vec3d torque = to_hd(wrench.torque) * 1e3;
  const double torque_mNm[3] = {torque.x, torque.y, torque.z};
  f_.hdSetDoublev(kTorque, torque_mNm);
}

SdkResult HdPort::exchange(const Wrenchd& wrench, SdkState& state) noexcept {
  f_.hdBeginFrame(handle_);
  const double began_s = time_s();
  const bool believed = read_pose(state);
  send(wrench);
  look_at_calibration(state);
  f_.hdEndFrame(handle_);
  const double ended_s = time_s();
  const std::uint32_t code = take_error();
  if (!(ended_s >= began_s)) state.fault = kSdkTimeWentBack;
  if (forces_ && f_.hdIsEnabled(kForceOutput) == 0) state.fault = kSdkForcesOff;
  if (const std::uint32_t fault = fault_of(code); fault != 0) state.fault = fault;
  if (is_gone(state.fault)) return SdkResult::kGone;
  const bool good = believed && code == kHdGood && state.fault != kSdkTimeWentBack;
  return good ? SdkResult::kFresh : SdkResult::kError;
}

}  // namespace tactus::hal
