// A link whose other end is in the same process: the whole firmware on simulated mechanics, one control period per
// receive(). For code that needs a device on a link without hardware; the bytes are the same as on a cable.
//
// receive(): the mechanics advance one period under the present efforts, the device runs its period with the command
// from the last send(), and its state frame is returned. So the device sees a command one tick after it was sent, and
// no state is ever superseded. Device time advances with receive() only. Faults are switched on and off by function
// calls (SimulatedDevice has a fault script by tick instead). Thread: construction [setup]; receive(), send() [rt], no
// allocation, bounded, no lock except against call() of another thread; the fault switches by the same thread, or while
// no thread receives. Frame: the device's. Units: SI. Deterministic: the same calls give the same bits, except
// arrival_ns with Stamp::kClock.
#pragma once

#include <algorithm>
#include <atomic>
#include <utility>

#include "firmware/board.h"
#include "hal/frame_link.h"
#include "hal/plant.h"
#include "hal/told_idle.h"
#include "rt/base/clock.h"

namespace tactus::hal {

class LoopbackLink {
 public:
  // Source of arrival_ns: simulated time since construction (periods x period_ns), or CLOCK_MONOTONIC as on a real
  // link.
  enum class Stamp : std::uint8_t { kPeriods, kClock };

  LoopbackLink(const DeviceProfile& profile, const HandModel& hand, std::int64_t period_ns,
               Stamp stamp = Stamp::kPeriods)
      : config_(firmware_config(profile, static_cast<std::uint32_t>(period_ns / 1000))),
        mechanics_(profile, hand, period_ns),
        device_(told_idle(config_, mechanics_.counts())),
        period_ns_(period_ns),
        stamp_(stamp) {}

  // --- FrameLink
  ReceivedFrame receive(std::span<std::byte, firmware::kMaxFrameSize> buffer) noexcept {
    if (powered_) {
      const Turn turn(busy_);
      firmware::run_period(device_, mechanics_, wire_);
    }
    ++periods_;
    const bool arrives = powered_ && plugged_ && dropped_states_ == 0;
    if (dropped_states_ > 0) --dropped_states_;
    if (!arrives) return {};
    std::copy(wire_.state.begin(), wire_.state.end(), buffer.begin());
    if (corrupted_states_ > 0) {
      --corrupted_states_;
      buffer[17] ^= std::byte{0x10};
    }
    ++counters_.received;
    const std::int64_t virtual_ns = static_cast<std::int64_t>(periods_) * period_ns_;
    return {wire_.state.size(), stamp_ == Stamp::kClock ? MonotonicClock::now_ns() : virtual_ns, 0};
  }

  bool send(std::span<const std::byte> frame) noexcept {
    if (!connected() || frame.size() > wire_.command.size()) {
      ++counters_.send_failed;
      return false;
    }
    ++counters_.sent;
    if (dropped_commands_ > 0) {
      --dropped_commands_;
      return true;
    }
    if (wire_.command_size > 0) ++counters_.send_superseded;
    std::copy(frame.begin(), frame.end(), wire_.command.begin());
    if (corrupted_commands_ > 0) {
      --corrupted_commands_;
      wire_.command[13] ^= std::byte{0x10};
    }
    wire_.command_size = frame.size();
    return true;
  }

  bool connected() const noexcept { return plugged_ && powered_; }
  LinkCounters counters() const noexcept { return counters_; }

  Result<firmware::ServiceMessage> call(const firmware::ServiceMessage& request, std::chrono::milliseconds) {
    if (!connected()) return Status::error("loopback: the device is unplugged; plug it in");
    const Turn turn(busy_);
    return device_.serve(request);
  }

  // --- Faults
  void set_plugged(bool plugged) noexcept {
    if (plugged_ && !plugged) {
      ++counters_.disconnects;
      wire_.command_size = 0;
    }
    plugged_ = plugged;
  }
  // Off: the device's program ends and the mechanics stop. On: the program restarts, motors shorted, and refuses FORCE
  // until it has received an IDLE command.
  void set_powered(bool powered) noexcept {
    if (powered && !powered_) {
      device_ = firmware::Device(config_);
      wire_.command_size = 0;
    }
    if (powered_ && !powered) {
      ++counters_.disconnects;
      mechanics_.drive({});
    }
    powered_ = powered;
  }
  void set_emergency_stop(bool active) noexcept { mechanics_.emergency_stop = active; }
  void set_motor_bus(bool good) noexcept { mechanics_.motor_bus_ok = good; }
  void set_buttons(std::uint8_t buttons) noexcept { mechanics_.buttons = buttons; }
  // The next `count` frames of a direction are lost, or have a flipped bit.
  void drop_states(unsigned count) noexcept { dropped_states_ = count; }
  void drop_commands(unsigned count) noexcept { dropped_commands_ = count; }
  void corrupt_states(unsigned count) noexcept { corrupted_states_ = count; }
  void corrupt_commands(unsigned count) noexcept { corrupted_commands_ = count; }

  // --- The exact simulated state
  std::uint64_t periods() const noexcept { return periods_; }
  const Plant& plant() const noexcept { return mechanics_.plant; }
  const firmware::Device& device() const noexcept { return device_; }
  const firmware::ControllerOutputs& motor_outputs() const noexcept { return mechanics_.outputs; }

 private:
  static constexpr unsigned kSubSteps = 4;  // of the mechanics per period, as the simulated device's default

  struct SimulatedMechanics {
    Plant plant;
    HandModel hand;
    AxisVector quantum;
    double sub_step_s;
    std::int64_t period_ns;
    std::uint64_t samples{0};
    firmware::ControllerOutputs outputs;
    std::uint8_t buttons{0};
    bool emergency_stop{false}, motor_bus_ok{true};

    SimulatedMechanics(const DeviceProfile& profile, const HandModel& a_hand, std::int64_t a_period_ns)
        : plant(profile.plant, a_hand.parameters(), a_hand.target_at(0.0).pose, profile.kinematics),
          hand(a_hand),
          quantum(profile.quantum),
          sub_step_s(static_cast<double>(a_period_ns) * 1e-9 / kSubSteps),
          period_ns(a_period_ns) {}

    void sample(firmware::ControllerInputs& inputs) noexcept {
      if (samples > 0) advance();
      inputs.counts = counts();
      inputs.time_us = samples++ * static_cast<std::uint64_t>(period_ns) / 1000;
      inputs.buttons = buttons;
      inputs.emergency_stop = emergency_stop;
      inputs.motor_bus_ok = motor_bus_ok;
    }

    firmware::AxisCounts counts() const noexcept {
      firmware::AxisCounts counts{};
      for (unsigned i = 0; i < kAxisCount; ++i) counts[i] = firmware::count_of(plant.coordinates()[i], quantum[i]);
      return counts;
    }

    void drive(const firmware::ControllerOutputs& next) noexcept { outputs = next; }

    void advance() noexcept {
      AxisVector effort{};
      for (unsigned i = 0; i < kAxisCount; ++i) effort[i] = static_cast<double>(outputs.effort[i]);
      for (unsigned s = 1; s <= kSubSteps; ++s) {
        const auto sub_steps = static_cast<double>((samples - 1) * kSubSteps + s);
        plant.step(sub_step_s, effort, outputs.brake, hand.target_at(sub_steps * sub_step_s));
      }
    }
  };

  // Spin lock between a period and a service request: a request is served between two periods; the wait is at most one.
  class Turn {
   public:
    explicit Turn(std::atomic_flag& busy) noexcept : busy_(busy) {
      while (busy_.test_and_set(std::memory_order_acquire)) {}
    }
    ~Turn() { busy_.clear(std::memory_order_release); }
    Turn(const Turn&) = delete;
    Turn& operator=(const Turn&) = delete;

   private:
    std::atomic_flag& busy_;
  };

  // The device's end.
  struct Wire {
    std::array<std::byte, firmware::kStateFrameSize> state{};
    std::array<std::byte, firmware::kMaxFrameSize> command{};
    std::size_t command_size{0};

    std::size_t receive_command(std::span<std::byte, firmware::kMaxFrameSize> buffer) noexcept {
      std::copy(command.begin(), command.end(), buffer.begin());
      return std::exchange(command_size, 0);
    }
    void send_state(std::span<const std::byte> frame) noexcept {
      std::copy_n(frame.begin(), std::min(frame.size(), state.size()), state.begin());
    }
    bool receive_service(firmware::ServiceMessage&) noexcept { return false; }  // call() calls the device directly
    void reply_service(const firmware::ServiceMessage&) noexcept {}
  };

  std::atomic_flag busy_;
  firmware::Config config_;
  SimulatedMechanics mechanics_;
  firmware::Device device_;
  Wire wire_;
  std::int64_t period_ns_;
  Stamp stamp_;
  LinkCounters counters_;
  std::uint64_t periods_{0};
  unsigned dropped_states_{0}, dropped_commands_{0}, corrupted_states_{0}, corrupted_commands_{0};
  bool plugged_{true}, powered_{true};
};

static_assert(FrameLink<LoopbackLink>);

}  // namespace tactus::hal
