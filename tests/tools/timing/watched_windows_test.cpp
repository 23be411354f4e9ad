// Windows with and without a watcher: which count, and what their times are compared to.
#include "tools/timing/watched_windows.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "tests/tools/timing/made_ticks.h"
#include "tools/timing/report.h"

using namespace tactus;
using namespace tactus::timing;

namespace {

using Kind = WatchedWindows::Kind;

// `late_ns` later than usual, 100 ticks.
void add_window(WatchedWindows& windows, Kind kind, WindowWatcher::Counts from, WindowWatcher::Counts to,
                std::int64_t late_ns = 0) {
  windows.begin(kind, from);
  for (std::uint64_t i = 0; i < 100; ++i) windows.add(woken_late(i, late_ns));
  windows.end(to);
}

TimingOptions with_viewer() {
  TimingOptions options;
  options.with_viewer = true;
  options.duration_s = 60;
  return options;
}

}  // namespace

TEST_CASE("windows with a watcher are compared with those without one by their percentiles") {
  WatchedWindows windows;
  add_window(windows, Kind::kUnwatched, {0, 0}, {0, 0});
  add_window(windows, Kind::kWatched, {0, 1}, {50, 1}, 5'000);
  add_window(windows, Kind::kUnwatched, {50, 0}, {50, 0});
  CHECK(windows.with.windows == 1);
  CHECK(windows.with.ticks == 100);
  CHECK(windows.with.frames == 50);
  CHECK(windows.without.windows == 2);
  CHECK(windows.without.ticks == 200);
  CHECK(windows.without.frames == 0);
  CHECK(windows.other == 0);
  CHECK(ratio_of(windows.with.wake, windows.without.wake, 50) == Approx(2.0).epsilon(0.02));  // 10 us to 5 us
  CHECK(ratio_of(windows.with.execution, windows.without.execution, 99) == Approx(1.0));
  CHECK(windows.with.execution.max_ns() == 215'000);  // read 10, adopt 2, couple 3, collide 60, solve 120, write 20
}

TEST_CASE("a window in which the watcher took no frame counts on neither side, nor does one whose watcher stayed") {
  WatchedWindows windows;
  add_window(windows, Kind::kWatched, {7, 1}, {7, 1});
  add_window(windows, Kind::kWatched, {7, 1}, {9, 0});  // it ended within the window
  add_window(windows, Kind::kUnwatched, {9, 1}, {9, 0});
  add_window(windows, Kind::kUnwatched, {9, 0}, {9, 1});
  CHECK(windows.with.windows == 0);
  CHECK(windows.without.windows == 0);
  CHECK(windows.other == 4);
  CHECK(ratio_of(windows.with.wake, windows.without.wake, 50) == 0);
}

TEST_CASE("ticks between two windows belong to none, and a window without ticks is none") {
  WatchedWindows windows;
  windows.add(usual_tick(0));
  windows.begin(Kind::kUnwatched, {0, 0});
  windows.end({0, 0});
  windows.add(usual_tick(1));
  CHECK_FALSE(windows.any());
  add_window(windows, Kind::kUnwatched, {0, 0}, {0, 0});
  CHECK(windows.without.ticks == 100);
}

TEST_CASE("the report has both sides of a viewer with their counts and ratios, and nothing of it without one") {
  TimingResult result{.statistics = TickStatistics({kPeriod_ns, 0, 10})};
  CHECK_FALSE(to_json(result).contains("viewer"));
  add_window(result.viewer, Kind::kUnwatched, {0, 0}, {0, 0});
  add_window(result.viewer, Kind::kWatched, {0, 1}, {50, 1}, 5'000);
  const auto viewer = to_json(result)["viewer"];
  CHECK(viewer["with"]["frames"] == 50);
  CHECK(viewer["without"]["ticks"] == 100);
  CHECK(viewer["with"]["wake"]["p50_us"] == Approx(10).epsilon(0.02));
  CHECK(viewer["wake_ratio_p50"] == Approx(2.0).epsilon(0.02));
  CHECK(viewer["execution_ratio_p99"] == Approx(1.0));
  CHECK_THAT(to_text(result), Catch::Contains("1 windows with it (100 ticks, 50 frames taken), 1 without (100 ticks)"));
}

TEST_CASE("a viewer in turns wants the simulated device, no cyclictest, and time for a window of each kind") {
  TimingOptions options = with_viewer();
  CHECK(check(options).ok());
  options.duration_s = 5.9;
  CHECK_THAT(check(options).message(), Catch::Contains("accepted: from 6 s, with --with-viewer"));
  options = with_viewer();
  options.against_cyclictest = true;
  CHECK_THAT(check(options).message(), Catch::StartsWith("--with-viewer: "));
  options = with_viewer();
  options.run.device = "usb";
  CHECK_THAT(check(options).message(), Catch::StartsWith("--with-viewer: usb misses commands"));
}
