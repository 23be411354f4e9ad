#include "tools/timing/run_timing.h"

#include <fmt/format.h>
#include <sched.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>

#include "hal/device_class.h"
#include "rt/base/clock.h"
#include "sim/loader/scene_load.h"
#include "tools/caught.h"
#include "tools/session/find_description.h"
#include "tools/timing/capacity_scene.h"
#include "tools/timing/cyclictest.h"
#include "tools/timing/os_noise.h"

namespace tactus::timing {
namespace {

constexpr double kWarmUp_s = 1, kGrace_s = 0.5;
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
  return {deadlines(o.window_s), o.bare ? deadlines(o.window_s) : 0, 0};
}

// Moves records from the ring to the statistics, samples the machine, and runs cyclictest on the core while the loop
// pauses.
class Watcher {
 public:
  // `noise` may be null.
  Watcher(const TimingOptions& options, loop::TickProbe& probe, OsNoise* noise, TimingResult& result)
      : options_(options), probe_(probe), noise_(noise), result_(result), thread_([this] {
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
    stay_on(cores_without(options_.run.cpu));
    while (!done_.load(std::memory_order_relaxed)) {
      look();
      if (options_.against_cyclictest && probe_.resting_until_ns() != 0) measure_cyclictest();
      std::this_thread::sleep_for(kLookEvery);
    }
    look();
    result_.books.finish();
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
        result_.books.add_loop(times);
      else
        result_.books.add_bare(times);
    }
    result_.books.add_look(now);
  }

  void measure_cyclictest() {
    const std::int64_t left_ns = probe_.resting_until_ns() - MonotonicClock::now_ns();
    const auto seconds = static_cast<unsigned>(std::max<std::int64_t>(0, left_ns / 1'000'000'000));
    if (!status_.ok() || seconds <= kCyclictestSpare_s) return;
    CyclictestRun run;
    run.cpu = options_.run.cpu;
    run.main_cpu = cores_without(options_.run.cpu).front();
    run.priority = options_.run.priority;
    run.period_us = 1e6 / options_.run.rate_Hz;
    run.seconds = seconds - kCyclictestSpare_s + (left_ns % 1'000'000'000 > 500'000'000 ? 1 : 0);
    if (const Status status = run_cyclictest(run, kSettleTicks, result_.cyclictest_wake); !status.ok())
      status_ = status;
    // The rest of the rest: not a second time.
    while (probe_.resting_until_ns() != 0 && !done_.load(std::memory_order_relaxed))
      std::this_thread::sleep_for(kLookEvery);
  }

  const TimingOptions& options_;
  loop::TickProbe& probe_;
  OsNoise* noise_;
  TimingResult& result_;
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

// A real device is timed without force, as nobody asked for any, and without pauses, in which it would miss commands.
void keep_unforced(TimingOptions& o) {
  const auto choice = hal::choose_device(o.run.device);
  if (!choice.ok() || !choice.value().device_class->real) return;
  o.run.arm_at_start = false;
  o.bare = false;
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
  return session::check_options(o.run);
}

std::optional<TimingResult> run_timing(const TimingOptions& given, const TimingProgress& progress,
                                       const std::atomic<bool>& stop, TimingProblem& problem) {
  TimingOptions options = given;
  if (options.run.cpu < 0) options.run.cpu = cores_without(-1).back();
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
  const auto profile = session::find_description(scene->device.profile, options.run.device_file);
  if (!profile.ok()) return fail(true, profile.message());
  auto hardware = session::open_hardware(options.run, profile.value());
  if (!hardware.ok()) return fail(false, hardware.message());
  auto session = session::Session::create(std::move(*scene), options.run, std::move(hardware).value());
  if (!session.ok()) return fail(true, session.message());
  // The real loop has its flight recorder.
  if (const Status status = session.value()->record(""); !status.ok()) return fail(false, status.message());

  const auto period_ns = static_cast<std::int64_t>(std::llround(options.run.period_s() * 1e9));
  const auto warm_up = static_cast<std::uint64_t>(kWarmUp_s * options.run.rate_Hz);
  TimingResult result{.options = options,
                      .summary = {},
                      .books = TickStatistics({period_ns, warm_up, kSettleTicks}),
                      .rows = {},
                      .cyclictest_wake = {},
                      .records_lost = 0,
                      .scene_text = scene_text};
  loop::TickProbe probe(plan);
  session::RealtimeHooks hooks;
  hooks.probe = &probe;
  hooks.show = [&](const session::LiveStatus& live, double elapsed_s) {
    if (progress) progress(std::min(1.0, elapsed_s / options.duration_s), live);
    // If deadlines are skipped, the ticks would take longer than requested.
    return elapsed_s < options.duration_s + kGrace_s;
  };
  stay_on(cores_without(options.run.cpu));  // for this thread and those that it starts; the haptic thread pins itself
  Watcher watcher(options, probe, noise.get(), result);
  auto summary = session::run_realtime(*session.value(), hooks, stop);
  watcher.stop();
  if (!summary.ok()) return fail(false, summary.message());
  if (!watcher.status().ok()) return fail(false, watcher.status().message());
  result.summary = std::move(summary).value();
  result.rows = judge(result.books);
  const std::vector<VerdictRow> simulated = rows_of(session::judge_simulation(result.summary));
  result.rows.insert(result.rows.end(), simulated.begin(), simulated.end());
  // The governor reduces the members if the core is too slow; then the requested capacity was not measured.
  if (options.run.scene.empty())
    result.rows.push_back({"members short of capacity", "",
                           static_cast<double>(options.members) - static_cast<double>(result.books.members_max), 0,
                           false});
  return result;
}

}  // namespace tactus::timing
