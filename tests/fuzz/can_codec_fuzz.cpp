// Any CAN frames on our identifiers, at both ends: whole frames that come out must encode, and what the host's commands
// make of the motors stays inside the limits. The input is a sequence of: a byte (bits 0 to 3 the function, bit 4 a
// look first, bit 5 lost frames first, bits 6 and 7 how the length differs from eight) and the data.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>

#include "firmware/can_codec.h"
#include "firmware/controller.h"

using namespace tactus::firmware;

namespace {

constexpr float kMaxEffort = 30.0f;

Config configuration() {
  Config config;
  config.quantum.fill(1e-5f);
  config.max_effort.fill(kMaxEffort);
  config.max_speed.fill(2.0f);
  config.max_force_N = config.max_torque_Nm = 35.0f;
  return config;
}

void require(bool holds) {
  if (!holds) std::abort();
}

// The host's end: whatever a device sends.
void check(const StateFrame& frame) {
  std::array<std::byte, kStateFrameSize> bytes;
  encode_state(frame, bytes);
  StateFrame again;
  require(decode_state(bytes, again) == DecodeError::kNone && again == frame);
  for (const std::int32_t count : frame.counts) require(count >= -kMaxCanCount - 1 && count <= kMaxCanCount);
}

// The device's end: whatever a host sends.
struct FuzzedDevice {
  Controller controller{configuration()};
  ControllerInputs inputs;

  void step(const CommandFrame& command) {
    std::array<std::byte, kCommandFrameSize> bytes;
    encode_command(command, bytes);
    inputs.time_us += 1000;
    const ControllerOutputs outputs = controller.step(inputs, bytes);
    for (const float effort : outputs.effort) require(std::abs(effort) <= kMaxEffort);  // NaN fails as well
    check_states(outputs);
  }

  StateSplitter splitter;
  StateAssembler assembler{1000};
  void check_states(const ControllerOutputs& outputs) {
    StateFrame sent, received;
    require(decode_state(outputs.state_frame, sent) == DecodeError::kNone);
    std::array<CanFragment, kStateFragments + 1> fragments;
    const unsigned count = splitter.split(sent, fragments);
    bool whole = false;
    for (unsigned i = 0; i < count; ++i) whole |= assembler.accept(fragments[i].function, fragments[i].data, received);
    require(whole && received.counts == sent.counts && received.state == sent.state && received.fault == sent.fault);
  }
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  StateAssembler states(1000);
  CommandAssembler commands;
  FuzzedDevice device;
  StateFrame state;
  CommandFrame command;
  for (std::size_t at = 0; at < size;) {
    const std::uint8_t how = data[at++];
    std::array<std::byte, 64> bytes{};
    constexpr std::array<std::size_t, 4> lengths{kClassicSize, kClassicSize, 5, 64};
    const std::size_t length = std::min(lengths[how >> 6], size - at);
    if (length > 0) std::memcpy(bytes.data(), data + at, length);
    at += length;
    const auto function = static_cast<CanFunction>(how & 0xfu);
    const auto frame = std::span<const std::byte>(bytes).first(length);
    if ((how & 0x10u) != 0) {
      states.look();
      commands.look();
    }
    if ((how & 0x20u) != 0) {
      states.forget();
      commands.forget();
    }
    if (states.accept(function, frame, state)) check(state);
    if (commands.accept(function, frame, command)) device.step(command);
    (void)unpad_fd(frame, kFdStateSize, kStateFrameSize);
    states.sent(command.sequence);
  }
  return 0;
}
