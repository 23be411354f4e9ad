// Pace of a run in virtual time, as requested by its operator: stopped, by single ticks or cycles, or at a pace.
//
// A run in real time has no Pacing. No result depends on the pace: a tick is the same whenever it is computed.
// Thread: written by the control socket's thread; read by the one that ticks. Bound: each value by itself.
#pragma once

#include <atomic>
#include <cstdint>

namespace tactus::service {

inline constexpr double kMinPace = 0.01, kMaxPace = 100;

struct Pacing {
  std::atomic<bool> playing{true};
  std::atomic<double> pace{0};           // times real time; 0: as fast as it goes
  std::atomic<std::uint32_t> ticks{0};   // single ones that were requested and are not done
  std::atomic<std::uint32_t> cycles{0};  // same
};

}  // namespace tactus::service
