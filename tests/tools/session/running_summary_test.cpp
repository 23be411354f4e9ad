// The summary of a run so far, counted from its records, comes to the verdict of the run's own summary; its counts are
// taken while another thread reads them.
#include "tools/session/running_summary.h"

#include <catch2/catch.hpp>
#include <thread>

#include "rt/base/denormals.h"
#include "tests/system/session_bench.h"

using namespace tactus;
using session::RunningSummary;

namespace {

struct Counted {
  std::unique_ptr<session::Session> session;
  std::shared_ptr<RunningSummary> running;

  Counted(const std::string& scene, session::RunOptions options) {
    session = test::make_session(test::scene_file(scene), options);
    running = std::make_shared<RunningSummary>(*session);
    session->shown.tap = {[](void* context, std::uint32_t kind, std::span<const std::byte> payload) noexcept {
                            static_cast<RunningSummary*>(context)->take(kind, payload);
                          },
                          running.get()};
    REQUIRE(session->record("").ok());
  }
};

}  // namespace

TEST_CASE("the verdict so far is the one of the summary, rule by rule") {
  session::RunOptions faulty = test::virtual_options(), direct = test::virtual_options();
  faulty.inject = "lost@400+500";
  direct.coupling = haptics::CouplingScheme::kDirect;
  for (const auto& [scene, options] : {std::pair{"card_house.toml", test::virtual_options()},
                                       {"card_house.toml", faulty},
                                       {"stack20.toml", direct},
                                       {"pile700.toml", test::virtual_options()}}) {
    INFO(scene);
    Counted run(scene, options);
    const session::RunSummary summary = test::run(*run.session, 1500);
    if (run.session->global != nullptr) run.running->take_world(run.session->global->statistics());
    const auto own = session::judge(summary), counted = session::judge(run.running->so_far());
    REQUIRE(own.rulings.size() == counted.rulings.size());
    for (std::size_t i = 0; i < own.rulings.size(); ++i) {
      CHECK(own.rulings[i].rule == counted.rulings[i].rule);
      CHECK(own.rulings[i].measured == counted.rulings[i].measured);
      CHECK(own.rulings[i].found == counted.rulings[i].found);
    }
    CHECK(own.text() == counted.text());
  }
}

TEST_CASE("ticks, steps and readings from three threads at a time: every tick is counted, and readings only grow",
          "[threads]") {
  const auto session = test::make_session(test::scene_file("card_house.toml"), test::virtual_options());
  RunningSummary running(*session);
  constexpr std::uint64_t kTicks = 20'000;
  std::thread ticks([&] {
    loop::TickRecord record;
    for (record.out.tick = 0; record.out.tick < kTicks; ++record.out.tick) {
      record.adopts = record.out.tick % 10 == 0 ? 1 : 0;
      running.take(record);
    }
  });
  std::thread steps([&] {
    sim::GlobalStatistics statistics;
    for (statistics.steps = 1; statistics.steps <= 2'000; ++statistics.steps) running.take_world(statistics);
  });
  std::uint64_t before = 0, steps_before = 0;
  while (before < kTicks) {
    const session::RunSummary so_far = running.so_far();
    REQUIRE(so_far.stats.ticks >= before);
    REQUIRE(so_far.global.steps >= steps_before);
    before = so_far.stats.ticks;
    steps_before = so_far.global.steps;
  }
  ticks.join();
  steps.join();
  CHECK(running.so_far().stats.cycles == kTicks / 10 - 1);  // the first one begins, and ends none
}
