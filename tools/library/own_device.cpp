#include "tools/library/own_device.h"

#include <fmt/format.h>

#include <cmath>

#include "hal/host_faults.h"
#include "tools/library/values.h"

namespace tactus::library {
namespace {

using haptics::DeviceState;
using haptics::ReadStatus;

static_assert(static_cast<std::uint32_t>(Reading::kFresh) == static_cast<std::uint32_t>(ReadStatus::kFresh) &&
              static_cast<std::uint32_t>(Reading::kMissing) == static_cast<std::uint32_t>(ReadStatus::kMissing) &&
              static_cast<std::uint32_t>(Reading::kCorrupt) == static_cast<std::uint32_t>(ReadStatus::kCorrupt) &&
              static_cast<std::uint32_t>(Reading::kDisconnected) ==
                  static_cast<std::uint32_t>(ReadStatus::kDisconnected));

struct Figure {
  const char* name;
  double DeviceProperties::*ours;
  double haptics::DeviceProperties::*inner;
  bool may_be_zero;
  bool of_rotation{false};  // 0 is accepted for a device without rotation
};

// In the order of the fields.
constexpr Figure kFigures[] = {
    {"workspace_radius_m", &DeviceProperties::workspace_radius_m, &haptics::DeviceProperties::workspace_radius_m,
     false},
    {"max_speed_m_per_s", &DeviceProperties::max_speed_m_per_s, &haptics::DeviceProperties::max_speed_m_per_s, false},
    {"max_angular_speed_rad_per_s", &DeviceProperties::max_angular_speed_rad_per_s,
     &haptics::DeviceProperties::max_angular_speed_rad_per_s, false, true},
    {"max_force_N", &DeviceProperties::max_force_N, &haptics::DeviceProperties::max_force_N, false},
    {"max_torque_Nm", &DeviceProperties::max_torque_Nm, &haptics::DeviceProperties::max_torque_Nm, false, true},
    {"continuous_force_N", &DeviceProperties::continuous_force_N, &haptics::DeviceProperties::continuous_force_N,
     false},
    {"continuous_torque_Nm", &DeviceProperties::continuous_torque_Nm, &haptics::DeviceProperties::continuous_torque_Nm,
     false, true},
    {"position_quantum_m", &DeviceProperties::position_quantum_m, &haptics::DeviceProperties::position_quantum_m,
     false},
    {"rotation_quantum_rad", &DeviceProperties::rotation_quantum_rad, &haptics::DeviceProperties::rotation_quantum_rad,
     false, true},
    {"mass_kg", &DeviceProperties::mass_kg, &haptics::DeviceProperties::mass_kg, false},
    {"damping_Ns_per_m", &DeviceProperties::damping_Ns_per_m, &haptics::DeviceProperties::damping_Ns_per_m, true},
    {"inertia_kg_m2", &DeviceProperties::inertia_kg_m2, &haptics::DeviceProperties::inertia_kg_m2, false, true},
    {"damping_Nms_per_rad", &DeviceProperties::damping_Nms_per_rad, &haptics::DeviceProperties::damping_Nms_per_rad,
     true},
    {"delay_s", &DeviceProperties::delay_s, &haptics::DeviceProperties::delay_s, true},
    {"coulomb_friction_N", &DeviceProperties::coulomb_friction_N, &haptics::DeviceProperties::coulomb_friction_N, true},
    {"coulomb_friction_Nm", &DeviceProperties::coulomb_friction_Nm, &haptics::DeviceProperties::coulomb_friction_Nm,
     true},
};
static_assert(sizeof(DeviceProperties) == 8 + sizeof(double) * std::size(kFigures), "one is not listed");

haptics::DeviceProperties to_inner_properties(const DeviceProperties& from) noexcept {
  haptics::DeviceProperties to;
  to.has_rotation = from.has_rotation;
  for (const Figure& figure : kFigures) to.*figure.inner = from.*figure.ours;
  return to;
}

}  // namespace

Status check_properties(const DeviceProperties& properties) {
  for (const Figure& figure : kFigures) {
    const double value = properties.*figure.ours;
    const bool zero_will_do = figure.may_be_zero || (figure.of_rotation && !properties.has_rotation);
    if (std::isfinite(value) && (value > 0 || (value == 0 && zero_will_do))) continue;
    return Status::error(fmt::format("Device::properties: {} is {:g}; accepted: a number {} 0", figure.name, value,
                                     zero_will_do ? ">=" : ">"));
  }
  if (properties.continuous_force_N > properties.max_force_N ||
      properties.continuous_torque_Nm > properties.max_torque_Nm)
    return Status::error(
        fmt::format("Device::properties: it bears {:g} N and {:g} N m for ever, and at most {:g} N and {:g} N m; "
                    "accepted: for ever "
                    "no more than at most",
                    properties.continuous_force_N, properties.continuous_torque_Nm, properties.max_force_N,
                    properties.max_torque_Nm));
  return Status::good();
}

OwnDevice::OwnDevice(Device& device, const DeviceProperties& properties, double period_s) noexcept
    : device_(device), properties_(to_inner_properties(properties)), period_s_(period_s) {}

Status OwnDevice::start() {
  const Error error = device_.start(period_s_);
  started_ = !error;
  return error ? Status::error("the device did not start: " + error.message()) : Status::good();
}

void OwnDevice::read(haptics::DeviceInput& input) noexcept {
  ++state_.reads;
  DeviceSample sample{.position_m = state_.last.position_m, .rotation = state_.last.rotation, .buttons = 0, .fault = 0};
  const Reading reading = device_.read(sample);
  if (reading == Reading::kFresh) {
    state_.last = sample;
    ++state_.sample.sequence;
    state_.sample.device_time_ns = static_cast<std::uint64_t>(static_cast<double>(state_.reads) * period_s_ * 1e9);
    state_.sample.device_from_tool = {to_inner(sample.position_m), to_inner(sample.rotation)};
    state_.sample.state = state_.state;
    state_.sample.device_fault = hal::without_host_bit(sample.fault);
    state_.sample.buttons = sample.buttons;
  }
  input = {static_cast<ReadStatus>(reading), 0, state_.sample};
}

void OwnDevice::write(const haptics::DeviceCommand& command) noexcept {
  const bool rearms = command.rearm != 0 && state_.rearm == 0;
  state_.rearm = command.rearm;
  if (command.wanted == DeviceState::kBrake)
    state_.state = DeviceState::kBrake;
  else if (state_.state != DeviceState::kBrake || rearms)
    state_.state = command.wanted;
  state_.sample.echoed_sequence = command.sequence;
  DeviceCommand out;
  out.force_on = state_.state == DeviceState::kForce && is_finite(command.wrench);
  out.brake = state_.state == DeviceState::kBrake;
  out.clear_fault = rearms;
  if (out.force_on) {
    out.force_N = to_public(command.wrench.force);
    if (properties_.has_rotation) out.torque_Nm = to_public(command.wrench.torque);
  }
  device_.write(out);
}

void OwnDevice::finish() noexcept {
  if (!started_) return;
  started_ = false;
  device_.write({});
  device_.stop();
}

}  // namespace tactus::library
