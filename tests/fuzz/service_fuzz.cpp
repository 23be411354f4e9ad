// Any bytes are what a host sends to a device: requests and command frames, among encoders, sensors and lines that do
// anything. The device must survive, its configuration must stay one that makes sense, and what reaches the motors
// stays inside the limits that are in force. The input is a sequence of periods; the first byte of each says what
// comes: bit 0: a request as it stands, bit 1: the same with a right head and CRC, bit 2: a command, sealed, bit 3: as
// it stands, bit 4: encoders and index pulses, bit 5: temperatures, bit 6: e-stop or supply, bit 7: a register that
// exists.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>

#include "firmware/device.h"
#include "firmware/little_endian.h"

using namespace tactus::firmware;

namespace {

void require(bool holds) {
  if (!holds) std::abort();
}

DeviceConfig configuration() {
  DeviceConfig config;
  config.control.quantum.fill(1e-5f);
  config.control.max_effort.fill(30.0f);
  config.control.max_speed.fill(2.0f);
  config.control.max_force_N = config.control.max_torque_Nm = 35.0f;
  config.gravity.amplitude.fill(2.0f);
  config.gravity.combination.fill(0x1012345u);
  config.gravity.in_idle = 1;
  config.encoders.index_axes = kAllAxes;
  config.encoders.index_distance.fill(1000);
  config.thermal.gain_K_per_effort2.fill(1);
  config.thermal.time_constant_s.fill(1);
  config.thermal.warning_K.fill(50);
  config.thermal.limit_K.fill(100);
  return config;
}

// Reads on past the end as zeros.
class Bytes {
 public:
  Bytes(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}
  bool empty() const { return at_ >= size_; }
  template <class T>
  T take() {
    T value{};
    const std::size_t n = std::min(sizeof(T), size_ - std::min(at_, size_));
    if (n > 0) std::memcpy(&value, data_ + at_, n);
    at_ += sizeof(T);
    return value;
  }

 private:
  const std::uint8_t* data_;
  std::size_t size_, at_{0};
};

void ask(Device& device, Bytes& bytes, unsigned what) {
  auto raw = bytes.take<std::array<std::byte, kServiceFrameSize>>();
  if ((what & 2u) != 0) {
    raw[0] = std::byte{kMagic};
    raw[1] = std::byte{kProtocolVersion};
    raw[2] = std::byte{3};
    raw[3] = std::byte{0};
    const auto rows = all_registers();
    const auto& row = rows[std::to_integer<std::size_t>(raw[6]) % rows.size()];
    const unsigned number = row.number + std::to_integer<unsigned>(raw[7]) % row.count;
    if ((what & 128u) != 0) put<std::uint16_t>(raw, 6, static_cast<std::uint16_t>(number));
    put<std::uint32_t>(raw, 12, crc32c(std::span(raw).first(12)));
  }
  ServiceMessage request;
  if (decode_service(raw, ServiceDirection::kRequest, request) != DecodeError::kNone) return;
  const State before = device.controller().state();
  const ServiceMessage reply = device.serve(request);
  require(reply.tag == request.tag && reply.address == request.address);
  require(device.controller().state() == before);
  require(is_valid(device.config()));
}

std::size_t make_command(Bytes& bytes, unsigned what, std::array<std::byte, kMaxFrameSize>& frame) {
  if ((what & 12u) == 0) return 0;
  const auto raw = bytes.take<std::array<std::byte, kCommandFrameSize>>();
  std::copy(raw.begin(), raw.end(), frame.begin());
  if ((what & 4u) == 0) return kCommandFrameSize;
  CommandFrame command;
  command.wanted = static_cast<State>(1 + std::to_integer<unsigned>(raw[3]) % 3);
  command.rearm = (std::to_integer<unsigned>(raw[8]) & 1u) != 0;
  command.sequence = get<std::uint32_t>(raw, 4);
  for (unsigned i = 0; i < kAxes; ++i) command.effort[i] = std::bit_cast<float>(get<std::uint32_t>(raw, 12 + 4 * i));
  encode_command(command, std::span<std::byte, kCommandFrameSize>(frame.data(), kCommandFrameSize));
  return kCommandFrameSize;
}

void check(const Device& device, const ControllerInputs& inputs, const ControllerOutputs& outputs) {
  const Config& config = device.controller().config();
  for (unsigned first = 0; first < kAxes; first += 3) {
    double norm2 = 0;
    for (unsigned i = first; i < first + 3; ++i) {
      require(std::abs(outputs.effort[i]) <= config.max_effort[i]);  // NaN fails as well
      norm2 += static_cast<double>(outputs.effort[i]) * static_cast<double>(outputs.effort[i]);
    }
    const double limit = static_cast<double>(first == 0 ? config.max_force_N : config.max_torque_Nm);
    require(std::sqrt(norm2) <= limit * (1.0 + 1e-5) + 1e-30);
  }
  const State state = device.controller().state();
  const bool quiet = state == State::kReset || state == State::kBrake;
  require(outputs.brake == quiet);
  for (const float effort : outputs.effort) require(!quiet || effort == 0.0f);
  require(!inputs.emergency_stop || state == State::kBrake);
  for (const float share : device.thermal().effort_share()) require(share >= 0.0f && share <= 1.0f);
  for (const float speed : device.speed()) require(std::isfinite(speed));
  StateFrame frame;
  require(decode_state(outputs.state_frame, frame) == DecodeError::kNone);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Bytes bytes(data, size);
  Device device(configuration());
  DeviceConfig restored = configuration();
  if (read_config_block({reinterpret_cast<const std::byte*>(data), size}, restored)) require(is_valid(restored));
  ControllerInputs inputs;
  while (!bytes.empty()) {
    const auto what = bytes.take<std::uint8_t>();
    if ((what & 3u) != 0) ask(device, bytes, what);
    std::array<std::byte, kMaxFrameSize> frame{};
    const std::size_t length = make_command(bytes, what, frame);
    inputs.time_us += 1000;
    inputs.index_edges = inputs.encoder_errors = 0;
    if ((what & 16u) != 0) {
      for (auto& count : inputs.counts) count += bytes.take<std::int16_t>();
      inputs.index_edges = bytes.take<std::uint8_t>();
      inputs.encoder_errors = bytes.take<std::uint8_t>();
      for (auto& count : inputs.index_counts) count = bytes.take<std::int32_t>();
    }
    if ((what & 32u) != 0)
      for (auto& rise : inputs.measured_rise_K) rise = bytes.take<float>();  // a broken sensor: NaN as well
    const auto lines = (what & 64u) != 0 ? bytes.take<std::uint8_t>() : std::uint8_t{0};
    inputs.emergency_stop = (lines & 1u) != 0;
    inputs.motor_bus_ok = (lines & 2u) == 0;

    const ControllerOutputs outputs = device.step(inputs, std::span<const std::byte>(frame).first(length));
    check(device, inputs, outputs);
    if (!device.block_to_store().empty()) {
      require(read_config_block(device.block_to_store(), restored));
      device.stored((lines & 4u) == 0);
    }
  }
  return 0;
}
