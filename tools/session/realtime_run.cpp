#include "tools/session/realtime_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <mutex>
#include <thread>

#include "hal/device_words.h"
#include "rt/base/denormals.h"
#include "rt/calibration/calibration.h"
#include "rt/thread/periodic_thread.h"
#include "sim/global_thread.h"
#include "tools/caught.h"
#include "tools/session/cores.h"
#include "tools/session/stolen_time.h"

namespace tactus::session {
namespace {

// Maximum number of refused re-arms listed in a summary.
constexpr std::size_t kMaxRefusals = 16;

// Measures the cost model on the core and at the priority of the haptic thread.
Status calibrate_governor(Session& session, const loop::SetupRequest& setup, loop::Calibration& result) {
  Status status = Status::good();
  std::atomic<bool> done{false};
  std::thread beside([&] { loop::work_beside(done); });
  std::thread worker([&] {
    status = caught([&] {
      loop::CpuAwake awake;
      (void)loop::setup_realtime(setup, awake);
      result = loop::calibrate(loop::CostModel{});
      loop::GovernorConfig config = session.governor->config();
      config.cost = result.cost;
      *session.governor = loop::Governor(config);
    });
  });
  worker.join();
  done.store(true, std::memory_order_relaxed);
  beside.join();
  return status;
}

std::vector<sim::Stall> wall_clock_stalls(const Session& session) {
  std::vector<sim::Stall> stalls;
  const auto period_ns = static_cast<std::uint64_t>(session.options.period_s() * 1e9);
  for (const WorldStall& stall : session.stalls)
    stalls.push_back({stall.at_tick / session.ratio, std::chrono::nanoseconds(stall.ticks * period_ns)});
  return stalls;
}

bool has_to_rearm(const LiveStatus& live) {
  constexpr auto relaxed = std::memory_order_relaxed;
  const auto braked = static_cast<std::uint32_t>(haptics::DeviceState::kBrake);
  return live.fault.load(relaxed) != 0 || live.device_state.load(relaxed) == braked;
}

// The haptic thread of one hand, and the values that it shares with the thread that attends the run.
class HandRun {
 public:
  HandRun(Session& session, const HandHooks& hooks)
      : session_(session),
        settings_(settings_of(session.options)),
        gate_(session.same_device),
        requests_(hooks.requests != nullptr ? *hooks.requests : own_requests_),
        tick_(session, {live_, requests_, gate_}, most_ticks(session.options), hooks.probe, hooks.taps),
        thread_(tick_) {}

  Status calibrate() { return calibrate_governor(session_, settings_.setup, calibration_); }

  Status start() {
    began_ = std::chrono::steady_clock::now();
    if (const Status status = session_.device->start(); !status.ok()) return status;
    cpu_before_ = cpu_time_now(settings_.setup.cpu);
    return thread_.start(settings_);
  }

  // Bound: five times the duration of the ending on a machine that keeps the rate.
  void end_device() {
    if (!tick_.must_end()) return;
    tick_.end();
    constexpr std::chrono::milliseconds kPiece{5};
    for (auto left = std::chrono::duration<double>(5 * kEnd_s); left.count() > 0 && thread_.running(); left -= kPiece)
      std::this_thread::sleep_for(kPiece);
  }
  void request_end() noexcept {
    if (tick_.must_end()) tick_.end();
  }

  void stop() {
    thread_.stop();
    wall_ = std::chrono::steady_clock::now() - began_;
  }

  void ask(std::uint32_t bits) noexcept { requests_.fetch_or(bits, std::memory_order_relaxed); }

  // Looks whether a request for force may be granted; says why not, a reason once.
  void look_at_gate(const std::function<void(const std::string&)>& say) {
    const Status status = gate_.look();
    if (status.ok()) return;
    const bool repeated = !refusals_.empty() && refusals_.back() == status.message();
    if (say && !repeated) say("not armed: " + status.message());
    if (!repeated && refusals_.size() < kMaxRefusals) refusals_.push_back(status.message());
  }

  RunSummary summary(const sim::GlobalThread* world) {
    RunSummary summary = session_.summary();
    summary.real_time = true;
    summary.wall_s = wall_.count();
    summary.arm_refusals = std::move(refusals_);
    summary.setup = thread_.setup_report();
    summary.timing = thread_.health();
    summary.compute = tick_.compute;
    summary.device = tick_.device;
    summary.overruns_late_wake = tick_.late_wake;
    summary.overruns_own_work = tick_.own_work;
    summary.overruns_interrupted = tick_.interrupted;
    summary.calibration = calibration_;
    summary.cost_prediction = tick_.cost_prediction;
    summary.haptic_cpu = settings_.setup.cpu;
    summary.stolen_share = stolen_share(cpu_before_, cpu_time_now(settings_.setup.cpu));
    if (world != nullptr) summary.global_step = world->step_times();
    if (session_.drain == nullptr) return summary;

    session_.close_tape(summary);
    if (summary.fault_latched() || summary.overruns_own_work > 0) {
      const Status dumped = write_fault_tape(session_);
      const std::string path = fault_tape_of(session_).string();
      (dumped.ok() ? summary.fault_tape : summary.fault_tape_error) = dumped.ok() ? path : dumped.message();
    }
    return summary;
  }

  bool running() const noexcept { return thread_.running(); }
  const LiveStatus& live() const noexcept { return live_; }
  const loop::SetupReport& setup_report() const noexcept { return thread_.setup_report(); }

 private:
  static loop::PeriodicSettings settings_of(const RunOptions& options) {
    loop::PeriodicSettings settings;
    settings.period = std::chrono::nanoseconds(std::llround(options.period_s() * 1e9));
    settings.setup.cpu = core_of_hand(options.cpu, options.hand);
    settings.setup.priority = options.priority;
    return settings;
  }
  static std::uint64_t most_ticks(const RunOptions& options) {
    return options.duration_s > 0 ? static_cast<std::uint64_t>(std::llround(options.duration_s * options.rate_Hz))
                                  : ~std::uint64_t{0};
  }

  Session& session_;
  loop::PeriodicSettings settings_;
  loop::Calibration calibration_;
  LiveStatus live_;
  ArmGate gate_;
  std::atomic<std::uint32_t> own_requests_{0};
  std::atomic<std::uint32_t>& requests_;
  std::vector<std::string> refusals_;
  RealtimeTick tick_;
  decltype(cpu_time_now(0)) cpu_before_{};
  std::chrono::steady_clock::time_point began_;
  std::chrono::duration<double> wall_{0};
  loop::PeriodicThread<RealtimeTick> thread_;  // last: it ends before what it uses
};

using HandRuns = std::vector<std::unique_ptr<HandRun>>;

bool any_runs(const HandRuns& runs) {
  return std::any_of(runs.begin(), runs.end(), [](const auto& run) { return run->running(); });
}

// Serves display, operator requests and the arm gates until the run is over. What is asked is asked of all hands.
void attend(const HandRuns& runs, const HandsHooks& hooks, const std::atomic<bool>& stop) {
  const auto began = std::chrono::steady_clock::now();
  std::vector<const LiveStatus*> live;
  for (const auto& run : runs) live.push_back(&run->live());
  while (any_runs(runs) && !stop.load(std::memory_order_relaxed)) {
    std::this_thread::sleep_for(hooks.look_every);
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - began;
    if (hooks.asked) {
      const std::uint32_t asked = hooks.asked();
      for (const auto& run : runs) run->ask(asked);
      const bool latched = std::any_of(live.begin(), live.end(), [](const auto* hand) { return has_to_rearm(*hand); });
      if ((asked & loop::kRearm) != 0 && hooks.say && !latched)
        hooks.say("re-arm: nothing is latched, nothing was done");
    }
    for (const auto& run : runs) run->look_at_gate(hooks.say);
    if (hooks.show && !hooks.show(live, elapsed.count())) return;
  }
}

}  // namespace

std::string fault_line(const LiveStatus& live) {
  constexpr auto relaxed = std::memory_order_relaxed;
  const auto fault = static_cast<Fault>(live.fault.load(relaxed));
  if (fault == Fault::kNone) return {};
  return hal::describe(fault, {static_cast<haptics::DeviceState>(live.fault_state.load(relaxed)),
                               live.device_fault.load(relaxed), live.fault_limits.load(relaxed)});
}

std::filesystem::path fault_tape_of(const Session& session) { return file_of_hand(kFaultTape, session.options.hand); }

Status write_fault_tape(const Session& session) {
  static std::mutex one_writer;  // of the one file
  const std::lock_guard lock(one_writer);
  const std::string path = fault_tape_of(session).string();
  const std::string part = path + ".part";
  const Status written = session.drain->dump(part, session.tape_text());
  if (!written.ok()) return written;
  if (std::rename(part.c_str(), path.c_str()) == 0) return Status::good();
  return Status::error(fmt::format("{}: {}", path, strerrordesc_np(errno)));
}

static Result<std::vector<RunSummary>> run_realtime(std::span<Session* const> sessions, const HandsHooks& hooks,
                                                    const std::atomic<bool>& stop) {
  Session& first = *sessions.front();
  const RunOptions& options = first.options;
  for (const Session* session : sessions)
    if (const Status status = check_core("--cpu", session->options.cpu); !status.ok()) return status;
  for (const int cpu : options.world_cpus)
    if (const Status status = check_core("--world-cpu", cpu); !status.ok()) return status;
  HandRuns runs;
  for (std::size_t hand = 0; hand < sessions.size(); ++hand)
    runs.push_back(
        std::make_unique<HandRun>(*sessions[hand], hand < hooks.hands.size() ? hooks.hands[hand] : HandHooks{}));
  for (const auto& run : runs)
    if (const Status status = run->calibrate(); !status.ok()) return status;

  std::optional<sim::GlobalThread> world;
  if (first.global != nullptr) {
    if (const Status& status = first.workers->status(); !status.ok()) return status;
    set_denormals_flush();  // this thread computes the first snapshot, G(0)
    sim::GlobalThreadOptions world_options;
    if (!options.world_cpus.empty()) world_options.cpu = options.world_cpus.front();
    world_options.stalls = wall_clock_stalls(first);
    world_options.stepped = hooks.stepped;
    std::vector<haptics::Exchange*> exchanges;
    for (Session* session : sessions) exchanges.push_back(session->exchange.get());
    world.emplace(*first.global, std::move(exchanges), world_options);
    if (const Status status = world->start(); !status.ok()) return status;
  }
  for (Session* session : sessions)
    if (session->drain != nullptr)
      if (const Status status = session->drain->start(); !status.ok()) return status;

  for (const auto& run : runs)
    if (const Status status = run->start(); !status.ok()) return status;
  for (std::size_t hand = 0; hand < runs.size(); ++hand)
    if (hand < hooks.hands.size() && hooks.hands[hand].began) hooks.hands[hand].began(runs[hand]->setup_report());
  attend(runs, hooks, stop);
  for (const auto& run : runs) run->request_end();
  for (const auto& run : runs) run->end_device();
  for (const auto& run : runs) run->stop();
  if (world) world->stop();
  std::vector<RunSummary> summaries;
  for (std::size_t hand = 0; hand < runs.size(); ++hand) {
    if (sessions[hand]->gpio != nullptr) sessions[hand]->gpio->off();
    summaries.push_back(runs[hand]->summary(world ? &*world : nullptr));
  }
  return summaries;
}

Result<RunSummary> run_realtime(Session& session, const RealtimeHooks& hooks, const std::atomic<bool>& stop) {
  HandsHooks all;
  all.asked = hooks.asked;
  all.say = hooks.say;
  all.look_every = hooks.look_every;
  if (hooks.show)
    all.show = [&](std::span<const LiveStatus* const> live, double elapsed_s) {
      return hooks.show(*live.front(), elapsed_s);
    };
  all.stepped = {hooks.taps.stepped, hooks.taps.context};
  all.hands = {{.began = hooks.began, .requests = hooks.requests, .probe = hooks.probe, .taps = hooks.taps}};
  Session* const only = &session;
  auto summaries = run_realtime({&only, 1}, all, stop);
  if (!summaries.ok()) return summaries.status();
  return std::move(summaries.value().front());
}

Result<std::vector<RunSummary>> run_realtime(Hands& hands, const HandsHooks& hooks, const std::atomic<bool>& stop) {
  std::vector<Session*> sessions;
  for (unsigned hand = 0; hand < hands.count(); ++hand) sessions.push_back(&hands[hand]);
  return run_realtime(sessions, hooks, stop);
}

}  // namespace tactus::session
