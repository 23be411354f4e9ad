// Ticks as a probe would record them, made up: what each test changes is all that is wrong with its tick.
#pragma once

#include "rt/loop/tick_probe.h"

namespace tactus::timing {

inline constexpr std::int64_t kPeriod_ns = 1'000'000;

// Woke 5 us late, then 10, 2, 3, 60, 120, 20 us for read, adopt, couple, collide, solve, write; all of it on its core.
inline loop::TickTimes usual_tick(std::uint64_t number) {
  loop::TickTimes t;
  t.tick = number;
  t.scheduled_ns = static_cast<std::int64_t>(number) * kPeriod_ns;
  t.woke_ns = t.scheduled_ns + 5'000;
  t.read_ns = t.woke_ns + 10'000;
  t.adopted_ns = t.read_ns + 2'000;
  t.coupled_ns = t.adopted_ns + 3'000;
  t.collided_ns = t.coupled_ns + 60'000;
  t.stepped_ns = t.collided_ns + 120'000;
  t.computed_ns = t.stepped_ns + 4'000;
  t.wrote_ns = t.stepped_ns + 20'000;
  t.cpu_ns = t.wrote_ns - t.woke_ns;
  t.predicted_ns = 200'000;
  t.members = 40;
  t.contacts = 100;
  t.points = 400;
  t.border = 30;
  t.sub_steps = 4;
  t.into_window = 1000;
  return t;
}

// Everything from the solver's end on comes this much later.
inline loop::TickTimes delayed_in_solve(std::uint64_t number, std::int64_t by_ns) {
  loop::TickTimes t = usual_tick(number);
  t.stepped_ns += by_ns;
  t.computed_ns += by_ns;
  t.wrote_ns += by_ns;
  return t;
}

inline loop::TickTimes woken_late(std::uint64_t number, std::int64_t by_ns) {
  loop::TickTimes t = delayed_in_solve(number, by_ns);
  t.woke_ns += by_ns;
  t.read_ns += by_ns;
  t.adopted_ns += by_ns;
  t.coupled_ns += by_ns;
  t.collided_ns += by_ns;
  return t;
}

}  // namespace tactus::timing
