// The haptic thread after start: no allocation, no lock, no page fault. Counted, with counters that are shown to fire.
#include <cstdlib>
#include <mutex>

#include "rt/loop/timed_tick.h"
#include "tests/support/rt_guard.h"
#include "tests/support/skip.h"
#include "tests/system/session_bench.h"

using namespace tactus;
using namespace tactus::test;

TEST_CASE("a hundred thousand ticks of the haptic thread allocate nothing, lock nothing and fault no page") {
  TACTUS_NEEDS(RtGuard::available(), "counting allocations needs a build without a sanitizer");
  session::RunOptions options = virtual_options();
  options.members = 4;  // so that members come and go and there is a border
  options.inject = "reset@5000,reset@50000";
  auto session = make_session(scene_file("domino_row.toml"), options);
  REQUIRE(session->record("").ok());
  sim::SnapshotServer server(*session->global, *session->exchange);
  server.publish_first();
  loop::TimedTick<hal::AnyDevice, loop::NoLines, loop::VirtualClock> timed_tick(*session->driver, 0);
  std::uint64_t allocations = 0, frees = 0, locks = 0, faults = 0;
  // Code comes from its file page by page when it first runs; a real run has locked it all before it starts. So every
  // path of a tick has to have run once: until then the hand has been through its motion.
  constexpr std::uint64_t kTicks = 100'000, kWarmUp = 20'000;
  for (std::uint64_t tick = 0; tick < kTicks + kWarmUp; ++tick) {
    server.serve();
    {
      RtGuard guard;
      timed_tick({}, [&]() noexcept { return session->operator_bits(); });
      session->count_tick();
      if (tick >= kWarmUp) {
        allocations += guard.allocations();
        frees += guard.frees();
        locks += guard.locks();
        faults += guard.minor_faults() + guard.major_faults();
      }
    }
    if (tick % 64 == 0) session->drain->drain();
  }
  CHECK(allocations == 0);
  CHECK(frees == 0);
  CHECK(locks == 0);
  CHECK(faults == 0);
  CHECK(session->stats.cycles > kTicks / 11);
  CHECK(session->stats.contact_ticks > 1000);
}

TEST_CASE("the guard that counts them does fire in this program") {
  TACTUS_NEEDS(RtGuard::available(), "counting allocations needs a build without a sanitizer");
  const volatile std::size_t size = 100;
  RtGuard guard;
  void* volatile memory = std::malloc(size);  // volatile: the compiler may not drop the pair
  std::mutex mutex;
  mutex.lock();
  mutex.unlock();
  std::free(memory);
  const auto allocations = guard.allocations(), frees = guard.frees(), locks = guard.locks();
  CHECK(allocations == 1);
  CHECK(frees == 1);
  CHECK(locks == 1);
}
