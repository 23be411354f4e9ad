#include "tools/session/realtime_run.h"

#include <fmt/format.h>
#include <sched.h>

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
#include "tools/session/stolen_time.h"

namespace tactus::session {
namespace {

// Maximum number of refused re-arms listed in a summary.
constexpr std::size_t kMaxRefusals = 16;

int last_allowed_cpu() {
  cpu_set_t set;
  CPU_ZERO(&set);
  if (sched_getaffinity(0, sizeof(set), &set) != 0) return -1;
  for (int cpu = CPU_SETSIZE - 1; cpu >= 0; --cpu)
    if (CPU_ISSET(cpu, &set)) return cpu;
  return -1;
}

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

// Serves display, operator requests and the arm gate until the run is over. Adds the refused re-arms to `refusals`.
void attend(const loop::PeriodicThread<RealtimeTick>& thread, const SharedWithRun& shared, const RealtimeHooks& hooks,
            const std::atomic<bool>& stop, std::vector<std::string>& refusals) {
  const auto began = std::chrono::steady_clock::now();
  while (thread.running() && !stop.load(std::memory_order_relaxed)) {
    std::this_thread::sleep_for(hooks.look_every);
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - began;
    if (hooks.asked) {
      const std::uint32_t asked = hooks.asked();
      shared.requests.fetch_or(asked, std::memory_order_relaxed);
      if ((asked & loop::kRearm) != 0 && hooks.say && !has_to_rearm(shared.live))
        hooks.say("re-arm: nothing is latched, nothing was done");
    }
    if (const Status status = shared.gate.look(); !status.ok()) {
      const bool repeated = !refusals.empty() && refusals.back() == status.message();
      if (hooks.say && !repeated) hooks.say("not armed: " + status.message());
      if (!repeated && refusals.size() < kMaxRefusals) refusals.push_back(status.message());
    }
    if (hooks.show && !hooks.show(shared.live, elapsed.count())) return;
  }
}

// Bound: five times the duration of the ending on a machine that keeps the rate.
void end_device(RealtimeTick& tick, const loop::PeriodicThread<RealtimeTick>& thread) {
  tick.end();
  constexpr std::chrono::milliseconds kPiece{5};
  for (auto left = std::chrono::duration<double>(5 * kEnd_s); left.count() > 0 && thread.running(); left -= kPiece)
    std::this_thread::sleep_for(kPiece);
}

}  // namespace

std::string fault_line(const LiveStatus& live) {
  constexpr auto relaxed = std::memory_order_relaxed;
  const auto fault = static_cast<Fault>(live.fault.load(relaxed));
  if (fault == Fault::kNone) return {};
  return hal::describe(fault, {static_cast<haptics::DeviceState>(live.fault_state.load(relaxed)),
                               live.device_fault.load(relaxed), live.fault_limits.load(relaxed)});
}

Status write_fault_tape(const Session& session) {
  static std::mutex one_writer;  // of the one file
  const std::lock_guard lock(one_writer);
  const std::string part = std::string(kFaultTape) + ".part";
  const Status written = session.drain->dump(part, session.tape_text());
  if (!written.ok()) return written;
  if (std::rename(part.c_str(), kFaultTape) == 0) return Status::good();
  return Status::error(fmt::format("{}: {}", kFaultTape, strerrordesc_np(errno)));
}

Result<RunSummary> run_realtime(Session& session, const RealtimeHooks& hooks, const std::atomic<bool>& stop) {
  const RunOptions& options = session.options;
  loop::PeriodicSettings settings;
  settings.period = std::chrono::nanoseconds(std::llround(options.period_s() * 1e9));
  settings.setup.cpu = options.cpu >= 0 ? options.cpu : last_allowed_cpu();
  settings.setup.priority = options.priority;
  loop::Calibration calibration;
  if (const Status status = calibrate_governor(session, settings.setup, calibration); !status.ok()) return status;

  std::optional<sim::GlobalThread> world;
  if (session.global != nullptr) {
    if (const Status& status = session.workers->status(); !status.ok()) return status;
    set_denormals_flush();  // this thread computes the first snapshot, G(0)
    sim::GlobalThreadOptions world_options;
    if (!options.world_cpus.empty()) world_options.cpu = options.world_cpus.front();
    world_options.stalls = wall_clock_stalls(session);
    world_options.stepped = {hooks.taps.stepped, hooks.taps.context};
    world.emplace(*session.global, *session.exchange, world_options);
    if (const Status status = world->start(); !status.ok()) return status;
  }
  if (session.drain != nullptr)
    if (const Status status = session.drain->start(); !status.ok()) return status;

  LiveStatus live;
  std::atomic<std::uint32_t> own_requests{0};
  std::atomic<std::uint32_t>& requests = hooks.requests != nullptr ? *hooks.requests : own_requests;
  const auto most_ticks = options.duration_s > 0
                              ? static_cast<std::uint64_t>(std::llround(options.duration_s * options.rate_Hz))
                              : ~std::uint64_t{0};
  ArmGate gate(session.same_device);
  std::vector<std::string> refusals;
  const SharedWithRun shared{live, requests, gate};
  RealtimeTick tick(session, shared, most_ticks, hooks.probe, hooks.taps);
  loop::PeriodicThread<RealtimeTick> thread(tick);
  const auto began = std::chrono::steady_clock::now();
  if (const Status status = session.device->start(); !status.ok()) return status;
  const auto cpu_before = cpu_time_now(settings.setup.cpu);
  if (const Status status = thread.start(settings); !status.ok()) return status;
  if (hooks.began) hooks.began(thread.setup_report());
  attend(thread, shared, hooks, stop, refusals);
  if (tick.must_end()) end_device(tick, thread);
  thread.stop();
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - began;
  if (world) world->stop();
  if (session.gpio != nullptr) session.gpio->enable(false);

  RunSummary summary = session.summary();
  summary.real_time = true;
  summary.wall_s = wall.count();
  summary.arm_refusals = std::move(refusals);
  summary.setup = thread.setup_report();
  summary.timing = thread.health();
  summary.compute = tick.compute;
  summary.device = tick.device;
  summary.overruns_late_wake = tick.late_wake;
  summary.overruns_own_work = tick.own_work;
  summary.overruns_interrupted = tick.interrupted;
  summary.calibration = calibration;
  summary.forecast = tick.forecast;
  summary.haptic_cpu = settings.setup.cpu;
  summary.stolen_share = stolen_share(cpu_before, cpu_time_now(settings.setup.cpu));
  if (world) summary.global_step = world->step_times();
  if (session.drain == nullptr) return summary;

  session.close_tape(summary);
  if (summary.fault_latched() || summary.overruns_own_work > 0) {
    const Status dumped = write_fault_tape(session);
    (dumped.ok() ? summary.fault_tape : summary.fault_tape_error) = dumped.ok() ? kFaultTape : dumped.message();
  }
  return summary;
}

}  // namespace tactus::session
