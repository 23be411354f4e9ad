#include "rt/haptics/coupling/world_lateness.h"

#include <catch2/catch.hpp>

using namespace tactus;
using haptics::WorldLateness;

namespace {
constexpr std::uint32_t kRatio = 8;
constexpr double kPeriod_s = 1e-3;
WorldLateness in_tick(std::uint32_t tick) { return WorldLateness::in_tick(tick, kRatio, kPeriod_s); }
}  // namespace

TEST_CASE("a world that is in time changes nothing") {
  for (std::uint32_t tick = 0; tick < kRatio; ++tick) {
    const WorldLateness late = in_tick(tick);
    CHECK(late.ticks == 0);
    CHECK(late.surface_share == 1);
    CHECK(late.ghost_share == 1);
    CHECK(late.force_scale == 1);
    CHECK(late.status == 0);
  }
}

TEST_CASE("outside velocities fade evenly over a cycle, the ghosts' shares multiply to the same") {
  double ghosts = 1;
  for (std::uint32_t tick = kRatio; tick < 3 * kRatio; ++tick) {
    const WorldLateness late = in_tick(tick);
    const double expected = std::max(0.0, 1.0 - (tick - kRatio + 1.0) / kRatio);
    ghosts *= late.ghost_share;
    CHECK(late.surface_share == Approx(expected).margin(1e-15));
    CHECK(ghosts == Approx(expected).margin(1e-15));
    CHECK((late.status & kWorldLate) != 0);
    CHECK(late.force_scale == 1);
  }
}

TEST_CASE("past four cycles the border stands still") {
  CHECK_FALSE(in_tick(kRatio - 1 + 4 * kRatio).border_frozen());
  CHECK(in_tick(kRatio + 4 * kRatio).border_frozen());
}

TEST_CASE("past 100 ms the force fades to nothing over ten ticks, at any rate") {
  for (const double period_s : {1e-3, 2.5e-4}) {
    const auto ticks = static_cast<std::uint32_t>(0.1 / period_s + 0.5);
    const auto scale = [&](std::uint32_t late) {
      return WorldLateness::in_tick(kRatio - 1 + late, kRatio, period_s).force_scale;
    };
    CHECK(scale(ticks) == 1);
    CHECK(scale(ticks + 5) == Approx(0.5));
    CHECK(scale(ticks + 10) == Approx(0).margin(1e-9));
    CHECK(scale(ticks + 1000) == 0);
  }
}
