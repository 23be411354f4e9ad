// Arbitrary bytes as commands on the wire: decoder and controller must survive them, and the efforts of the motors stay
// inside the limits. The input is a sequence of frames, each after a byte that says how the frame is completed:
// bit 0: seal it with a right CRC and header (to get past the decoder), bit 1: e-stop, bit 2: supply lost,
// bit 3: counts from the same bytes; 0xff: no frame in this period.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>

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

void seal(std::span<std::byte, kCommandFrameSize> frame) {
  frame[0] = std::byte{kMagic};
  frame[1] = std::byte{kProtocolVersion};
  frame[2] = std::byte{2};
  frame[3] &= std::byte{3};
  frame[8] &= std::byte{1};
  std::fill(frame.begin() + 9, frame.begin() + 12, std::byte{0});
  const std::uint32_t crc = crc32c(frame.first(kCommandFrameSize - 4));
  for (std::size_t i = 0; i < 4; ++i) frame[kCommandFrameSize - 4 + i] = static_cast<std::byte>(crc >> (8 * i));
}

void require(bool holds) {
  if (!holds) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::span<const std::byte> whole(reinterpret_cast<const std::byte*>(data), size);
  StateFrame state_frame;
  CommandFrame command_frame;
  static_cast<void>(decode_state(whole, state_frame));
  static_cast<void>(decode_command(whole, command_frame));

  Controller controller(configuration());
  ControllerInputs inputs;
  for (std::size_t at = 0; at < size;) {
    const std::uint8_t dress = data[at++];
    std::array<std::byte, kMaxFrameSize> bytes{};
    const std::size_t length = dress == 0xff ? 0 : std::min(kCommandFrameSize, size - at);
    if (length > 0) std::memcpy(bytes.data(), data + at, length);
    at += length;
    const bool sealed = (dress & 1u) != 0 && length == kCommandFrameSize;
    if (sealed) seal(std::span<std::byte, kCommandFrameSize>(bytes.data(), kCommandFrameSize));
    inputs.time_us += 1000;
    inputs.emergency_stop = dress != 0xff && (dress & 2u) != 0;
    inputs.motor_bus_ok = dress == 0xff || (dress & 4u) == 0;
    if ((dress & 8u) != 0) std::memcpy(inputs.counts.data(), bytes.data() + 12, sizeof(inputs.counts));

    const ControllerOutputs outputs = controller.step(inputs, std::span<const std::byte>(bytes.data(), length));
    for (const float effort : outputs.effort) require(std::abs(effort) <= kMaxEffort);  // NaN fails as well
    if (inputs.emergency_stop) require(controller.state() == State::kBrake);
    if (controller.state() != State::kForce)
      for (const float effort : outputs.effort) require(effort == 0.0f);
    require(decode_state(outputs.state_frame, state_frame) == DecodeError::kNone);
  }
  return 0;
}
