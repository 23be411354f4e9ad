// A Falcon without hardware: the FTDI chip, the boot program, the firmware's packets, and the plant in a hand.
//
// SimulatedFalconPort is the other end of falcon_start.h and of the exchange; SimulatedFalcon is a device on it, in the
// caller's thread: one read() is one period. Thread: construction [setup]; the rest by one thread, no allocation in the
// exchange. Units: SI. Deterministic.
#pragma once

#include "hal/falcon/falcon_logic.h"
#include "hal/falcon/falcon_start.h"
#include "hal/plant.h"

namespace tactus::hal {

struct FalconFaults {
  unsigned failed_handshakes{0};  // the boot program does not answer so many greetings
  unsigned wrong_echoes{0};       // so many bytes of the image come back wrong
  bool mute{false};               // no answer any more
  bool garbage{false};            // before each packet
  bool cut_packets{false};        // the last two characters are missing
  bool twice{false};              // two answers
  bool unplugged{false};
  std::uint8_t homed{7};
};

class SimulatedFalconPort final : public FalconPort {
 public:
  SimulatedFalconPort(const HandModel& hand, double gain_per_Nm, std::int64_t period_ns, bool loaded);

  bool control(FtdiRequest request, std::uint16_t value) noexcept override;
  bool write(std::span<const std::uint8_t> bytes) noexcept override;
  int read(std::span<std::uint8_t> bytes, std::chrono::milliseconds longest) noexcept override;

  // One period of the mechanics passes.
  void advance() noexcept;
  Vec3d force() const noexcept;  // of the motors at the tool, device frame
  // The hand's path begins now.
  void restart_hand() noexcept { time_s_ = 0; }
  // The host's last packet switched the green light on: there is force.
  bool green() const noexcept { return green_; }
  const Plant& plant() const noexcept { return plant_; }
  std::size_t image_bytes() const noexcept { return image_bytes_; }
  FalconFaults faults;

 private:
  enum class Program : std::uint8_t { kBoot, kLoading, kRunning };
  void hear(std::uint8_t byte) noexcept;
  void answer() noexcept;
  void put(std::uint8_t byte) noexcept;

  HandModel hand_;
  Plant plant_;
  double gain_per_Nm_, period_s_, time_s_{0};
  bool green_{false};
  Program program_;
  std::uint16_t divisor_{0};
  std::array<std::uint8_t, 3> greeting_{};
  std::size_t image_bytes_{0};
  FalconBytes request_{};
  std::size_t request_size_{0};
  std::array<std::int16_t, 3> motors_{};
  std::array<std::uint8_t, 256> queue_{};
  std::size_t first_{0}, size_{0};
};

class SimulatedFalcon {
 public:
  // `gain_per_Nm`: what the host takes the motors' gain for, which is kFalconGain.
  SimulatedFalcon(const HandModel& hand, std::int64_t period_ns, double gain_per_Nm = kFalconGain)
      : port_(hand, kFalconGain, period_ns, true), logic_(gain_per_Nm, period_ns) {
    FalconState state;
    if (exchange_falcon(port_, {}, scanner_, state, std::chrono::milliseconds(1))) state_ = state;
  }

  const haptics::DeviceProperties& properties() const noexcept { return logic_.properties(); }
  void read(haptics::DeviceInput& input) noexcept {
    port_.advance();
    const bool fresh = exchange_falcon(port_, logic_.request(), scanner_, state_, std::chrono::milliseconds(1));
    logic_.read(fresh ? &state_ : nullptr, !port_.faults.unplugged, logic_.commanded(), input);
  }
  void write(const haptics::DeviceCommand& command) noexcept { logic_.write(command); }

  Vec3d force() const noexcept { return port_.force(); }
  SimulatedFalconPort& port() noexcept { return port_; }

 private:
  SimulatedFalconPort port_;
  FalconLogic logic_;
  FalconScanner scanner_;
  FalconState state_;
};

static_assert(haptics::HapticDevice<SimulatedFalcon>);

}  // namespace tactus::hal
