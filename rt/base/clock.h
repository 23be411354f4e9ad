// The clock of the periodic loop: monotonic time, sleep to an absolute time, and the CPU time of the calling thread.
//
// A concept, so that tests and virtual time can provide their own. tick() itself uses no clock.
// Thread: [rt] now_ns, thread_cpu_ns; sleep_until_ns is the one blocking call of the haptic thread.
// Units: nanoseconds of CLOCK_MONOTONIC, which stops while the machine is suspended; signed, so that differences are
// signed.
#pragma once

#include <time.h>

#include <cerrno>
#include <concepts>
#include <cstdint>

namespace tactus {

template <class C>
concept Clock = requires(C clock, std::int64_t time_ns) {
  { clock.now_ns() }
  noexcept->std::same_as<std::int64_t>;
  { clock.thread_cpu_ns() }
  noexcept->std::same_as<std::int64_t>;  // CPU time of the calling thread
  { clock.sleep_until_ns(time_ns) }
  noexcept->std::same_as<void>;  // returns at once if that time has passed
};

struct MonotonicClock {
  static std::int64_t now_ns() noexcept { return read(CLOCK_MONOTONIC); }
  static std::int64_t thread_cpu_ns() noexcept { return read(CLOCK_THREAD_CPUTIME_ID); }

  // Absolute, so that a late wake-up does not delay the following ones. A signal restarts the same sleep; the loop's
  // thread blocks all signals.
  static void sleep_until_ns(std::int64_t time_ns) noexcept {
    timespec until{};
    until.tv_sec = static_cast<time_t>(time_ns / kSecond);
    until.tv_nsec = static_cast<long>(time_ns % kSecond);
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {}
  }

 private:
  static constexpr std::int64_t kSecond = 1'000'000'000;
  static std::int64_t read(clockid_t id) noexcept {
    timespec now{};
    clock_gettime(id, &now);  // cannot fail for these two clocks and a valid address
    return static_cast<std::int64_t>(now.tv_sec) * kSecond + now.tv_nsec;
  }
};

static_assert(Clock<MonotonicClock>);

}  // namespace tactus
