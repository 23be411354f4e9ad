// An arm of drives on real CAN sockets: what the haptic thread asks of the kernel, held to it by the kernel; and that a
// drive's frames come whole. In the guest, on its virtual CAN buses.
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <thread>

#include "hal/device_file.h"
#include "hal/drives/drive_setup.h"
#include "hal/drives/drive_socket.h"
#include "rt/base/clock.h"
#include "tests/support/forked_trial.h"
#include "tests/support/rt_guard.h"
#include "tests/support/syscall_filter.h"
#include "tests/vm/drive_peer.h"

using namespace tactus;
using namespace tactus::test;

namespace {

constexpr std::int64_t kPeriod_ns = 1'000'000;
constexpr unsigned kWarmUp = 200, kTicks = 2000;

// The time; frames in, by one call for up to 32; frames out, by one call each; the sleep to the next tick; and the
// question of the guard that counts page faults.
constexpr long kAllowed[]{SYS_clock_gettime, SYS_recvmmsg, SYS_sendto, SYS_clock_nanosleep, SYS_getrusage};
constexpr long kWithoutSending[]{SYS_clock_gettime, SYS_recvmmsg, SYS_clock_nanosleep, SYS_getrusage};

struct Counts {
  bool filtered{false};
  std::uint64_t fresh{0}, force_ticks{0}, allocations{0}, locks{0}, faults{0}, refused{0}, not_sent{0};
  long first_refused{-1};
};

hal::DeviceProfile point_arm() {
  auto profile = hal::load_device_file("/bench/point_arm_drives.toml");
  REQUIRE(profile.ok());
  return std::move(profile).value();
}

void run_ticks(hal::DriveArm& arm, std::span<const long> allowed, Counts& counts) {
  std::optional<RtGuard> guard;
  std::int64_t deadline_ns = MonotonicClock::now_ns();
  haptics::DeviceInput input;
  haptics::DeviceCommand command;
  for (unsigned tick = 0; tick < kWarmUp + kTicks; ++tick) {
    if (tick == kWarmUp) {
      counts.filtered = install_syscall_filter(allowed);
      guard.emplace();
    }
    MonotonicClock::sleep_until_ns(deadline_ns += kPeriod_ns);
    arm.read(input);
    command.sequence = tick + 1;
    command.wanted = tick < 20 ? haptics::DeviceState::kIdle : haptics::DeviceState::kForce;
    command.wrench.force = {0.5, 0, 0};
    arm.write(command);
    if (tick < kWarmUp) continue;
    counts.fresh += input.status == haptics::ReadStatus::kFresh ? 1 : 0;
    counts.force_ticks += input.sample.state == haptics::DeviceState::kForce ? 1 : 0;
  }
  counts.allocations = guard->allocations();
  counts.locks = guard->locks();
  counts.faults = guard->minor_faults() + guard->major_faults();
  counts.refused = refused_syscalls();
  counts.first_refused = first_refused_syscall();
  counts.not_sent = arm.counters().not_sent;
}

void run_child(std::span<const long> allowed, Counts& counts) {
  REQUIRE(firmware::make_realtime(70, -1).empty());
  const hal::DeviceProfile profile = point_arm();
  std::atomic<bool> stop{false};
  vm::WholeArm peer(profile, hal::HandModel(), 1000, {"vcan0"});
  std::thread drives([&] {
    (void)firmware::make_realtime(90, -1);
    while (!stop.load()) peer.run_period();
  });
  auto buses = hal::open_drive_sockets(profile.description.drives, {"vcan0"});
  REQUIRE(buses.ok());
  REQUIRE(hal::prepare_drives(profile.description.drives, buses.value()).ok());
  hal::DriveArm arm(profile, kPeriod_ns, std::move(buses).value());
  REQUIRE(arm.start().ok());
  std::atomic<bool> done{false};
  std::thread haptic([&] {
    run_ticks(arm, allowed, counts);
    done.store(true);
    for (;;) MonotonicClock::sleep_until_ns(INT64_MAX);  // the end of a thread takes other calls
  });
  while (!done.load()) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  _exit(0);
}

Counts run_trial(std::span<const long> allowed) {
  return test::run_forked<Counts>([&](Counts& counts) { run_child(allowed, counts); });
}

}  // namespace

TEST_CASE("on a CAN socket the haptic thread receives and sends, and asks the kernel for nothing else") {
  const Counts counts = run_trial(kAllowed);
  REQUIRE(counts.filtered);
  INFO("first refused system call: " << counts.first_refused);
  CHECK(counts.refused == 0);
  CHECK(counts.allocations == 0);
  CHECK(counts.locks == 0);
  CHECK(counts.faults == 0);
  CHECK(counts.not_sent == 0);
  CHECK(counts.fresh >= kTicks - 2);
  CHECK(counts.force_ticks == kTicks);
}

TEST_CASE("without leave to send it is seen to ask for that") {
  const Counts counts = run_trial(kWithoutSending);
  REQUIRE(counts.filtered);
  CHECK(counts.first_refused == SYS_sendto);
  CHECK(counts.refused > kTicks);
}
