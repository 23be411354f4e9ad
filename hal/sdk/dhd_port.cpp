#include "hal/sdk/dhd_port.h"

#include <fmt/format.h>

#include "hal/sdk/sdk_faults.h"
#include "rt/base/rotation_axes.h"

namespace tactus::hal {
namespace {

// Return values of the library.
constexpr int kDhdGood = 0, kTimeGuard = 1, kSaturated = 2;
// Indices of dhdGetStatus.
constexpr unsigned kConnected = 1, kForceOn = 5, kStatusSize = 17;
constexpr unsigned char kWatchdogSteps = 80;  // of 125 us: 10 ms

struct Model {
  int first_type, last_type;
  double force_N, torque_Nm, radius_m;
};
// Figures by type number, of CHAI3D's device classes; mass, damping and friction are estimates for all.
constexpr Model kModels[] = {{63, 64, 20, 0, 0.15},        // delta.3, delta.6
                             {33, 37, 12, 0, 0.075},       // omega.3 to omega.7
                             {104, 105, 12, 0.2, 0.075},   // sigma.7
                             {206, 206, 12, 0, 0.075},     // sigma.3
                             {203, 203, 12, 0, 0.1125},    // lambda.3
                             {108, 109, 12, 0.2, 0.1125},  // lambda.7
                             {131, 132, 12, 0, 0.1125}};   // lambda.6

const Model* model_of(int type) noexcept {
  for (const Model& model : kModels)
    if (type >= model.first_type && type <= model.last_type) return &model;
  return nullptr;
}

// Axes of the device's frame in the library's: x right = its y, y away = -its x, z up.
Vec3d from_dhd(const Vec3d& v) noexcept { return {v.y, -v.x, v.z}; }
Vec3d to_dhd(const Vec3d& v) noexcept { return {-v.y, v.x, v.z}; }

std::string text_of(const char* text, const char* none) { return text != nullptr ? text : none; }

// Not finite where the matrix is not.
Quatd quaternion_of(const double m[3][3]) noexcept {
  return quat_from_axes({m[0][0], m[1][0], m[2][0]}, {m[0][1], m[1][1], m[2][1]}, {m[0][2], m[1][2], m[2][2]});
}

}  // namespace

Result<std::unique_ptr<DhdPort>> DhdPort::open(std::unique_ptr<DhdLibrary> library, std::optional<unsigned> serial) {
  std::unique_ptr<DhdPort> port(new DhdPort(std::move(library)));
  if (Status status = port->prepare(serial); !status.ok()) return status;
  return port;
}

std::string DhdPort::last_error() const { return text_of(f_.dhdErrorGetLastStr(), "its library says no reason"); }

Status DhdPort::open_device(std::optional<unsigned> serial) {
  if (f_.dhdGetDeviceCount() < 1) return Status::error("dhd: no Force Dimension device is connected and switched on");
  if (serial && f_.dhdOpenSerial == nullptr)
    return Status::error(
        "dhd: the library cannot open a device by its serial number; accepted: dhd:FOLDER, or a newer "
        "SDK");
  id_ = serial ? f_.dhdOpenSerial(static_cast<int>(*serial)) : f_.dhdOpenID(0);
  if (id_ >= 0) return Status::good();
  const std::string which = serial ? fmt::format("the device with serial {}", *serial) : std::string("the device");
  return Status::error(fmt::format("dhd: {} cannot be opened: {}", which, last_error()));
}

std::string DhdPort::set_expert() {
  const char id = static_cast<char>(id_);
  const bool expert = f_.dhdEnableExpertMode() == kDhdGood;
  std::string missing;
  const auto look = [&missing](bool good, const char* words) { missing += good ? "" : words; };
  look(f_.dhdSetTimeGuard(0, id) == kDhdGood, "; its time guard could not be switched off: samples may be old");
  has_watchdog_ = f_.dhdSetWatchdog != nullptr && f_.dhdSetWatchdog(kWatchdogSteps, id) == kDhdGood;
  look(has_watchdog_, "; its watchdog could not be set to 10 ms: a program that is killed may leave the last force");
  if (!expert && !missing.empty()) missing += "; the library has no expert mode for it";
  return missing;
}

Status DhdPort::prepare(std::optional<unsigned> asked) {
  if (Status status = open_device(asked); !status.ok()) return status;
  const char id = static_cast<char>(id_);
  const Model* model = model_of(f_.dhdGetSystemType(id));
  const std::string name = text_of(f_.dhdGetSystemName(id), "device without a name");
  if (model == nullptr)
    return Status::error(
        fmt::format("dhd: {} is of type {}, whose limits are not known here; accepted: delta, omega, "
                    "sigma, lambda",
                    name, f_.dhdGetSystemType(id)));
  if (f_.drdIsInitialized != nullptr && !f_.drdIsInitialized(id))
    return Status::error("dhd: the device is not initialised; run the maker's HapticInit, then start again");
  unsigned short serial = 0;
  (void)f_.dhdGetSerialNumber(&serial, id);
  identity_ = fmt::format("Force Dimension {}, serial {}, SDK {}{}", name, serial, library_->version(), set_expert());
  // Rotation is used only if the wrist is actuated: a passive wrist applies no torque to the hand.
  properties_.has_rotation = f_.dhdHasWrist(id) && f_.dhdHasActiveWrist(id);
  properties_.workspace_radius_m = model->radius_m;
  properties_.max_speed_m_per_s = 1.5;
  properties_.max_force_N = model->force_N;
  properties_.continuous_force_N = 0.4 * model->force_N;
  properties_.max_torque_Nm = properties_.has_rotation ? model->torque_Nm : 0;
  properties_.continuous_torque_Nm = 0.4 * properties_.max_torque_Nm;
  properties_.position_quantum_m = 1e-5;
  properties_.mass_kg = 0.25;
  properties_.damping_Ns_per_m = 1;
  properties_.coulomb_friction_N = 0.3;
  return enable_forces(false) ? Status::good() : Status::error(fmt::format("dhd: {}", last_error()));
}

DhdPort::~DhdPort() {
  if (id_ < 0) return;
  (void)f_.dhdStop(static_cast<char>(id_));
  (void)f_.dhdClose(static_cast<char>(id_));
}

bool DhdPort::enable_forces(bool on) noexcept {
  const char id = static_cast<char>(id_);
  const int zeros = f_.dhdSetForceAndTorqueAndGripperForce(0, 0, 0, 0, 0, 0, 0, id);
  forces_ = on && f_.dhdSetBrakes(0, id) != -1 && f_.dhdEnableForce(1, id) == kDhdGood;
  return on ? forces_ : f_.dhdStop(id) == kDhdGood && zeros != -1;
}

std::string DhdPort::watchdog() const {
  return has_watchdog_ ? "the device's own acts after 10 ms, says its library, which set it; nothing provokes it"
                       : "the device's own could not be set: a program that is killed may leave the last force";
}

SdkResult DhdPort::exchange(const Wrenchd& wrench, SdkState& state) noexcept {
  const char id = static_cast<char>(id_);
  const Vec3d force = to_dhd(wrench.force);
  const Vec3d torque = properties_.has_rotation ? to_dhd(wrench.torque) : Vec3d{};
  const int sent =
      f_.dhdSetForceAndTorqueAndGripperForce(force.x, force.y, force.z, torque.x, torque.y, torque.z, 0, id);
  Vec3d place;
  double matrix[3][3]{};
  const int got = f_.dhdGetPositionAndOrientationFrame(&place.x, &place.y, &place.z, matrix, id);
  int status[kStatusSize]{};
  const bool told = f_.dhdGetStatus(status, id) == kDhdGood;
  if (!told || status[kConnected] == 0) return SdkResult::kGone;
  if (got == -1 || (sent != kDhdGood && sent != kTimeGuard && sent != kSaturated)) return SdkResult::kError;
  state.device_from_tool.position = from_dhd(place);
  if (properties_.has_rotation) {
    const Quatd turn = quaternion_of(matrix);
    const Vec3d axis = from_dhd({turn.x, turn.y, turn.z});
    state.device_from_tool.rotation = {turn.w, axis.x, axis.y, axis.z};
  }
  state.buttons = f_.dhdGetButtonMask(id);
  if (forces_ && status[kForceOn] == 0) state.fault = kSdkForcesOff;
  const bool whole = is_finite(state.device_from_tool);
  return got == kTimeGuard ? SdkResult::kOld : whole ? SdkResult::kFresh : SdkResult::kError;
}

}  // namespace tactus::hal
