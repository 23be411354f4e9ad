// The GPIO lines over the kernel's gpio-sim, for the guest of the bench: needs root and gpiochip0 with eight lines of
// the simulated chip, whose inputs are pulled and outputs read in sysfs.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <fstream>
#include <string>
#include <thread>

#include "hal/gpio/hand_lines.h"
#include "rt/base/clock.h"

using namespace tactus;
using hal::GpioLine;
using hal::GpioLines;
using hal::GpioOptions;

namespace {

constexpr unsigned kHands = 3;

std::string file_of(unsigned line, const char* what) {
  return "/sys/devices/platform/gpio-sim.0/gpiochip0/sim_gpio" + std::to_string(line) + "/" + what;
}

void pull(unsigned line, bool up) {
  std::ofstream file(file_of(line, "pull"));
  REQUIRE((file << (up ? "pull-up" : "pull-down") << std::flush));
}

int value_of(unsigned line) {
  std::ifstream file(file_of(line, "value"));
  int value = -1;
  file >> value;
  return value;
}

std::unique_ptr<GpioLines> opened(GpioOptions options) {
  options.chip = "gpiochip0";
  auto lines = GpioLines::open(options);
  INFO((lines.ok() ? std::string() : lines.message()));
  REQUIRE(lines.ok());
  return std::move(lines).value();
}

// The kernel hands edges on from a thread: asks again until it holds, two seconds at most.
template <class F>
bool soon(F&& holds) {
  const std::int64_t deadline = MonotonicClock::now_ns() + 2'000'000'000;
  while (!holds()) {
    if (MonotonicClock::now_ns() > deadline) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}

}  // namespace

TEST_CASE("the e-stop's level is known from the start and followed by its edges") {
  const bool low = GENERATE(false, true), active_at_start = GENERATE(false, true);
  pull(3, active_at_start != low);
  const auto lines = opened({.estop = GpioLine{3, low}});
  CHECK(lines->estop() == active_at_start);
  CHECK(lines->estop() == active_at_start);
  pull(3, low == active_at_start);
  CHECK(soon([&] { return lines->estop() == !active_at_start; }));
  pull(3, active_at_start != low);
  CHECK(soon([&] { return lines->estop() == active_at_start; }));
  CHECK(soon([&] {
    lines->estop();
    return lines->counters().estop_edges == 2;
  }));
  CHECK(lines->estop() == active_at_start);
  CHECK(lines->counters().read_failed == 0);
}

TEST_CASE("a stop that was there and went between two looks is seen once") {
  pull(3, false);
  const auto lines = opened({.estop = GpioLine{3, false}});
  REQUIRE_FALSE(lines->estop());
  unsigned seen = 0;
  for (unsigned edge = 1; edge <= 2; ++edge) {
    pull(3, edge == 1);
    std::this_thread::sleep_for(std::chrono::milliseconds(100));  // the edge is in the queue, nobody looked
  }
  CHECK(soon([&] {
    seen += lines->estop() ? 1 : 0;
    return lines->counters().estop_edges == 2;
  }));
  CHECK(seen == 1);
  CHECK_FALSE(lines->estop());
}

TEST_CASE("a contact that bounces more often than the kernel keeps is read right when it rests") {
  const bool ends_active = GENERATE(false, true);
  pull(3, false);
  const auto lines = opened({.estop = GpioLine{3, false}});
  for (int i = 0; i < 41; ++i) {
    pull(3, i % 2 == 0);
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  if (!ends_active) pull(3, false);
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  CHECK(lines->estop());
  CHECK(lines->counters().estop_edges == 16);
  for (int i = 0; i < 3; ++i) CHECK(lines->estop() == ends_active);
}

TEST_CASE("one e-stop line stops every hand while it is active, whichever looks first") {
  const bool low = GENERATE(false, true);
  pull(3, low);
  const auto hands = hal::HandLines::share(opened({.estop = GpioLine{3, low}}), kHands);
  const auto all = [&](bool active) {
    return std::ranges::all_of(hands, [&](const auto& hand) { return hand->estop() == active; });
  };
  CHECK(all(false));
  for (int press = 0; press < 2; ++press) {
    pull(3, !low);
    CHECK(soon([&] { return all(true); }));
    for (int look = 0; look < 20; ++look) CHECK(all(true));
    for (auto hand = hands.rbegin(); hand != hands.rend(); ++hand) CHECK((*hand)->estop());
    pull(3, low);
    CHECK(soon([&] { return all(false); }));
    for (int look = 0; look < 20; ++look) CHECK(all(false));
  }
}

TEST_CASE("a stop that was there and went between two looks stops every hand once") {
  const unsigned first = GENERATE(0u, kHands - 1);
  pull(3, false);
  const auto hands = hal::HandLines::share(opened({.estop = GpioLine{3, false}}), kHands);
  for (const auto& hand : hands) REQUIRE_FALSE(hand->estop());
  for (unsigned press = 1; press <= 2; ++press) {
    pull(3, true);
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    pull(3, false);
    std::this_thread::sleep_for(std::chrono::milliseconds(100));  // both edges are queued, none is read yet
    // The queue of edges is common: what one hand takes from it, the others are told.
    CHECK(soon([&] { return hands[first]->estop(); }));
    for (unsigned hand = 0; hand < kHands; ++hand) {
      CAPTURE(press, hand);
      CHECK(hands[hand]->estop() == (hand != first));
    }
    for (int look = 0; look < 20; ++look)
      for (const auto& hand : hands) CHECK_FALSE(hand->estop());
  }
}

TEST_CASE("the drive enable is active while any hand requests force, the heartbeat while all tick") {
  const auto hands = hal::HandLines::share(opened({.enable = GpioLine{4, false}, .heartbeat = GpioLine{6, false}}), 2);
  const auto enabled = [&](bool first, bool second) {
    hands[1]->enable(second);
    hands[0]->enable(first);  // its thread sets the outputs
    return value_of(4);
  };
  CHECK(enabled(false, false) == 0);
  CHECK(enabled(true, false) == 1);
  CHECK(enabled(false, true) == 1);
  CHECK(enabled(false, false) == 0);
  CHECK(enabled(true, true) == 1);
  hands[0]->off();
  CHECK(value_of(4) == 0);
  for (int i = 1; i <= 4; ++i) {
    const int before = value_of(6);
    hands[0]->heartbeat();
    CHECK(value_of(6) == before);  // the second has not ticked
    hands[1]->heartbeat();
    hands[0]->heartbeat();
    CHECK(value_of(6) == 1 - before);
  }
}

TEST_CASE("outputs start inactive and follow the requests") {
  const bool low = GENERATE(false, true);
  const auto lines = opened({.enable = GpioLine{4, low}, .probe = GpioLine{5, low}, .heartbeat = GpioLine{6, low}});
  for (unsigned line = 4; line <= 6; ++line) CHECK(value_of(line) == (low ? 1 : 0));
  lines->enable(true);
  CHECK(value_of(4) == (low ? 0 : 1));
  lines->probe(true);
  CHECK(value_of(5) == (low ? 0 : 1));
  lines->probe(false);
  CHECK(value_of(5) == (low ? 1 : 0));
  for (int i = 1; i <= 5; ++i) {
    lines->heartbeat();
    CHECK(value_of(6) == ((i % 2 == 1) != low ? 1 : 0));
  }
  CHECK(value_of(4) == (low ? 0 : 1));
  CHECK_FALSE(lines->estop());
  CHECK(lines->counters().write_failed == 0);
}

TEST_CASE("lines that are not in the options do nothing") {
  const auto lines = opened({.probe = GpioLine{5, false}});
  lines->enable(true);
  lines->heartbeat();
  CHECK(value_of(4) == 0);
  CHECK(lines->counters().write_failed == 0);
}

TEST_CASE("what is wrong at opening is said in one line that holds its remedy") {
  const auto message = [](const GpioOptions& options) {
    const auto lines = GpioLines::open(options);
    REQUIRE_FALSE(lines.ok());
    CHECK(lines.message().find('\n') == std::string::npos);
    return lines.message();
  };
  using Catch::Contains;
  CHECK_THAT(message({.chip = "gpiochip9", .probe = GpioLine{1}}),
             Contains("no chip 'gpiochip9'") && Contains("gpiodetect"));
  CHECK_THAT(message({.chip = "gpiochip0", .probe = GpioLine{8}}), Contains("0 to 7") && Contains("not 8"));
  const auto lines = opened({.heartbeat = GpioLine{6}});
  CHECK_THAT(message({.chip = "gpiochip0", .estop = GpioLine{6}}), Contains("in use by 'tactus heartbeat'"));
}
