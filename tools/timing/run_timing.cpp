#include "tools/timing/run_timing.h"

#include <fmt/format.h>
#include <sched.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>

#include "hal/device_class.h"
#include "rt/base/clock.h"
#include "rt/thread/realtime_setup.h"
#include "sim/loader/scene_load.h"
#include "tools/caught.h"
#include "tools/session/cores.h"
#include "tools/session/find_description.h"
#include "tools/timing/capacity_scene.h"
#include "tools/timing/cyclictest.h"
#include "tools/timing/os_noise.h"

namespace tactus::timing {
namespace {

constexpr double kWarmUp_s = 1, kGrace_s = 0.5;
constexpr double kViewerRounds = 2;  // after the warm-up: a window with the viewer and one without
constexpr std::uint32_t kSettleTicks = 10;
constexpr auto kLookEvery = std::chrono::milliseconds(20);
// Margin for cyclictest to start and end within its window.
constexpr unsigned kCyclictestSpare_s = 1;

void stay_on(const std::vector<int>& cpus) {
  cpu_set_t set;
  CPU_ZERO(&set);
  for (const int cpu : cpus) CPU_SET(static_cast<unsigned>(cpu), &set);
  sched_setaffinity(0, sizeof set, &set);  // if it fails, the figures are only slightly worse
}

loop::WindowPlan windows_of(const TimingOptions& o) {
  const auto deadlines = [&](double s) { return static_cast<std::uint64_t>(std::llround(s * o.run.rate_Hz)); };
  if (o.against_cyclictest) return {deadlines(kAgainstWindow_s), 0, deadlines(kAgainstWindow_s)};
  if (o.with_viewer) return {deadlines(o.window_s), 0, deadlines(kViewerRest_s)};
  return {deadlines(o.window_s), o.bare ? deadlines(o.window_s) : 0, 0};
}

// Moves records from the ring to the statistics and samples the machine. While the loop pauses it runs cyclictest on
// the core, or lets the watcher come or go.
class Watcher {
 public:
  // `noise` may be null; `visitor` may be empty.
  Watcher(loop::TickProbe& probe, OsNoise* noise, const WindowWatcher& visitor, TimingResult& result)
      : options_(result.options), probe_(probe), noise_(noise), visitor_(visitor), result_(result), thread_([this] {
          if (const Status thrown = caught([this] { watch(); }); !thrown.ok()) status_ = thrown;
        }) {}
  ~Watcher() { stop(); }

  void stop() {
    done_.store(true, std::memory_order_relaxed);
    if (thread_.joinable()) thread_.join();
  }
  const Status& status() const { return status_; }  // after stop()

 private:
  void watch() {
    stay_on(session::cores_without(options_.run.cpu));
    if (options_.with_viewer) result_.viewer.begin(WatchedWindows::Kind::kUnwatched, visitor_.counts());
    while (!done_.load(std::memory_order_relaxed)) {
      const bool rests = probe_.resting_until_ns() != 0;  // before look(): the records of the window are in the ring
      look();
      if (rests && options_.against_cyclictest) measure_cyclictest();
      if (rests && options_.with_viewer) change_viewer();
      std::this_thread::sleep_for(kLookEvery);
    }
    look();
    if (options_.with_viewer) end_viewer();
    result_.statistics.finish();
    result_.records_lost = probe_.ring().dropped();
  }

  void look() {
    MachineLook now = look_at_machine(options_.run.cpu, probe_.thread_id());
    if (noise_ != nullptr) now.noise = noise_->read(probe_.thread_id());
    RingRecord record;
    loop::TickTimes times;
    while (probe_.ring().try_pop(record, std::as_writable_bytes(std::span<loop::TickTimes, 1>(&times, 1))) ==
           Pop::kRecord) {
      if (record.kind == loop::kLoopTimes)
        add_loop(times);
      else
        result_.statistics.add_bare(times);
    }
    result_.statistics.add_look(now);
  }

  void add_loop(const loop::TickTimes& times) {
    const std::uint64_t counted = result_.statistics.ticks;
    result_.statistics.add_loop(times);
    if (options_.with_viewer && result_.statistics.ticks > counted) result_.viewer.add(times);
  }

  // A window has ended: for the next one the viewer comes, or goes.
  void change_viewer() {
    if (!status_.ok()) return;
    result_.viewer.end(visitor_.counts());
    const bool watches = !watched_;
    if (watches)
      status_ = visitor_.attach();
    else
      visitor_.detach();
    watched_ = watches;
    await_end_of_rest();
    look();  // ticks before this moment are of no window, where the viewer took longer than the rest
    result_.viewer.begin(watches ? WatchedWindows::Kind::kWatched : WatchedWindows::Kind::kUnwatched,
                         visitor_.counts());
  }

  void end_viewer() {
    result_.viewer.end(visitor_.counts());
    if (watched_) visitor_.detach();
  }

  void await_end_of_rest() const {
    while (probe_.resting_until_ns() != 0 && !done_.load(std::memory_order_relaxed))
      std::this_thread::sleep_for(kLookEvery);
  }

  void measure_cyclictest() {
    const std::int64_t left_ns = probe_.resting_until_ns() - MonotonicClock::now_ns();
    const auto seconds = static_cast<unsigned>(std::max<std::int64_t>(0, left_ns / 1'000'000'000));
    if (!status_.ok() || seconds <= kCyclictestSpare_s) return;
    CyclictestRun run;
    run.cpu = options_.run.cpu;
    run.main_cpu = session::cores_without(options_.run.cpu).front();
    run.priority = options_.run.priority;
    run.period_us = 1e6 / options_.run.rate_Hz;
    run.seconds = seconds - kCyclictestSpare_s + (left_ns % 1'000'000'000 > 500'000'000 ? 1 : 0);
    if (const Status status = run_cyclictest(run, kSettleTicks, result_.cyclictest_wake); !status.ok())
      status_ = status;
    await_end_of_rest();  // not a second time
  }

  const TimingOptions& options_;
  loop::TickProbe& probe_;
  OsNoise* noise_;
  const WindowWatcher& visitor_;
  TimingResult& result_;
  bool watched_{false};
  Status status_{Status::good()};
  std::atomic<bool> done_{false};
  std::thread thread_;  // last: it uses the others
};

std::optional<sim::Scene> scene_of(TimingOptions& o, std::string& text, TimingProblem& problem) {
  auto scene = o.run.scene.empty()
                   ? sim::parse_scene(text = capacity_scene(o.members, o.sub_steps, o.ratio, o.run.rate_Hz), "capacity")
                   : sim::load_scene(o.run.scene);
  if (!scene.ok()) {
    problem = {true, scene.message()};
    return std::nullopt;
  }
  if (!o.run.scene.empty()) {
    text = scene.value().source;
    if (o.run.members == 0) o.members = scene.value().members;
    o.sub_steps = scene.value().solver.sub_steps;
    o.ratio = o.run.ratio != 0 ? o.run.ratio : scene.value().ratio;
  }
  return std::move(scene).value();
}

// Null, and a problem, without the device or with options that do not fit the scene.
std::unique_ptr<session::Session> session_of(sim::Scene scene, const session::RunOptions& options,
                                             TimingProblem& problem) {
  const auto profile = session::find_description(scene.device.profile, options.device_file);
  if (!profile.ok()) {
    problem = {true, profile.message()};
    return nullptr;
  }
  auto hardware = session::open_hardware(options, profile.value());
  if (!hardware.ok()) {
    problem = {false, hardware.message()};
    return nullptr;
  }
  auto session = session::Session::create(std::move(scene), options, std::move(hardware).value());
  if (!session.ok()) {
    problem = {true, session.message()};
    return nullptr;
  }
  return std::move(session).value();
}

// A real device is timed without force, as nobody asked for any, and without pauses, in which it would miss commands.
void keep_unforced(TimingOptions& o) {
  const auto choice = hal::choose_device(o.run.device);
  if (!choice.ok() || !choice.value().device_class->real) return;
  o.run.arm_at_start = false;
  o.bare = false;
}

Status check_viewer(const TimingOptions& o) {
  if (o.against_cyclictest)
    return Status::error("--with-viewer: its windows are cyclictest's with --against; accepted: without it");
  const auto choice = hal::choose_device(o.run.device);
  if (choice.ok() && choice.value().device_class->real)
    return Status::error(
        fmt::format("--with-viewer: {} misses commands in the pauses; accepted: with --device sim", o.run.device));
  const double least_s = (std::ceil(kWarmUp_s / o.window_s) + kViewerRounds) * (o.window_s + kViewerRest_s);
  if (o.duration_s < least_s)
    return Status::error(fmt::format(
        "--duration: {:g} s have no window of {:g} s with and without a viewer; accepted: from {:g} s, with "
        "--with-viewer",
        o.duration_s, o.window_s, least_s));
  return Status::good();
}

}  // namespace

Status check(const TimingOptions& o) {
  if (o.duration_s < 3 || o.duration_s > 1e6)
    return Status::error(fmt::format("--duration: {:g} is out of range; accepted: 3 to 1e6 s", o.duration_s));
  if (o.window_s < 0.1 || o.window_s > 3600)
    return Status::error(fmt::format("--window: {:g} is out of range; accepted: 0.1 to 3600 s", o.window_s));
  if (o.against_cyclictest && o.duration_s < 2 * kAgainstWindow_s)
    return Status::error(
        fmt::format("--duration: {:g} s have no window of {:g} s for each; accepted: from {:g} s, with --against",
                    o.duration_s, kAgainstWindow_s, 2 * kAgainstWindow_s));
  const auto choice = hal::choose_device(o.run.device);
  if (o.against_cyclictest && choice.ok() && choice.value().device_class->real)
    return Status::error(
        fmt::format("--against: {} misses commands in the pauses; accepted: with --device sim", o.run.device));
  if (o.with_viewer)
    if (const Status status = check_viewer(o); !status.ok()) return status;
  return session::check_options(o.run);
}

std::optional<TimingResult> run_timing(const TimingOptions& given, const TimingProgress& progress,
                                       const std::atomic<bool>& stop, TimingProblem& problem,
                                       const WindowWatcher& visitor) {
  TimingOptions options = given;
  options.run.cpu = session::core_of_hand(options.run.cpu);
  if (const Status status = session::check_core("--cpu", options.run.cpu); !status.ok()) {
    problem = {false, status.message()};
    return std::nullopt;
  }
  keep_unforced(options);
  std::string scene_text;
  auto scene = scene_of(options, scene_text, problem);
  if (!scene) return std::nullopt;
  const loop::WindowPlan plan = windows_of(options);
  const double loop_share = static_cast<double>(plan.loop) / static_cast<double>(plan.loop + plan.bare + plan.rest);
  options.run.duration_s = options.duration_s * loop_share;

  const auto fail = [&](bool input, const std::string& text) {
    problem = {input, text};
    return std::nullopt;
  };
  Load load;  // before any thread is started
  if (const Status status = load.start(options.load, options.run.cpu); !status.ok())
    return fail(false, status.message());
  std::unique_ptr<OsNoise> noise;
  if (options.os_noise) {
    auto started = OsNoise::start(options.run.cpu);
    if (!started.ok()) return fail(false, "--os-noise: " + started.message());
    noise = std::move(started).value();
  }
  const auto session = session_of(std::move(*scene), options.run, problem);
  if (!session) return std::nullopt;
  stay_on(session::cores_without(
      options.run.cpu));  // for this thread and those that it starts; the haptic thread pins itself
  session::RealtimeTaps taps;
  if (options.with_viewer) {
    const auto prepared = visitor.prepare(*session);
    if (!prepared.ok()) return fail(false, prepared.message());
    taps = prepared.value();
  }
  // The real loop has its flight recorder.
  if (const Status status = session->record(""); !status.ok()) return fail(false, status.message());

  const auto period_ns = static_cast<std::int64_t>(std::llround(options.run.period_s() * 1e9));
  const auto warm_up = static_cast<std::uint64_t>(kWarmUp_s * options.run.rate_Hz);
  TimingResult result{.options = options,
                      .summary = {},
                      .statistics = TickStatistics({period_ns, warm_up, kSettleTicks}),
                      .rows = {},
                      .cyclictest_wake = {},
                      .records_lost = 0,
                      .scene_text = scene_text,
                      .viewer = {}};
  loop::TickProbe probe(plan);
  session::RealtimeHooks hooks;
  hooks.probe = &probe;
  hooks.taps = taps;
  hooks.show = [&](const session::LiveStatus& live, double elapsed_s) {
    if (progress) progress(std::min(1.0, elapsed_s / options.duration_s), live);
    // If deadlines are skipped, the ticks would take longer than requested.
    return elapsed_s < options.duration_s + kGrace_s;
  };
  Watcher watcher(probe, noise.get(), visitor, result);
  auto summary = session::run_realtime(*session, hooks, stop);
  watcher.stop();
  if (!summary.ok()) return fail(false, summary.message());
  if (!watcher.status().ok()) return fail(false, watcher.status().message());
  result.summary = std::move(summary).value();
  result.rows = judge(result.statistics);
  const std::vector<VerdictRow> simulated = rows_of(session::judge_simulation(result.summary));
  result.rows.insert(result.rows.end(), simulated.begin(), simulated.end());
  // The governor reduces the members if the core is too slow; then the requested capacity was not measured.
  if (options.run.scene.empty())
    result.rows.push_back(
        {.figure = "members short of capacity",
         .unit = "",
         .measured = static_cast<double>(options.members) - static_cast<double>(result.statistics.members_max),
         .limit = 0,
         .ours = false});
  return result;
}

}  // namespace tactus::timing
