// The haptic thread of a whole session, in a process of its own and held to a few system calls by the kernel; the same
// run counts allocations, locks and page faults. For tests of what it may ask of the kernel after its start.
//
// Thread: run_trial() normal; RtScript::begin() normal, in the child; step() [rt].
#pragma once

#include <fcntl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <ctime>
#include <thread>

#include "rt/thread/periodic_thread.h"
#include "sim/global_thread.h"
#include "tests/support/forked_trial.h"
#include "tests/support/rt_guard.h"
#include "tests/support/syscall_filter.h"
#include "tests/system/session_bench.h"
#include "tools/publication/publication.h"
#include "tools/publication/watcher.h"
#include "tools/session/find_description.h"
#include "tools/session/open_device.h"
#include "tools/session/realtime_tick.h"

namespace tactus::test {

// Allowed system calls: the clock (on some machines it needs no call), the sleep, and the guard's reading of page
// faults.
inline constexpr long kAllowed[]{SYS_clock_gettime, SYS_clock_nanosleep, SYS_getrusage};
inline constexpr std::uint64_t kWarmUp = 200;

struct Counts {
  bool filtered{false}, done{false};
  std::uint64_t ticks{0}, cycles{0}, allocations{0}, frees{0}, locks{0}, faults{0}, refused{0};
  long first_refused{-1};
  std::uint64_t status_ticks[32]{}, latched{0};  // of the whole run: ticks with a StatusBit, faults
  std::uint32_t joints{0};                       // most between two members
  std::uint32_t border_contacts{0}, ghosts{0};   // most
  std::uint64_t frames_seen{0}, ticks_seen{0};   // by the watcher
  unsigned phase{0};                             // that the script came to

  std::uint64_t with(StatusBit bit) const { return status_ticks[std::countr_zero(static_cast<std::uint32_t>(bit))]; }
};

// External events of a run: step() is called after each tick and returns the phase; kOver ends the trial.
class RtScript {
 public:
  static constexpr unsigned kOver = 100;  // the phase in which the trial may end
  virtual ~RtScript() = default;
  virtual void begin() {}                                               // before the device is opened
  virtual unsigned step(const session::Session& session) noexcept = 0;  // the phase that it is in
};

enum class Pace { kRealTime, kAsFastAsItGoes };

struct Trial {
  std::uint64_t ticks{0};
  Pace pace{Pace::kRealTime};
  bool misbehave{false};  // makes one forbidden call in one tick
  const char* scene{"domino_row.toml"};
  const char* scene_of_test{nullptr};            // its text, instead of a file of the project
  std::uint32_t members{4};                      // so that members come and go and there is a border
  const char* inject{""};                        // as --inject; each latched fault is followed by a re-arm
  std::uint32_t cut_at{~0u};                     // sweep at which every tick is cut
  double budget{loop::GovernorConfig{}.budget};  // of the period, for the governor
  std::vector<sim::Stall> stalls{};              // of the global world; in real time only
  haptics::CouplingScheme coupling{haptics::CouplingScheme::kSubWorld};
  const char *device{"sim"}, *device_file{""};
  bool watched{false};        // a watcher reads all ticks and frames that the run publishes
  RtScript* script{nullptr};  // if set, `ticks` is the most that its end is waited for
};

inline std::uint32_t joints_between_members(const physics::World& world) noexcept {
  std::uint32_t count = 0;
  if (const auto* joints = world.effects().find<physics::Joints>())
    joints->for_each_link(world.bodies(), [&](auto, auto, auto) noexcept { ++count; });
  return count;
}

// The body of the haptic thread as a run has it, and the watch over it.
struct Ticks {
  session::Session& session;
  const Trial& trial;
  Counts& counts;
  session::LiveStatus live{};
  std::atomic<std::uint32_t> requests{0};
  session::ArmGate gate{session.same_device};
  session::RealtimeTick tick{session, {live, requests, gate}, ~std::uint64_t{0}};
  std::optional<RtGuard> guard{};

  bool operator()(const loop::TickTiming& timing) noexcept {
    tick(timing);
    const physics::World& members = session.loop->sub_world().world();
    counts.joints = std::max(counts.joints, joints_between_members(members));
    counts.border_contacts = std::max(counts.border_contacts, members.border_contacts().size());
    counts.ghosts = std::max(counts.ghosts, members.border_ghosts().size());
    if (session.stats.ticks == kWarmUp) {
      counts.filtered = install_syscall_filter(kAllowed);
      guard.emplace();
    }
    if (trial.misbehave && session.stats.ticks == kWarmUp + 5) syscall(SYS_getpid);
    if (trial.script != nullptr && guard) counts.phase = trial.script->step(session);
    if (session.stats.ticks < kWarmUp + trial.ticks && counts.phase < RtScript::kOver) return true;
    finish();
    return false;
  }

  void finish() noexcept {
    counts.allocations = guard->allocations();
    counts.frees = guard->frees();
    counts.locks = guard->locks();
    counts.faults = guard->minor_faults() + guard->major_faults();
    counts.ticks = session.stats.ticks - kWarmUp;
    counts.cycles = session.stats.cycles;
    counts.refused = refused_syscalls();
    counts.first_refused = first_refused_syscall();
    std::copy_n(session.stats.status_ticks, std::size(counts.status_ticks), counts.status_ticks);
    counts.latched = session.stats.fault_count;
    std::atomic_thread_fence(std::memory_order_seq_cst);
    static_cast<volatile bool&>(counts.done) = true;
    for (;;) MonotonicClock::sleep_until_ns(INT64_MAX);  // the end of a thread takes other calls; the process ends it
  }
};

// As fast as it goes the haptic side waits for its snapshots, so that no cycle is late however slow the world is.
inline void run_fast(Ticks& ticks) noexcept {
  TACTUS_CHECK(ticks.session.exchange != nullptr, 0, 0);
  const auto& snapshots = ticks.session.exchange->snapshots;
  const auto& loop = *ticks.session.loop;
  // No deadline in this run is ever past.
  loop::TickTiming timing;
  timing.scheduled_ns = timing.woke_ns = INT64_MAX / 2;
  for (bool go = true; go; go = ticks(timing))
    while (loop.wants_snapshot() && snapshots.try_read(loop.next_cycle()) == nullptr) {}
}

// Reads all that the run shows, as fast as it can be read, until the process ends.
inline void watch(publication::Publication& shown, Counts& counts) {
  shown.watchers() = 1;
  auto watcher = publication::Watcher::open(fcntl(shown.descriptor(), F_DUPFD_CLOEXEC, 0));
  REQUIRE(watcher.ok());
  publication::Frame frame;
  std::vector<publication::TickEntry> ticks;
  for (;;) {
    ticks.clear();
    (void)watcher.value()->read_ticks(ticks, publication::kTickEntries);
    counts.ticks_seen += ticks.size();
    counts.frames_seen += watcher.value()->read_frame(frame) ? 1 : 0;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

// In the child: the world and the recorder's drain on threads of their own.
inline void run_child(const Trial& trial, Counts& counts) {
  session::RunOptions options = virtual_options();
  options.members = trial.members;
  options.coupling = trial.coupling;
  options.inject = trial.inject;
  options.device = trial.device;
  options.device_file = trial.device_file;
  options.rearm = true;
  if (trial.script != nullptr) trial.script->begin();
  sim::Scene scene = trial.scene_of_test != nullptr ? scene_text(trial.scene_of_test) : scene_file(trial.scene);
  const auto profile = session::find_description(scene.device.profile, trial.device_file);
  REQUIRE(profile.ok());
  auto hardware = session::open_hardware(options, profile.value());  // empty where the device is simulated
  INFO(hardware.message());
  REQUIRE(hardware.ok());
  auto made_session = session::Session::create(std::move(scene), options, std::move(hardware).value());
  INFO(made_session.message());
  REQUIRE(made_session.ok());
  const auto session = std::move(made_session).value();
  loop::GovernorConfig governor = session->governor->config();
  governor.budget = trial.budget;
  *session->governor = loop::Governor(governor);
  auto made = publication::Publication::create(session->scene, options.period_s(), "{}");
  REQUIRE(made.ok());
  const std::shared_ptr<publication::Publication> shown = std::move(made).value();
  session->shown = {shown->tap(), &shown->watchers(), shown};
  REQUIRE(session->record("").ok());
  set_denormals_flush();
  sim::GlobalThreadOptions on_thread;
  on_thread.stalls = trial.stalls;
  on_thread.stepped = {&publication::Publication::stepped, shown.get()};
  std::optional<sim::GlobalThread> world;
  if (session->global != nullptr) {
    world.emplace(*session->global, *session->exchange, on_thread);
    REQUIRE(world->start().ok());
  }
  REQUIRE(session->drain->start().ok());
  std::optional<std::jthread> watcher;
  if (trial.watched) watcher.emplace([&](const std::stop_token&) { watch(*shown, counts); });
  Ticks ticks{*session, trial, counts};
  ticks.tick.cut_at(trial.cut_at);
  loop::PeriodicThread<Ticks> periodic(ticks);
  std::thread fast;
  if (trial.pace == Pace::kRealTime) {
    loop::PeriodicSettings settings;
    settings.setup.priority = 0;  // the machine's other work goes on
    REQUIRE(periodic.start(settings).ok());
  } else {
    fast = std::thread([&] {
      loop::CpuAwake awake;
      (void)loop::setup_realtime({.priority = 0, .hold_cpu_awake = false}, awake);
      run_fast(ticks);
    });
  }
  while (!static_cast<volatile bool&>(counts.done)) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  _exit(0);
}

inline Counts run_trial(const Trial& trial) {
  const auto result = test::run_forked<Counts>([&](Counts& counts) { run_child(trial, counts); });
  REQUIRE(result.filtered);
  return result;
}

inline void check_clean(const Counts& counts, std::uint64_t ticks) {
  CHECK(counts.ticks == ticks);
  INFO("first refused system call: " << counts.first_refused);
  CHECK(counts.refused == 0);
  CHECK(counts.allocations == 0);
  CHECK(counts.frees == 0);
  CHECK(counts.locks == 0);
  CHECK(counts.faults == 0);
}

}  // namespace tactus::test
