// Several hands in virtual time at an operator's pace: the bits of an unwatched run, one pace for all, the requests of
// each. With one hand: tests/tools/view/steered.py.
#include "tools/service/paced_run.h"

#include <catch2/catch.hpp>
#include <thread>

#include "rt/loop/haptic_loop.h"
#include "sim/loader/scene_load.h"

using namespace tactus;

namespace {

session::Hands two_hands(bool arm_at_start = true) {
  auto scene = sim::load_scene(TACTUS_SOURCE_DIR "/tools/examples/two_hands.toml");
  INFO(scene.message());
  REQUIRE(scene.ok());
  session::RunOptions options;
  options.virtual_time = true;
  options.duration_s = 1;
  options.arm_at_start = arm_at_start;
  auto hands = session::Hands::create(scene.value(), {options, options}, std::vector<session::Hardware>(2));
  INFO(hands.message());
  REQUIRE(hands.ok());
  return std::move(hands).value();
}

struct Bench {
  explicit Bench(bool arm_at_start = true) : hands(two_hands(arm_at_start)) {}

  session::Hands hands;
  service::Pacing pacing;
  std::atomic<std::uint32_t> first{0}, second{0};
  std::atomic<bool> stop{false};
  unsigned looks{0};

  std::vector<session::RunSummary> run(std::uint64_t ticks) {
    service::PacedHandsHooks hooks{
        .pacing = pacing, .requests = {&first, &second}, .stop = stop, .stepped = {}, .look = {}};
    hooks.look = [this](std::span<const session::LiveStatus* const> live, double) {
      CHECK(live.size() == 2);
      ++looks;
    };
    auto summaries = service::run_paced(hands, hooks, ticks);
    INFO(summaries.message());
    REQUIRE(summaries.ok());
    REQUIRE(summaries.value().size() == 2);
    return std::move(summaries).value();
  }
};

}  // namespace

TEST_CASE("two hands at a pace have the bits of two hands without one") {
  session::Hands hands = two_hands();
  const auto plain = session::run_virtual(hands, 700);
  REQUIRE(plain.ok());
  Bench bench;
  const auto paced = bench.run(700);
  CHECK(bench.looks > 0);
  for (std::size_t hand = 0; hand < 2; ++hand) {
    CHECK(paced[hand].stats.ticks == 700);
    CHECK(paced[hand].state_hash == plain.value()[hand].state_hash);
  }
}

TEST_CASE("a request to one hand is not passed to the other") {
  Bench bench(/*arm_at_start=*/false);
  bench.second = loop::kArm;
  (void)bench.run(200);
  CHECK((bench.hands[0].driver->output().status & kNotArmed) != 0);
  CHECK((bench.hands[1].driver->output().status & kNotArmed) == 0);
}

TEST_CASE("a tick, or a cycle, is one of all hands", "[threads]") {
  Bench bench;
  bench.pacing.playing = false;
  bench.pacing.ticks = 3;
  for (const auto& summary : bench.run(3)) CHECK(summary.stats.ticks == 3);
  Bench other;
  other.pacing.playing = false;
  other.pacing.cycles = 2;
  // Of a cycle each; then it waits for more, and is stopped.
  std::thread ends([&] {
    while (other.pacing.cycles != 0) std::this_thread::yield();
    other.stop = true;
  });
  const auto summaries = other.run(0);
  ends.join();
  CHECK(summaries[0].stats.ticks == summaries[1].stats.ticks);
  CHECK(other.hands.world().statistics().steps > 0);
}
