// One period of the haptic thread, as it ships. Used by the real-time run, the virtual run and the system tests (system
// calls, allocations, locks, page faults, cuts).
//
//   lines: probe high     for an oscilloscope
//   read                  the device's newest sample
//   compute               HapticLoop::tick, cut at kCutShare of the period
//   write                 the command to the device
//   lines: enable, heartbeat, probe low
//   judge                 missed its deadline? cause?
//
// Thread: construction, cut_at() [setup]; operator() [rt], by one thread. Units: ns of `Clock`. Bound: read() and
// write() by the device's contract, compute() by the governor and the cut, the lines by theirs. Reads the clock three
// times, and once more per sweep; the thread's CPU time once, and once more after an overrun. These measurements affect
// the physics only through the cut.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <type_traits>

#include "rt/base/clock.h"
#include "rt/loop/haptic_driver.h"
#include "rt/loop/run_stats.h"
#include "rt/loop/tick_probe.h"
#include "rt/thread/timing.h"

namespace tactus::loop {

// The cut fires after this share of the period; the rest is for the relax sweep in reserve and for the device.
inline constexpr double kCutShare = 0.85;

// Clock of a run without time measurement: no deadline is ever missed.
struct VirtualClock {
  static std::int64_t now_ns() noexcept { return 0; }
  static std::int64_t thread_cpu_ns() noexcept { return 0; }
};

// A loop without GPIO lines.
struct NoLines {
  static bool estop() noexcept { return false; }
  static void enable(bool) noexcept {}
  static void probe(bool) noexcept {}
  static void heartbeat() noexcept {}
};

// Times of one period.
struct TickAccount {
  std::int64_t compute_ns{0}, device_ns{0};  // device: read and write
  std::optional<OverrunCause> overrun;       // empty: the period ended before its deadline
};

template <haptics::HapticDevice Device, class Lines = NoLines, class Clock = MonotonicClock>
class TimedTick {
 public:
  // `lines` and `probe` may be null.
  TimedTick(HapticDriver<Device>& driver, std::int64_t period_ns, Lines* lines = nullptr,
            TickProbe* probe = nullptr) noexcept
      : driver_(driver), lines_(lines), probe_(probe), period_ns_(period_ns) {}

  std::int64_t period_ns() const noexcept { return period_ns_; }

  // Cuts every tick at this sweep, in addition to the deadline's cut: for tests of cuts.
  void cut_at(std::uint32_t sweep) noexcept { cut_sweep_ = sweep; }

  // `operator_bits()`: the operator's requests for this tick (OperatorBit); called once, after the device is read.
  template <class OperatorBits>
  TickAccount operator()(const TickTiming& timing, OperatorBits&& operator_bits) noexcept {
    const std::int64_t cpu_began_ns = Clock::thread_cpu_ns();
    if (lines_ != nullptr) lines_->probe(true);
    driver_.read();
    const std::int64_t read_ns = Clock::now_ns();
    if (probe_ != nullptr) probe_->read_done(read_ns);

    const std::uint32_t emergency_stop = lines_ != nullptr && lines_->estop() ? kEmergencyStopLine : 0u;
    Deadline deadline{timing.scheduled_ns + static_cast<std::int64_t>(kCutShare * static_cast<double>(period_ns_)),
                      cut_sweep_, probe_};
    const TickOutput& out = driver_.compute(operator_bits() | emergency_stop, {&Deadline::passed, &deadline},
                                            probe_ != nullptr ? probe_->stages() : StageObserver{});
    const std::int64_t computed_ns = Clock::now_ns();

    driver_.write();
    if (lines_ != nullptr) show_on_lines(out);
    const std::int64_t wrote_ns = Clock::now_ns();
    if (probe_ != nullptr) complete_record(out, computed_ns, wrote_ns);
    if constexpr (!std::is_same_v<Clock, VirtualClock>) record_times(timing, read_ns, computed_ns, wrote_ns);
    return {.compute_ns = computed_ns - read_ns,
            .device_ns = (read_ns - timing.woke_ns) + (wrote_ns - computed_ns),
            .overrun = judge(timing, cpu_began_ns, wrote_ns)};
  }

 private:
  struct Deadline {
    std::int64_t cut_ns{0};
    std::uint32_t cut_sweep{physics::kNeverCut};
    TickProbe* probe{nullptr};

    static bool passed(void* self, std::uint32_t sweep) noexcept {
      const auto& deadline = *static_cast<const Deadline*>(self);
      const std::int64_t now_ns = Clock::now_ns();
      if (deadline.probe != nullptr) deadline.probe->sweep_begins(now_ns);
      return now_ns > deadline.cut_ns || sweep >= deadline.cut_sweep;
    }
  };

  // Enables the drives while force is wanted; a fault disables them together with the command that brakes.
  void show_on_lines(const TickOutput& out) noexcept {
    lines_->enable(out.command.wanted == haptics::DeviceState::kForce);
    lines_->heartbeat();
    lines_->probe(false);
  }

  void record_times(const TickTiming& timing, std::int64_t read_ns, std::int64_t computed_ns,
                    std::int64_t wrote_ns) noexcept {
    driver_.record_times({.tick = driver_.output().tick,
                          .woke_ns = timing.woke_ns,
                          .wake_ns = duration(timing.scheduled_ns, timing.woke_ns),
                          .read_ns = duration(timing.woke_ns, read_ns),
                          .compute_ns = duration(read_ns, computed_ns),
                          .write_ns = duration(computed_ns, wrote_ns)});
  }
  // At most 4.29 s.
  static std::uint32_t duration(std::int64_t from_ns, std::int64_t to_ns) noexcept {
    return static_cast<std::uint32_t>(std::clamp<std::int64_t>(to_ns - from_ns, 0, UINT32_MAX));
  }

  void complete_record(const TickOutput& out, std::int64_t computed_ns, std::int64_t wrote_ns) noexcept {
    TickTimes& times = probe_->times();
    times.predicted_ns = static_cast<std::int64_t>(driver_.plan().predicted_ns);
    times.members = out.members;
    times.contacts = out.contacts;
    times.points = out.points;
    times.border = out.border;
    times.sub_steps = driver_.sub_steps();
    probe_->end(computed_ns, wrote_ns);
  }

  std::optional<OverrunCause> judge(const TickTiming& timing, std::int64_t cpu_began_ns,
                                    std::int64_t ended_ns) const noexcept {
    if (ended_ns <= timing.scheduled_ns + period_ns_) return std::nullopt;
    const auto wake_late_ns = static_cast<double>(timing.woke_ns - timing.scheduled_ns);
    const auto used_ns = static_cast<double>(Clock::thread_cpu_ns() - cpu_began_ns);
    return classify_overrun(wake_late_ns, used_ns, driver_.plan().predicted_ns, static_cast<double>(period_ns_));
  }

  HapticDriver<Device>& driver_;
  Lines* lines_;
  TickProbe* probe_;
  std::int64_t period_ns_;
  std::uint32_t cut_sweep_{physics::kNeverCut};
};

}  // namespace tactus::loop
