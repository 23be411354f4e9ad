// One set of GPIO lines for several hands: what each sees, and what the outputs show. The lines are stand-ins; over the
// kernel's own: tests/vm/gpio_guest_test.cpp.
#include "hal/gpio/hand_lines.h"

#include <catch2/catch.hpp>
#include <thread>

using namespace tactus::hal;

namespace {

// As GpioLines: edges wait in a queue, a level is now.
struct StandIn {
  std::atomic<bool> level{false};
  std::atomic<unsigned> edges{0};
  bool enabled{false}, probed{false};
  unsigned beats{0};

  void press() {
    level = true;
    ++edges;
  }
  void release() { level = false; }

  bool estop() noexcept { return estop_edge() || level; }
  bool estop_edge() noexcept {
    unsigned waiting = edges;
    while (waiting > 0 && !edges.compare_exchange_weak(waiting, waiting - 1)) {}
    return waiting > 0;
  }
  bool estop_level() const noexcept { return level; }
  void enable(bool on) noexcept { enabled = on; }
  void probe(bool active) noexcept { probed = active; }
  void heartbeat() noexcept { ++beats; }
};

struct Hands {
  explicit Hands(unsigned count) {
    auto made = std::make_unique<StandIn>();
    lines = made.get();
    each = SharedLines<StandIn>::share(std::move(made), count);
  }
  StandIn* lines;
  std::vector<std::unique_ptr<SharedLines<StandIn>>> each;
};

}  // namespace

TEST_CASE("one e-stop stops every hand for as long as it is pressed") {
  const unsigned count = GENERATE(1u, 2u, 4u);
  Hands hands(count);
  for (auto& hand : hands.each) CHECK_FALSE(hand->estop());
  hands.lines->press();
  for (int tick = 0; tick < 3; ++tick)
    for (auto& hand : hands.each) CHECK(hand->estop());
  hands.lines->release();
  for (auto& hand : hands.each) CHECK_FALSE(hand->estop());
}

TEST_CASE("a press between two ticks is reported to every hand once, whichever reads it") {
  const unsigned reader = GENERATE(0u, 1u, 2u);
  Hands hands(3);
  hands.lines->press();
  hands.lines->release();
  CHECK(hands.each[reader]->estop());
  for (unsigned hand = 0; hand < 3; ++hand) CHECK(hands.each[hand]->estop() == (hand != reader));
  for (auto& hand : hands.each) CHECK_FALSE(hand->estop());
}

TEST_CASE("a hand whose thread has ended does not hide the e-stop from the others") {
  Hands hands(2);
  hands.lines->press();
  CHECK(hands.each[1]->estop());  // the first never ticks
  hands.lines->release();
  CHECK_FALSE(hands.each[1]->estop());
  hands.lines->press();
  CHECK(hands.each[1]->estop());
}

TEST_CASE("every press reaches the threads of all hands", "[threads]") {
  Hands hands(3);
  constexpr unsigned kPresses = 200;
  std::atomic<bool> done{false};
  std::array<std::atomic<unsigned>, 3> ticks{}, stops{};
  std::vector<std::thread> threads;
  for (unsigned hand = 0; hand < 3; ++hand)
    threads.emplace_back([&, hand] {
      while (!done) {
        if (hands.each[hand]->estop()) ++stops[hand];
        hands.each[hand]->enable(true);
        hands.each[hand]->heartbeat();
        ++ticks[hand];
        std::this_thread::yield();
      }
    });
  bool all = true;
  for (unsigned press = 0; press < kPresses; ++press) {
    const std::array<unsigned, 3> before{stops[0], stops[1], stops[2]};
    hands.lines->press();
    hands.lines->release();
    // One tick reads the edge, the next of each hand knows of it: three after the press have begun and ended.
    const std::array<unsigned, 3> began{ticks[0], ticks[1], ticks[2]};
    for (bool waits = true; waits;) {
      waits = hands.lines->edges > 0;
      for (unsigned hand = 0; hand < 3; ++hand) waits = waits || ticks[hand] < began[hand] + 3;
      std::this_thread::yield();
    }
    const std::array<unsigned, 3> later{ticks[0], ticks[1], ticks[2]};
    for (bool waits = true; waits;) {
      waits = false;
      for (unsigned hand = 0; hand < 3; ++hand) waits = waits || ticks[hand] < later[hand] + 3;
      std::this_thread::yield();
    }
    for (unsigned hand = 0; hand < 3; ++hand) all = all && stops[hand] > before[hand];
  }
  done = true;
  for (auto& thread : threads) thread.join();
  CHECK(all);
}

TEST_CASE("the drives are enabled while any hand requests force, and off at the end") {
  Hands hands(2);
  hands.each[1]->enable(true);
  CHECK_FALSE(hands.lines->enabled);  // the first hand's thread sets the line
  hands.each[0]->enable(false);
  CHECK(hands.lines->enabled);
  hands.each[1]->enable(false);  // its fault
  hands.each[0]->enable(true);
  CHECK(hands.lines->enabled);
  hands.each[0]->enable(false);
  CHECK_FALSE(hands.lines->enabled);
  hands.each[1]->enable(true);
  hands.each[0]->enable(true);
  hands.each[0]->off();
  CHECK_FALSE(hands.lines->enabled);
}

TEST_CASE("the heartbeat stops with any of the threads") {
  Hands hands(3);
  const auto beat = [&](std::initializer_list<unsigned> alive) {
    for (const unsigned hand : alive) hands.each[hand]->heartbeat();
    return hands.lines->beats;
  };
  CHECK(beat({1, 2, 0}) == 1);
  CHECK(beat({0, 1, 2}) == 1);  // the others have not ticked since
  CHECK(beat({0, 1, 2}) == 2);
  CHECK(beat({0, 1}) == 3);  // of the third's last tick
  CHECK(beat({0, 1}) == 3);
  CHECK(beat({0, 1}) == 3);
  CHECK(beat({1, 2}) == 3);
  Hands alone(1);
  alone.each[0]->heartbeat();
  alone.each[0]->heartbeat();
  CHECK(alone.lines->beats == 2);
}

TEST_CASE("the probe is the first hand's tick") {
  Hands hands(2);
  hands.each[1]->probe(true);
  CHECK_FALSE(hands.lines->probed);
  hands.each[0]->probe(true);
  CHECK(hands.lines->probed);
  hands.each[1]->probe(false);
  CHECK(hands.lines->probed);
}
