// Several hands in real time: a haptic thread each, on one global world. What is tested depends on no timing.
#include <catch2/catch.hpp>
#include <filesystem>

#include "sim/loader/scene_load.h"
#include "tests/support/temporary_file.h"
#include "tools/session/hands.h"
#include "tools/session/realtime_run.h"
#include "tools/session/replay.h"

using namespace tactus;

namespace {

session::Hands hands_of(const session::RunOptions& options) {
  auto scene = sim::load_scene(TACTUS_SOURCE_DIR "/tools/examples/two_hands.toml");
  INFO(scene.message());
  REQUIRE(scene.ok());
  auto hands = session::Hands::create(scene.value(), {options, options}, std::vector<session::Hardware>(2));
  INFO(hands.message());
  REQUIRE(hands.ok());
  return std::move(hands).value();
}

session::RunOptions quick() {
  session::RunOptions options;
  options.duration_s = 0.3;
  options.priority = 0;
  return options;
}

}  // namespace

TEST_CASE("Two hands in real time: every tick of both is on its tape and replays with the same bits", "[threads]") {
  const test::TemporaryFile first;
  const std::string paths[] = {first.path(), session::file_of_hand(first.path(), 1)};
  session::Hands hands = hands_of(quick());
  REQUIRE(hands.record(paths[0]).ok());
  std::atomic<bool> stop{false};
  session::HandsHooks hooks;
  std::size_t shown = 0;
  unsigned began = 0;
  hooks.look_every = std::chrono::milliseconds(20);
  hooks.show = [&](std::span<const session::LiveStatus* const> live, double) {
    shown = live.size();
    return true;
  };
  hooks.hands.resize(2);
  for (auto& hand : hooks.hands) hand.began = [&](const loop::SetupReport&) { ++began; };
  const auto summaries = session::run_realtime(hands, hooks, stop);
  INFO(summaries.message());
  REQUIRE(summaries.ok());
  REQUIRE(summaries.value().size() == 2);
  CHECK(shown == 2);
  CHECK(began == 2);
  for (std::size_t d = 0; d < 2; ++d) {
    const session::RunSummary& summary = summaries.value()[d];
    CHECK(summary.real_time);
    CHECK(summary.stats.ticks == 300);
    CHECK(summary.options.hand == d);
    CHECK(summary.global_step.count() > 0);
    const auto report = session::replay(paths[d]);
    INFO(report.message());
    REQUIRE(report.ok());
    CHECK(report.value().compared + report.value().unreplayable == 300);
    CHECK(report.value().different == 0);
    CHECK(report.value().state_hash == summary.state_hash);
  }
  (void)std::remove(paths[1].c_str());
}

TEST_CASE("A stop ends all hands, and a request reaches all of them", "[threads]") {
  session::Hands hands = hands_of([] {
    session::RunOptions options = quick();
    options.duration_s = 0;
    options.arm_at_start = false;
    return options;
  }());
  std::atomic<bool> stop{false};
  session::HandsHooks hooks;
  hooks.look_every = std::chrono::milliseconds(1);
  hooks.asked = [] { return static_cast<std::uint32_t>(loop::kArm); };
  hooks.show = [&](std::span<const session::LiveStatus* const> live, double) {
    // Not before both have been armed.
    return (live[0]->status.load() & kNotArmed) != 0 || live[0]->ticks.load() == 0 ||
           (live[1]->status.load() & kNotArmed) != 0 || live[1]->ticks.load() == 0;
  };
  const auto summaries = session::run_realtime(hands, hooks, stop);
  REQUIRE(summaries.ok());
  for (const session::RunSummary& summary : summaries.value()) {
    CHECK(summary.stats.ticks > 0);
    CHECK(summary.stats.fault_count == 0);
  }
}
