// The mechanics of the bench's device: simulated arm and hand as on the simulated device, with an e-stop line of the
// kernel's, and the truth about what reached the motors.
//
// One sample() is one control period: the plant moves on by the period under the efforts in force. The hand rests at
// the start of its path until the first command is accepted, so that a scene's script begins with the host.
// The truth: after each period, what happened in it that a safety figure is made of, as one line of text each:
//   state FROM TO fault=N missed=N period=N        the state machine moved
//   fade missed=N period=N                         commands are missing, the effort begins to fade
//   zero missed=N period=N                         the effort reached zero after a fade, or by BRAKE or the e-stop
//   force period=N                                 there has been effort for kSteady periods in a row
//   stop periods=N us=N                            from the edge of the e-stop line, by the kernel's stamp, to zero
//   effort
// Thread: construction [setup]; the rest the control period's. Units: SI.
#pragma once

#include <gpiod.h>

#include <cmath>
#include <cstdio>
#include <ctime>
#include <string>
#include <utility>

#include "firmware/board.h"
#include "hal/plant.h"

namespace tactus::vm {

inline std::int64_t monotonic_ns() noexcept {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec * 1'000'000'000ll + now.tv_nsec;
}

// The e-stop line: its level, and when it last became active. Without a line it is never active.
class StopLine {
 public:
  // The error in one line; empty: none.
  std::string open(const std::string& chip, unsigned offset) {
    chip_ = gpiod_chip_open_lookup(chip.c_str());
    line_ = chip_ != nullptr ? gpiod_chip_get_line(chip_, offset) : nullptr;
    if (line_ == nullptr || gpiod_line_request_both_edges_events(line_, "e-stop") != 0)
      return "no line " + std::to_string(offset) + " on GPIO chip " + chip;
    active_ = gpiod_line_get_value(line_) == 1;
    return "";
  }
  ~StopLine() {
    if (chip_ != nullptr) gpiod_chip_close(chip_);
  }

  bool active() noexcept {
    const timespec at_once{};
    for (int most = 16; line_ != nullptr && most > 0 && gpiod_line_event_wait(line_, &at_once) == 1; --most) {
      gpiod_line_event event;
      if (gpiod_line_event_read(line_, &event) != 0) break;
      const bool rose = event.event_type == GPIOD_LINE_EVENT_RISING_EDGE;
      if (rose && !active_) rose_ns_ = event.ts.tv_sec * 1'000'000'000ll + event.ts.tv_nsec;
      active_ = rose;
    }
    return active_;
  }
  std::int64_t rose_ns() const noexcept { return rose_ns_; }

 private:
  gpiod_chip* chip_{nullptr};
  gpiod_line* line_{nullptr};
  bool active_{false};
  std::int64_t rose_ns_{0};
};

class SimulatedBoard {
 public:
  SimulatedBoard(const hal::DeviceProfile& profile, const hal::HandModel& hand, const firmware::Config& config)
      : plant_(profile.plant, hand.parameters(), hand.target_at(0.0).pose, profile.kinematics),
        hand_(hand),
        quantum_(profile.quantum),
        config_(config) {}

  StopLine stop_line;
  std::uint8_t buttons{0};
  bool motor_bus_ok{true};
  std::int32_t jump{0};  // of axis 0 in the next reading, in counts

  void sample(firmware::ControllerInputs& inputs) noexcept {
    began_ns_ = monotonic_ns();
    advance();
    for (unsigned i = 0; i < hal::kAxisCount; ++i)
      inputs.counts[i] = firmware::count_of(plant_.coordinates()[i], quantum_[i]);
    inputs.counts[0] += std::exchange(jump, 0);
    inputs.time_us = static_cast<std::uint64_t>(began_ns_) / 1000;
    inputs.buttons = buttons;
    inputs.motor_bus_ok = motor_bus_ok;
    inputs.emergency_stop = stop_line.active();
  }

  void drive(const firmware::ControllerOutputs& next) noexcept { outputs_ = next; }

  // After each period: prints what happened.
  void tell(const firmware::Device& device) noexcept {
    const firmware::Controller& controller = device.controller();
    ++periods_;
    if (controller.missed_commands() == 0) hand_moves_ = true;
    const firmware::State state = controller.state();
    const bool fades = (controller.limits() & firmware::bit_of(firmware::Limit::kFading)) != 0;
    const double share = largest_share();
    largest_share_ = std::fmax(largest_share_, share);
    largest_rise_ = std::fmax(largest_rise_, share - share_);
    if (state != state_) tell_state(controller, state);
    if (fades && !fades_) std::printf("fade missed=%u period=%llu\n", controller.missed_commands(), count());
    if (share == 0.0 && share_ > 0.0)
      std::printf("zero missed=%u period=%llu\n", controller.missed_commands(), count());
    pushes_ = share > 0.0 ? pushes_ + 1 : 0;
    if (pushes_ == kSteady) std::printf("force period=%llu\n", count());
    if (share == 0.0 && stop_line.rose_ns() != told_stop_ns_) tell_stop();
    state_ = state;
    fades_ = fades;
    share_ = share;
  }

  // Effort over its limit, the worst of axes and norms; 1 is the limit.
  double share() const noexcept { return share_; }  // now
  double largest_share_seen() const noexcept { return largest_share_; }
  // The largest rise of that from one period to the next since the last question.
  double take_largest_rise() noexcept { return std::exchange(largest_rise_, 0.0); }
  std::uint64_t periods() const noexcept { return periods_; }
  const hal::Plant& plant() const noexcept { return plant_; }
  void restart_hand() noexcept { hand_periods_ = 0; }

 private:
  static constexpr unsigned kSteady = 50;
  static constexpr unsigned kSubSteps = 4;  // of the mechanics per period, as the simulated device has

  unsigned long long count() const noexcept { return periods_; }

  void advance() noexcept {
    hal::AxisVector effort{};
    for (unsigned i = 0; i < hal::kAxisCount; ++i) effort[i] = static_cast<double>(outputs_.effort[i]);
    const double h_s = config_.period_us * 1e-6 / kSubSteps;
    for (unsigned s = 1; s <= kSubSteps; ++s) {
      const double steps = static_cast<double>(hand_periods_ * kSubSteps + (hand_moves_ ? s : 0));
      plant_.step(h_s, effort, outputs_.brake, hand_.target_at(steps * h_s));
    }
    if (hand_moves_) ++hand_periods_;
  }

  double largest_share() const noexcept {
    const firmware::AxisValues& e = outputs_.effort;
    double worst = 0;
    for (unsigned i = 0; i < hal::kAxisCount; ++i)
      if (e[i] != 0.0f) worst = std::fmax(worst, static_cast<double>(std::fabs(e[i]) / config_.max_effort[i]));
    const auto norm = [&e](unsigned i) {
      return static_cast<double>(std::sqrt(e[i] * e[i] + e[i + 1] * e[i + 1] + e[i + 2] * e[i + 2]));
    };
    if (norm(0) > 0) worst = std::fmax(worst, norm(0) / static_cast<double>(config_.max_force_N));
    if (norm(3) > 0) worst = std::fmax(worst, norm(3) / static_cast<double>(config_.max_torque_Nm));
    return outputs_.brake ? 0.0 : worst;
  }

  void tell_state(const firmware::Controller& controller, firmware::State state) noexcept {
    static constexpr const char* kNames[] = {"RESET", "IDLE", "FORCE", "BRAKE"};
    std::printf("state %s %s fault=%u missed=%u period=%llu\n", kNames[static_cast<unsigned>(state_)],
                kNames[static_cast<unsigned>(state)], static_cast<unsigned>(controller.fault()),
                controller.missed_commands(), count());
  }

  // A period that began before the edge cannot have seen it.
  void tell_stop() noexcept {
    told_stop_ns_ = stop_line.rose_ns();
    const std::int64_t took_ns = monotonic_ns() - told_stop_ns_, period_ns = config_.period_us * 1000ll;
    std::printf("stop periods=%lld us=%lld\n", static_cast<long long>((took_ns + period_ns - 1) / period_ns),
                static_cast<long long>(took_ns / 1000));
  }

  hal::Plant plant_;
  hal::HandModel hand_;
  hal::AxisVector quantum_;
  firmware::Config config_;
  firmware::ControllerOutputs outputs_;
  std::uint64_t periods_{0}, hand_periods_{0}, pushes_{0};
  std::int64_t began_ns_{0}, told_stop_ns_{0};
  bool hand_moves_{false}, fades_{false};
  firmware::State state_{firmware::State::kReset};
  double share_{0}, largest_share_{0}, largest_rise_{0};
};

}  // namespace tactus::vm
