#include "hal/falcon/simulated_falcon.h"

#include <algorithm>
#include <cmath>

namespace tactus::hal {
namespace {

PlantParameters mechanics() noexcept {
  return {.mass_kg = 0.2,
          .damping_Ns_per_m = 1,
          .coulomb_force_N = 0.1,
          .stop_radius_m = DeltaArm::kWorkspaceRadius_m,
          .max_effort = {50, 50, 50, 0, 0, 0},
          .has_rotation = false};
}

constexpr unsigned kSubSteps = 4;
constexpr unsigned kGreen = 2;  // of the bits to the device

}  // namespace

SimulatedFalconPort::SimulatedFalconPort(const HandModel& hand, double gain_per_Nm, std::int64_t period_ns, bool loaded)
    : hand_(hand),
      plant_(mechanics(), hand.parameters(), hand.target_at(0).pose),
      gain_per_Nm_(gain_per_Nm),
      period_s_(static_cast<double>(period_ns) * 1e-9),
      program_(loaded ? Program::kRunning : Program::kBoot) {}

bool SimulatedFalconPort::control(FtdiRequest request, std::uint16_t value) noexcept {
  if (faults.unplugged) return false;
  if (request == FtdiRequest::kDivisor) {
    divisor_ = value;
    if (program_ == Program::kLoading && value == 0x02 && image_bytes_ > 0) program_ = Program::kRunning;
  }
  if (request == FtdiRequest::kModem && value == 0x0101 && program_ != Program::kRunning) {  // DTR rises: boot
    program_ = Program::kBoot;
    image_bytes_ = 0;
  }
  if (request == FtdiRequest::kReset) size_ = 0;
  return true;
}

bool SimulatedFalconPort::write(std::span<const std::uint8_t> bytes) noexcept {
  if (faults.unplugged) return false;
  for (const std::uint8_t byte : bytes) hear(byte);
  return true;
}

void SimulatedFalconPort::hear(std::uint8_t byte) noexcept {
  if (program_ == Program::kRunning) {
    if (divisor_ != 0 && divisor_ != 0x02) return;  // it receives no bytes at another rate
    if (byte == '<') request_size_ = 0;
    if (request_size_ < request_.size()) request_[request_size_++] = byte;
    if (byte == '>' && request_size_ == request_.size()) answer();
    return;
  }
  if (program_ == Program::kLoading) {
    ++image_bytes_;
    const bool wrong = faults.wrong_echoes > 0;
    if (wrong) --faults.wrong_echoes;
    put(static_cast<std::uint8_t>(wrong ? ~byte & 0xff : byte));
    return;
  }
  if (divisor_ == 0x15 && byte == 0x41) {
    program_ = Program::kLoading;
    put(byte);
    return;
  }
  if (divisor_ != 0x4138) return;
  greeting_ = {greeting_[1], greeting_[2], byte};
  if (greeting_ != std::array<std::uint8_t, 3>{0x0a, 0x43, 0x0d}) return;
  if (faults.failed_handshakes > 0) {
    --faults.failed_handshakes;
    return;
  }
  for (const int one : {0x00, 0x0a, 0x44, 0x2c, 0x0d}) put(static_cast<std::uint8_t>(one));
}

void SimulatedFalconPort::answer() noexcept {
  FalconState as_sent;
  if (faults.mute || !decode_falcon(request_, as_sent)) return;
  motors_ = as_sent.counts;
  green_ = (as_sent.buttons & kGreen) != 0;
  const AxisVector q = DeltaArm::axes_of(plant_.pose().position);
  FalconRequest counts;
  for (unsigned i = 0; i < 3; ++i)
    counts.motors[i] = static_cast<std::int16_t>(
        std::lround((q[i] + DeltaArm::centre_angle() - DeltaArm::kZeroCount_rad) / DeltaArm::kCount_rad));
  FalconBytes bytes = encode_falcon(counts);
  bytes[13] = static_cast<std::uint8_t>('A' + (faults.homed << 4));
  if (faults.garbage)
    for (const char c : {'<', 'A', 'x', '>'}) put(static_cast<std::uint8_t>(c));
  for (int times = faults.twice ? 2 : 1; times > 0; --times)
    for (std::size_t i = 0; i < bytes.size() - (faults.cut_packets ? 2 : 0); ++i) put(bytes[i]);
}

void SimulatedFalconPort::put(std::uint8_t byte) noexcept {
  if (size_ < queue_.size()) queue_[(first_ + size_++) % queue_.size()] = byte;
}

int SimulatedFalconPort::read(std::span<std::uint8_t> bytes, std::chrono::milliseconds) noexcept {
  if (faults.unplugged) return -1;
  const std::size_t count = std::min(bytes.size(), size_);
  for (std::size_t i = 0; i < count; ++i) bytes[i] = queue_[(first_ + i) % queue_.size()];
  first_ = (first_ + count) % queue_.size();
  size_ -= count;
  return static_cast<int>(count);
}

Vec3d SimulatedFalconPort::force() const noexcept {
  AxisVector effort{};
  for (unsigned i = 0; i < 3; ++i) effort[i] = -motors_[i] / gain_per_Nm_;
  return DeltaArm().wrench_of(DeltaArm::axes_of(plant_.pose().position), effort).force;
}

void SimulatedFalconPort::advance() noexcept {
  for (unsigned i = 0; i < kSubSteps; ++i) {
    const Vec3d at_tool = force();
    time_s_ += period_s_ / kSubSteps;
    plant_.step(period_s_ / kSubSteps, {at_tool.x, at_tool.y, at_tool.z, 0, 0, 0}, false, hand_.target_at(time_s_));
  }
}

}  // namespace tactus::hal
