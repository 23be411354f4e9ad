#include "tools/session/realtime_run.h"

#include <fmt/format.h>
#include <sched.h>

#include <chrono>
#include <thread>

#include "hal/device_words.h"
#include "rt/base/denormals.h"
#include "rt/loop/calibration.h"
#include "rt/loop/periodic_thread.h"
#include "sim/global_thread.h"
#include "tools/caught.h"
#include "tools/session/arm_gate.h"
#include "tools/session/stolen_time.h"

namespace tactus::session {
namespace {

// The cut fires this far into the period: what is left is for the relax sweep in reserve and for the device.
constexpr double kCutShare = 0.85;
// The last ticks of a run on a real device: its force fades, then it goes to IDLE and is not left to its watchdog.
constexpr double kEnd_s = 2 * loop::kEndFade_s;
// Lines of refused re-arms that a summary keeps.
constexpr std::size_t kMostRefusals = 16;

int last_allowed_cpu() {
  cpu_set_t set;
  CPU_ZERO(&set);
  if (sched_getaffinity(0, sizeof(set), &set) != 0) return -1;
  for (int cpu = CPU_SETSIZE - 1; cpu >= 0; --cpu)
    if (CPU_ISSET(cpu, &set)) return cpu;
  return -1;
}

struct Deadline {
  std::int64_t cut_ns{0};
  loop::TickProbe* probe{nullptr};
  static bool passed(void* self, std::uint32_t) noexcept {
    const auto& deadline = *static_cast<const Deadline*>(self);
    const std::int64_t now_ns = MonotonicClock::now_ns();
    if (deadline.probe != nullptr) deadline.probe->sweep_begins(now_ns);
    return now_ns > deadline.cut_ns;
  }
};

// The haptic thread's tick: the driver's three stages, each timed, and the books.
class RealtimeTick {
 public:
  RealtimeTick(Session& session, LiveStatus& live, std::atomic<std::uint32_t>& requests, std::uint64_t most_ticks,
               ArmGate& gate, const RealtimeHooks& hooks)
      : session_(session),
        probe_(hooks.probe),
        taps_(hooks.taps),
        gpio_(session.gpio.get()),
        live_(live),
        requests_(requests),
        gate_(gate),
        most_ticks_(most_ticks),
        period_ns_(static_cast<std::int64_t>(session.options.period_s() * 1e9)),
        real_(session.simulated() == nullptr),
        end_ticks_(static_cast<std::uint64_t>(std::llround(kEnd_s * session.options.rate_Hz))) {}

  bool operator()(const loop::TickTiming& timing) noexcept {
    if (probe_ != nullptr && !probe_begins(timing)) return true;
    Driver& driver = *session_.driver;
    cpu_began_ns_ = MonotonicClock::thread_cpu_ns();
    if (gpio_ != nullptr) gpio_->probe(true);
    driver.read();
    const std::int64_t read_ns = MonotonicClock::now_ns();
    if (probe_ != nullptr) probe_->read_done(read_ns);
    Deadline deadline{timing.scheduled_ns + static_cast<std::int64_t>(kCutShare * static_cast<double>(period_ns_)),
                      probe_};
    const loop::TickOutput& out = driver.compute(operator_bits(), {&Deadline::passed, &deadline},
                                                 probe_ != nullptr ? probe_->stages() : loop::StageObserver{});
    const std::int64_t computed_ns = MonotonicClock::now_ns();
    driver.write();
    if (gpio_ != nullptr) show_on_lines(out);
    const std::int64_t wrote_ns = MonotonicClock::now_ns();
    if (probe_ != nullptr) probe_ends(out, computed_ns, wrote_ns);

    compute.record(computed_ns - read_ns);
    forecast.add(driver.plan().predicted_ns, static_cast<double>(computed_ns - read_ns));
    device.record((read_ns - timing.woke_ns) + (wrote_ns - computed_ns));
    session_.count_tick();
    if (taps_.ticked != nullptr) taps_.ticked(taps_.context, driver);
    judge(timing, wrote_ns);
    show(out);
    return session_.stats.ticks < most_ticks_ && ended_ticks_ < end_ticks_;
  }

  // [normal] The loop ends by itself, after the force has faded and the device has had time to go to IDLE.
  void end() noexcept { ending_.store(true, std::memory_order_relaxed); }
  bool must_end() const noexcept { return real_; }

  Histogram compute, device;
  loop::ForecastStats forecast;
  std::uint64_t late_wake{0}, own_work{0}, interrupted{0};

 private:
  // What is asked of the loop in this tick, by whoever may.
  std::uint32_t operator_bits() noexcept {
    constexpr auto relaxed = std::memory_order_relaxed;
    const std::uint32_t requests = requests_.load(relaxed) != 0 ? requests_.exchange(0, relaxed) : 0u;
    std::uint32_t bits = gate_.pass(session_.operator_bits(requests));
    if (real_ && (ending_.load(relaxed) || session_.stats.ticks + end_ticks_ >= most_ticks_)) {
      bits |= loop::kEnd;
      ++ended_ticks_;
    }
    if (gpio_ != nullptr && gpio_->estop()) bits |= loop::kStopLine;
    return bits;
  }

  void judge(const loop::TickTiming& timing, std::int64_t ended_ns) noexcept {
    const bool overran = ended_ns > timing.scheduled_ns + period_ns_;
    if (overran) {
      const auto wake_late_ns = static_cast<double>(timing.woke_ns - timing.scheduled_ns);
      const auto used_ns = static_cast<double>(MonotonicClock::thread_cpu_ns() - cpu_began_ns_);
      const double predicted_ns = session_.driver->plan().predicted_ns;
      switch (loop::classify_overrun(wake_late_ns, used_ns, predicted_ns, static_cast<double>(period_ns_))) {
        case loop::OverrunCause::kLateWake:
          ++late_wake;
          break;
        case loop::OverrunCause::kOwnWork:
          ++own_work;
          break;
        case loop::OverrunCause::kInterrupted:
          ++interrupted;
          break;
      }
    }
  }

  // False: the window is not the loop's.
  bool probe_begins(const loop::TickTiming& timing) noexcept {
    switch (probe_->window(timing)) {
      case loop::WindowKind::kLoop:
        probe_->begin(timing);
        return true;
      case loop::WindowKind::kBare:
        probe_->bare(timing);
        return false;
      case loop::WindowKind::kRest:
        probe_->rest(timing, period_ns_);
        return false;
    }
    return true;
  }
  void probe_ends(const loop::TickOutput& out, std::int64_t computed_ns, std::int64_t wrote_ns) noexcept {
    loop::TickTimes& times = probe_->times();
    times.foreseen_ns = static_cast<std::int64_t>(session_.driver->plan().predicted_ns);
    times.members = out.members, times.contacts = out.contacts, times.points = out.points, times.border = out.border;
    times.sub_steps = session_.driver->sub_steps();
    probe_->end(computed_ns, wrote_ns);
  }

  // The drives are enabled as long as force is wanted; a fault takes the line back with the command that brakes.
  void show_on_lines(const loop::TickOutput& out) noexcept {
    gpio_->enable(out.command.wanted == haptics::DeviceState::kForce);
    gpio_->heartbeat();
    gpio_->probe(false);
  }

  void show(const loop::TickOutput& out) noexcept {
    constexpr auto relaxed = std::memory_order_relaxed;
    live_.ticks.store(session_.stats.ticks, relaxed);
    live_.overruns.store(late_wake + own_work + interrupted, relaxed);
    live_.late_cycles.store(session_.stats.late_cycles, relaxed);
    live_.force_N.store(norm(out.command.wrench.force), relaxed);
    live_.members.store(out.members, relaxed);
    live_.contacts.store(out.contacts, relaxed);
    live_.border.store(out.border, relaxed);
    live_.status.store(out.status, relaxed);
    const haptics::DeviceSample& sample = session_.driver->sample();
    live_.device_state.store(static_cast<std::uint32_t>(sample.state), relaxed);
    live_.device_limits.store(sample.limits, relaxed);
    if (out.fault == Fault::kNone || sample.device_fault != 0) live_.device_fault.store(sample.device_fault, relaxed);
    if (static_cast<std::uint32_t>(out.fault) != live_.fault.load(relaxed)) {
      live_.fault_state.store(static_cast<std::uint32_t>(sample.state), relaxed);
      live_.fault_limits.store(sample.limits, relaxed);
    }
    live_.fault_count.store(session_.stats.fault_count, relaxed);
    live_.fault.store(static_cast<std::uint32_t>(out.fault), relaxed);
    live_.resets.store(session_.loop->sub_world().epoch(), relaxed);
  }

  Session& session_;
  loop::TickProbe* probe_;  // null: nobody looks into the tick
  RealtimeTaps taps_;
  hal::GpioLines* gpio_;  // null: no lines
  LiveStatus& live_;
  std::atomic<std::uint32_t>& requests_;
  ArmGate& gate_;
  std::uint64_t most_ticks_;
  std::int64_t period_ns_;
  bool real_;  // the device outlives the run
  std::uint64_t end_ticks_, ended_ticks_{0};
  std::atomic<bool> ending_{false};
  std::int64_t cpu_began_ns_{0};  // the thread's own clock at the start of the tick
};

// The cost model of the core that the loop will run on, measured at its priority.
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

// Shows and listens until the run is over.
void attend(const loop::PeriodicThread<RealtimeTick>& thread, const LiveStatus& live, const RealtimeHooks& hooks,
            std::atomic<std::uint32_t>& requests, ArmGate& gate, const std::atomic<bool>& stop,
            std::vector<std::string>& refusals) {
  const auto began = std::chrono::steady_clock::now();
  while (thread.running() && !stop.load(std::memory_order_relaxed)) {
    std::this_thread::sleep_for(hooks.look_every);
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - began;
    if (hooks.asked) {
      const std::uint32_t asked = hooks.asked();
      requests.fetch_or(asked, std::memory_order_relaxed);
      if ((asked & loop::kRearm) != 0 && hooks.say && !has_to_rearm(live))
        hooks.say("re-arm: nothing is latched, nothing was done");
    }
    if (const Status status = gate.look(); !status.ok()) {
      const bool repeated = !refusals.empty() && refusals.back() == status.message();
      if (hooks.say && !repeated) hooks.say("not armed: " + status.message());
      if (!repeated && refusals.size() < kMostRefusals) refusals.push_back(status.message());
    }
    if (hooks.show && !hooks.show(live, elapsed.count())) return;
  }
}

// Bound: five times what the ending takes on a machine that keeps its rate.
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
    set_denormals_flush();  // G(0) is made on this thread
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
  RealtimeTick tick(session, live, requests, most_ticks, gate, hooks);
  loop::PeriodicThread<RealtimeTick> thread(tick);
  const auto began = std::chrono::steady_clock::now();
  if (const Status status = session.device->start(); !status.ok()) return status;
  const auto cpu_before = cpu_time_now(settings.setup.cpu);
  if (const Status status = thread.start(settings); !status.ok()) return status;
  attend(thread, live, hooks, requests, gate, stop, refusals);
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
    const std::string path = "tactus-fault.tape";
    const Status dumped = session.drain->dump(
        path, to_tape_text(options, session.device->properties(), session.scene.name, session.scene.source));
    (dumped.ok() ? summary.fault_tape : summary.fault_tape_error) = dumped.ok() ? path : dumped.message();
  }
  return summary;
}

}  // namespace tactus::session
