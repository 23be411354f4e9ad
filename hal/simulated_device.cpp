#include "hal/simulated_device.h"

#include <limits>
#include <string>
#include <utility>

namespace tactus::hal {
namespace {

constexpr std::int64_t kMinPeriod_ns = 50'000, kMaxPeriod_ns = 1'000'000'000;
constexpr unsigned kMaxSubSteps = 64, kMaxDelayTicks = 32;
static_assert(kMaxDelayTicks + kMaxLateTicks <= SimulatedLink::kMaxAhead);

constexpr double kHandSettles_s = 0.5;  // four time constants (decay to about a third) of an arm's vibration

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

unsigned delay_of(const DeviceProfile& profile, const SimulationOptions& options) noexcept {
  return options.transport_delay_ticks.value_or(profile.transport_delay_ticks);
}

}  // namespace

Status SimulatedDevice::check(const SimulationOptions& options) {
  if (options.period_ns < kMinPeriod_ns || options.period_ns > kMaxPeriod_ns)
    return Status::error("simulated device: the period must be from 50 us to 1 s, it is " +
                         std::to_string(options.period_ns) + " ns");
  if (options.sub_steps < 1 || options.sub_steps > kMaxSubSteps)
    return Status::error("simulated device: the mechanics take 1 to 64 sub-steps, not " +
                         std::to_string(options.sub_steps));
  const unsigned delay = options.transport_delay_ticks.value_or(1);
  if (delay < 1 || delay > kMaxDelayTicks)
    return Status::error("simulated device: the transport delay must be 1 to 32 ticks, it is " + std::to_string(delay));
  return Status::good();
}

SimulatedDevice::SimulatedDevice(const DeviceProfile& profile, HandModel hand, const SimulationOptions& options)
    : options_(options),
      properties_(profile.properties),
      quantum_(profile.quantum),
      travel_per_axis_(norm(profile.kinematics.twist_of({}, unit_axis(0)).linear)),
      // One tick of the delay is inherent: the firmware sees a command in the period after write().
      state_delay_ticks_((delay_of(profile, options) - 1) / 2),
      command_delay_ticks_(delay_of(profile, options) - 1 - state_delay_ticks_),
      hand_(std::move(hand)),
      plant_(profile.plant, hand_.parameters(), hand_.target_at(0.0).pose, profile.kinematics),
      device_(told_idle(firmware_config(profile, static_cast<std::uint32_t>(options.period_ns / 1000)), counts())),
      codec_(profile.kinematics, profile.quantum, profile.properties.has_rotation),
      random_state_(options.seed) {
  properties_.delay_s = static_cast<double>(delay_of(profile, options)) * static_cast<double>(options.period_ns) * 1e-9;
}

void SimulatedDevice::read(haptics::DeviceInput& input) noexcept {
  now_ = reads_++;
  if (now_ > 0) advance_plant();
  run_firmware();
  receive_state(input);
}

void SimulatedDevice::write(const haptics::DeviceCommand& command) noexcept {
  if (fault(FaultKind::kUnplugged, FaultDirection::kCommand) != nullptr) return;
  haptics::DeviceCommand sent = command;
  if (fault(FaultKind::kNan, FaultDirection::kCommand) != nullptr) sent.wrench.force.x = kNan;
  std::array<std::byte, firmware::kCommandFrameSize> bytes{};
  codec_.encode(sent, bytes);
  if (fault(FaultKind::kDuplicated, FaultDirection::kCommand) != nullptr && command_sent_) bytes = last_command_;
  last_command_ = bytes;
  command_sent_ = true;
  if (fault(FaultKind::kLost, FaultDirection::kCommand) != nullptr) return;
  if (const auto* f = fault(FaultKind::kCorrupted, FaultDirection::kCommand))
    flip_bits(bytes, static_cast<unsigned>(f->amount));
  const auto* late = fault(FaultKind::kLate, FaultDirection::kCommand);
  const auto late_ticks = late != nullptr ? static_cast<std::uint64_t>(late->amount) : 0;
  command_link_.send(now_, now_ + 1 + command_delay_ticks_ + late_ticks, bytes);
}

double SimulatedDevice::time_s(std::uint64_t tick, unsigned sub_step) const noexcept {
  const double sub_steps = static_cast<double>(tick) * options_.sub_steps + sub_step;
  return sub_steps * (static_cast<double>(options_.period_ns) * 1e-9 / options_.sub_steps);
}

HandTarget SimulatedDevice::target_at(std::uint64_t tick, unsigned sub_step) const noexcept {
  if (hand_is_operated_) return operated_hand_.at(time_s(0, sub_step));
  const double since_s = time_s(tick - hand_since_, sub_step);
  return hand_returns_ ? hand_.returning_from(return_from_, since_s) : hand_.target_at(path_from_s_ + since_s);
}

void SimulatedDevice::return_hand() noexcept {
  return_from_ = hand_target().pose;
  hand_since_ = now_;
  hand_returns_ = true;
  hand_is_operated_ = false;
}

void SimulatedDevice::take_hand() noexcept {
  operated_hand_.begin(hand_target());
  hand_is_operated_ = true;
  hand_returns_ = false;
}

void SimulatedDevice::lead_hand(const Vec3d& moved, const Vec3d& turned) noexcept {
  if (!hand_is_operated_) take_hand();
  operated_hand_.wish(moved, turned);
}

void SimulatedDevice::hold_hand() noexcept {
  if (!hand_is_operated_) take_hand();
  operated_hand_.hold();
}

bool SimulatedDevice::hand_is_back() const noexcept {
  return time_s(now_ - hand_since_, 0) >= hand_.return_s(return_from_) + kHandSettles_s;
}

void SimulatedDevice::start_path(double into_s) noexcept {
  hand_since_ = now_;
  path_from_s_ = into_s;
  hand_returns_ = false;
}

const InjectedFault* SimulatedDevice::fault(FaultKind kind, FaultDirection direction) const noexcept {
  return options_.faults.active(kind, direction, now_);
}

firmware::AxisCounts SimulatedDevice::counts() const noexcept {
  firmware::AxisCounts counts{};
  for (unsigned i = 0; i < kAxisCount; ++i) counts[i] = firmware::count_of(plant_.coordinates()[i], quantum_[i]);
  return counts;
}

void SimulatedDevice::advance_plant() noexcept {
  AxisVector effort{};
  for (unsigned i = 0; i < kAxisCount; ++i) effort[i] = static_cast<double>(outputs_.effort[i]);
  const double h_s = time_s(0, 1);
  for (unsigned s = 1; s <= options_.sub_steps; ++s) plant_.step(h_s, effort, outputs_.brake, target_at(now_ - 1, s));
  if (hand_is_operated_) operated_hand_.advance(time_s(0, options_.sub_steps));
}

void SimulatedDevice::run_firmware() noexcept {
  if (const auto arrived = command_link_.arriving(now_); !arrived.empty()) {
    std::copy(arrived.begin(), arrived.end(), waiting_command_.begin());
    command_waits_ = true;
  }
  if (fault(FaultKind::kFrozen, FaultDirection::kState) != nullptr) {
    outputs_.effort = {};
    if (state_sent_) send_state(outputs_.state_frame);
    return;
  }
  firmware::ControllerInputs inputs;
  inputs.counts = counts();
  inputs.time_us = now_ * static_cast<std::uint64_t>(options_.period_ns) / 1000;
  inputs.buttons = buttons_;
  inputs.emergency_stop = fault(FaultKind::kEmergencyStop, FaultDirection::kState) != nullptr;
  outputs_ = device_.step(inputs,
                          command_waits_ ? std::span<const std::byte>(waiting_command_) : std::span<const std::byte>());
  command_waits_ = false;
  send_state(outputs_.state_frame);
}

void SimulatedDevice::send_state(const StateBytes& fresh) noexcept {
  if (fault(FaultKind::kUnplugged, FaultDirection::kState) != nullptr) return;
  StateBytes bytes = fresh;
  distort(bytes);
  if (fault(FaultKind::kDuplicated, FaultDirection::kState) != nullptr && state_sent_) bytes = last_state_;
  last_state_ = bytes;
  state_sent_ = true;
  if (fault(FaultKind::kLost, FaultDirection::kState) != nullptr) return;
  if (const auto* f = fault(FaultKind::kCorrupted, FaultDirection::kState))
    flip_bits(bytes, static_cast<unsigned>(f->amount));
  const auto* late = fault(FaultKind::kLate, FaultDirection::kState);
  const auto late_ticks = late != nullptr ? static_cast<std::uint64_t>(late->amount) : 0;
  state_link_.send(now_, now_ + state_delay_ticks_ + late_ticks, bytes);
}

// Wrong counts with a valid check: the fault of an encoder, not of a cable.
void SimulatedDevice::distort(StateBytes& bytes) noexcept {
  const auto* teleport = fault(FaultKind::kTeleport, FaultDirection::kState);
  const bool wild = fault(FaultKind::kWild, FaultDirection::kState) != nullptr;
  firmware::StateFrame frame;
  if ((teleport == nullptr && !wild) || firmware::decode_state(bytes, frame) != firmware::DecodeError::kNone) return;
  if (teleport != nullptr) frame.counts[0] += firmware::count_of(teleport->amount / travel_per_axis_, quantum_[0]);
  if (wild)
    for (std::int32_t& count : frame.counts) count = static_cast<std::int32_t>(random());
  firmware::encode_state(frame, bytes);
}

void SimulatedDevice::receive_state(haptics::DeviceInput& input) noexcept {
  using haptics::ReadStatus;
  if (fault(FaultKind::kUnplugged, FaultDirection::kState) != nullptr) {
    state_link_.clear();
    command_link_.clear();
    input.status = ReadStatus::kDisconnected;
  } else if (const auto arrived = state_link_.arriving(now_); arrived.empty()) {
    input.status = ReadStatus::kMissing;
  } else if (codec_.decode(arrived, sample_) != firmware::DecodeError::kNone) {
    input.status = ReadStatus::kCorrupt;
  } else {
    input.status = ReadStatus::kFresh;
    if (fault(FaultKind::kNan, FaultDirection::kState) != nullptr)
      sample_.device_from_tool.position.x = sample_.device_from_tool.rotation.w = kNan;
  }
  input.sample = sample_;
}

// Flips `count` different bits: 37 is coprime to the number of bits of a frame.
void SimulatedDevice::flip_bits(std::span<std::byte> bytes, unsigned count) noexcept {
  const std::uint64_t bits = 8 * bytes.size(), first = random() % bits;
  for (unsigned i = 0; i < count; ++i) {
    const std::uint64_t bit = (first + 37ull * i) % bits;
    bytes[bit / 8] ^= static_cast<std::byte>(1u << (bit % 8));
  }
}

// splitmix64 (Steele, Lea, Flood 2014).
std::uint64_t SimulatedDevice::random() noexcept {
  std::uint64_t z = random_state_ += 0x9e3779b97f4a7c15ull;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
  return z ^ (z >> 31);
}

}  // namespace tactus::hal
