// Outputs of `tactus timing`: bars, the plot, the trace, the report's keys.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "sim/loader/scene_load.h"
#include "tests/tools/timing/made_ticks.h"
#include "tools/session/session.h"
#include "tools/timing/capacity_scene.h"
#include "tools/timing/plot.h"
#include "tools/timing/report.h"
#include "tools/timing/trace.h"

using Catch::Matchers::Contains;

using namespace tactus;
using namespace tactus::timing;

namespace {

TimingResult made_result() {
  TimingResult r{.statistics = TickStatistics({kPeriod_ns, 0, 10})};
  for (std::uint64_t i = 0; i < 400; ++i) r.statistics.add_loop(i == 200 ? woken_late(i, 1'500'000) : usual_tick(i));
  for (std::uint64_t i = 0; i < 100; ++i) r.statistics.add_bare(usual_tick(i));
  r.statistics.finish();
  r.rows = judge(r.statistics);
  return r;
}

}  // namespace

TEST_CASE("the bars have each time once, in the row that ends at or above it, and a line at the deadline") {
  Histogram h;
  for (int i = 0; i < 1000; ++i) h.record(3'000);
  h.record(1'500'000);
  const std::string text = histogram_text({{"loop", &h}}, kPeriod_ns);
  CHECK_THAT(text, Contains("<= 5 us  \u2588") && Contains("1000\n") && Contains("deadline, 1 ms"));
  CHECK(text.find("<= 2 us") == std::string::npos);     // rows begin where there is something
  CHECK(text.find("deadline") < text.find("<= 2 ms"));  // what is below the line is late
  CHECK(text.find("<= 1 ms") < text.find("deadline"));
}

TEST_CASE("the plot is an SVG with a curve for each histogram that has times") {
  const TimingResult r = made_result();
  const Provenance made{.date_utc = "2026-01-31 23:59 UTC",
                        .version = "1.2 (commit abc)",
                        .built_for = "x86-64-v3",
                        .machine = "a CPU & <kernel>",
                        .command = "tactus timing"};
  const std::string svg = to_svg(r, made);
  std::size_t curves = 0;
  for (std::size_t at = 0; (at = svg.find("<polyline", at)) != std::string::npos; ++at) ++curves;
  CHECK(curves == 3);  // done, wake-up, bare timer; no cyclictest
  CHECK_THAT(svg, Catch::StartsWith("<svg ") && Catch::EndsWith("</svg>\n") && Contains("deadline"));
  CHECK_THAT(svg, Contains("Of 400 ticks at 1000 Hz") && Contains("1 overran, 0 of them by the program's own work"));
  CHECK_THAT(
      svg, Contains("2026-01-31 23:59 UTC") && Contains("1.2 (commit abc)") && Contains("a CPU &amp; &lt;kernel&gt;"));
  CHECK_THAT(svg, Contains("prefers-color-scheme:dark") && Contains("[\u00b5s]"));
  CHECK(svg.find("nan") == std::string::npos);
}

TEST_CASE("the trace has the stages of the ticks around a spike, and a mark on it with the cause") {
  const TimingResult r = made_result();
  const auto trace = nlohmann::json::parse(trace_json(r.statistics));
  std::size_t solves = 0, marks = 0;
  for (const auto& event : trace["traceEvents"]) {
    if (event["name"] == "solve") {
      ++solves;
      CHECK(event["ph"] == "X");
      CHECK(event["dur"] == Approx(120.0));
    }
    if (event["name"] != "SPIKE: late wake-up") continue;
    ++marks;
    CHECK(event["args"]["tick"] == 200);
    CHECK(event["ts"] == Approx(200 * 1000.0 + 1720));  // from the first tick shown, which is tick 0
  }
  CHECK(solves == 400);
  CHECK(marks == 1);
}

TEST_CASE("the report has percentiles by stage in us, overruns by cause and the verdict") {
  TimingResult made = made_result();
  made.options.run.scene = "my/scene.toml";
  made.summary.scene_name = "scene";
  made.summary.scene_hash = "0123";
  const auto j = to_json(made);
  CHECK(j["scene"] == "scene");
  CHECK(j["scene_file"] == "my/scene.toml");
  CHECK(j["scene_hash"] == "0123");
  CHECK(j["ticks"] == 400);
  CHECK(j["stages"].size() == kStages);
  CHECK(j["stages"]["solve"]["p50_us"] == Approx(120).epsilon(0.02));
  CHECK(j["stages"]["wake"]["max_us"] == Approx(1505));
  CHECK(j["overruns"]["late_wake_up"] == 1);
  CHECK(j["overruns"].size() == kCauses);
  CHECK(j["page_faults"] == 0);
  CHECK(j["context_switches"] == 0);
  CHECK(j["verdict"] == "machine");
  CHECK_THAT(to_text(made_result()), Contains("THE MACHINE") && Contains("tick       200") && Contains("late wake-up"));
}

TEST_CASE("of the latest ticks each says whether it was an overrun, and only those are own work") {
  TimingResult r = made_result();
  auto heavy = delayed_in_solve(500, 500'000);
  heavy.cpu_ns += 500'000;
  heavy.predicted_ns = 700'000;
  r.statistics.add_loop(heavy);
  r.statistics.finish();
  CHECK_THAT(to_text(r),
             Contains("OVERRUN: late wake-up") && Contains("in time: computing") && !Contains(": own work"));
  const auto j = to_json(r);
  CHECK(j["spikes"][0]["overrun"] == true);
  CHECK(j["spikes"][1]["overrun"] == false);
  CHECK(j["spikes"][1]["cause"] == "computing");
  CHECK(j["overruns"]["own_work"] == 0);
}

TEST_CASE("the worst case is a scene that loads, with more bodies than may be members") {
  for (const unsigned members : {2u, 64u, 256u}) {
    const auto scene = sim::parse_scene(capacity_scene(members, 4, 10, 1000), "capacity");
    INFO(scene.message());
    REQUIRE(scene.ok());
    CHECK(scene.value().members == members);
    CHECK(scene.value().solver.sub_steps == 4);
    CHECK(scene.value().bodies.size() > 2 * members);
  }
}

TEST_CASE("the worst case runs at any rate, with as few sub-steps as may be") {
  for (const double rate_Hz : {100.0, 333.0, 1000.0, 4000.0}) {
    session::RunOptions options;
    options.virtual_time = true;
    options.rate_Hz = rate_Hz;
    auto scene = sim::parse_scene(capacity_scene(2, 1, 10, rate_Hz), "capacity");
    REQUIRE(scene.ok());
    const auto session = session::Session::create(std::move(scene).value(), options);
    INFO(rate_Hz << " Hz: " << session.message());
    CHECK(session.ok());
  }
}
