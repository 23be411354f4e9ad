// The haptic thread of the tests on makers' libraries: one read and one write per period, until a condition holds.
#pragma once

#include <catch2/catch.hpp>
#include <chrono>
#include <functional>
#include <thread>

#include "hal/sdk/sdk_device.h"

namespace tactus::test {

inline constexpr std::int64_t kSdkPeriod_ns = 1'000'000;
// Periods until a wait fails: 20 s at 1 kHz; the event comes within milliseconds.
inline constexpr unsigned kSdkPatience = 20'000;

struct SdkLoop {
  hal::SdkDevice& device;
  haptics::DeviceInput input{};
  haptics::DeviceCommand command{};

  // False: `done` did not hold within kSdkPatience periods.
  bool until(const std::function<bool()>& done, bool writes = true) {
    for (unsigned i = 0; i < kSdkPatience; ++i) {
      device.read(input);
      ++command.sequence;
      if (writes) device.write(command);
      if (done()) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return false;
  }
  // Commands `force_N` until the device is in FORCE and `forces_on`, of the stand-in, is set.
  bool push(const Vec3d& force_N, const std::atomic<bool>& forces_on) {
    command.wanted = haptics::DeviceState::kForce;
    command.wrench.force = force_N;
    return until([&] { return input.sample.state == haptics::DeviceState::kForce && forces_on; });
  }
  bool is_fresh() {
    return until([&] { return input.status == haptics::ReadStatus::kFresh; });
  }
  // Reads without a fresh sample, five in succession. After 50 ms without one the device counts as disconnected, on a
  // slow machine before the fifth read.
  bool misses_five() {
    unsigned missing = 0;
    return until([&] {
      missing = input.status != haptics::ReadStatus::kFresh ? missing + 1 : 0;
      return missing >= 5;
    });
  }
  bool latches(std::uint32_t fault) {
    return until([&] { return input.sample.device_fault == fault; });
  }
  bool rearms() {
    command.wanted = haptics::DeviceState::kIdle;
    command.rearm = 1;
    const bool idle = until([&] { return input.sample.state == haptics::DeviceState::kIdle; });
    command.rearm = 0;
    return idle;
  }
};

}  // namespace tactus::test
