#include "tools/library/session_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>

#include "rt/base/denormals.h"
#include "tools/caught.h"
#include "tools/library/access.h"
#include "tools/library/tick_record.h"
#include "tools/session/find_description.h"
#include "tools/session/realtime_run.h"

namespace tactus {
namespace {

using Kind = Error::Kind;

constexpr std::chrono::milliseconds kLook{33};
// Size of a record in the ring: the tick and a header of 16 bytes, rounded up to a multiple of 16.
constexpr std::uint64_t kRecordBytes = (sizeof(Tick) + 16 + 15) / 16 * 16;

// Flushes denormals on the caller's thread, as on all threads of the program, and restores its mode afterwards.
class DenormalsFlushed {
 public:
  DenormalsFlushed() noexcept { set_denormals_flush(); }
  ~DenormalsFlushed() { restore_float_mode(before_); }
  DenormalsFlushed(const DenormalsFlushed&) = delete;
  DenormalsFlushed& operator=(const DenormalsFlushed&) = delete;

 private:
  decltype(float_mode()) before_{float_mode()};
};

}  // namespace

Error Session::Parts::build_device(session::Hardware& hardware) {
  if (device != nullptr) {
    const DeviceProperties properties = device->properties();
    if (const Status status = library::check_properties(properties); !status.ok())
      return {Kind::kOption, status.message()};
    auto adapter = std::make_unique<library::OwnDevice>(*device, properties, run_options.period_s());
    own = adapter.get();
    hardware.device = std::make_unique<hal::AnyDevice>(std::move(adapter));
    return {};
  }
  const auto profile = session::find_description(library::Access::scene(scene).device.profile, run_options.device_file);
  if (!profile.ok()) return {Kind::kFile, profile.message()};
  auto opened = session::open_hardware(run_options, profile.value());
  if (!opened.ok()) return {Kind::kMachine, opened.message()};
  hardware = std::move(opened).value();
  return {};
}

Error Session::Parts::build() {
  DenormalsFlushed flushed;
  virtual_run.reset();
  session.reset();
  ended.reset();
  own = nullptr;
  started = false;
  requests.store(0, std::memory_order_relaxed);
  stop.store(false, std::memory_order_relaxed);
  if (scene.empty()) return {Kind::kUse, "Session::open: the scene is empty; accepted: after Scene::load"};
  session::Hardware hardware;
  if (Error error = build_device(hardware)) return error;
  auto created = session::Session::create(library::Access::scene(scene), run_options, std::move(hardware));
  if (!created.ok()) return {Kind::kOption, created.message()};
  session = std::move(created).value();
  last = {};
  history.resize(options.history_ticks);
  history_size = 0;
  view.bind(*session);
  view_is_old = true;
  if (options.real_time) {
    make_real_time();
    return {};
  }
  if (const Status status = session::VirtualRun::check(*session); !status.ok())
    return {Kind::kMachine, status.message()};
  virtual_run.emplace(*session);
  return {};
}

void Session::Parts::make_real_time() {
  const std::uint64_t bytes = std::bit_ceil(std::max<std::uint64_t>(options.history_ticks, 64) * kRecordBytes);
  ring = std::make_unique<Ring>(bytes);
  dropped_before = 0;
  hand_over = std::make_unique<library::StateHandOver>();
  hand_over->bind(*session);
}

Error Session::Parts::start_device() {
  if (started) return {};
  const Status status = session->device->start();
  started = status.ok();
  return started ? Error() : Error(Kind::kMachine, status.message());
}

void Session::Parts::end() {
  if (session == nullptr) return;
  if (own != nullptr) own->finish();
  if (!ended) {
    session::RunSummary summary = session->summary();
    session->close_tape(summary);
    ended = std::move(summary);
  }
}

void Session::Parts::step(std::uint64_t ticks) {
  DenormalsFlushed flushed;
  const std::size_t room = history.size();
  std::uint64_t done = 0;
  for (; done < ticks && !stop.load(std::memory_order_relaxed); ++done) {
    const std::uint32_t asked = requests.load(std::memory_order_relaxed) != 0 ? requests.exchange(0) : 0u;
    virtual_run->tick(asked);
    last = library::to_tick(*session->driver, session->options.period_s());
    history[done % room] = last;
  }
  stop.store(false, std::memory_order_relaxed);
  history_size = static_cast<std::size_t>(std::min<std::uint64_t>(done, room));
  if (done > room)
    std::rotate(history.begin(), history.begin() + static_cast<std::ptrdiff_t>(done % room), history.end());
  view_is_old = view_is_old || done > 0;
}

// Reads the ring and keeps the newest history_ticks; returns the number of ticks lost.
std::uint64_t Session::Parts::take_ticks() {
  const std::size_t room = history.size();
  std::uint64_t taken = 0;
  RingRecord record;
  Tick tick;
  while (ring->try_pop(record, std::as_writable_bytes(std::span<Tick, 1>(&tick, 1))) == Pop::kRecord) {
    history[taken++ % room] = tick;
  }
  const std::uint64_t dropped = ring->dropped();
  std::uint64_t lost = dropped - dropped_before;
  dropped_before = dropped;
  history_size = static_cast<std::size_t>(std::min<std::uint64_t>(taken, room));
  if (taken > room) {
    lost += taken - room;
    std::rotate(history.begin(), history.begin() + static_cast<std::ptrdiff_t>(taken % room), history.end());
  }
  if (history_size > 0) last = history[history_size - 1];
  return lost;
}

Error Session::Parts::run(double duration_s, const Monitor& monitor) {
  DenormalsFlushed flushed;
  session->options.duration_s = duration_s;
  session::RealtimeHooks hooks;
  hooks.look_every = kLook;
  hooks.requests = &requests;
  hooks.taps.context = this;
  hooks.taps.ticked = [](void* self, const session::Driver& driver) noexcept {
    auto& parts = *static_cast<Parts*>(self);
    const Tick tick = library::to_tick(driver, parts.session->options.period_s());
    (void)parts.ring->try_push(0, std::span<const Tick, 1>(&tick, 1));  // the ring counts a tick that does not fit
  };
  if (monitor)
    hooks.taps.stepped = [](void* self, const sim::GlobalWorld& world) noexcept {
      static_cast<Parts*>(self)->hand_over->take(world);
    };
  Progress progress;
  const auto show = [&] {
    progress.ticks_lost = take_ticks();
    progress.ticks = {history.data(), history_size};
    in_monitor = true;
    const bool goes_on = monitor(progress);
    in_monitor = false;
    return goes_on;
  };
  if (monitor)
    hooks.show = [&](const session::LiveStatus& live, double elapsed_s) {
      progress.overruns = live.overruns.load(std::memory_order_relaxed);
      progress.elapsed_s = elapsed_s;
      return show();
    };
  auto summary = session::run_realtime(*session, hooks, stop);
  stop.store(false, std::memory_order_relaxed);
  started = true;
  view_is_old = true;
  if (!summary.ok()) return {Kind::kMachine, summary.message()};
  ended = std::move(summary).value();
  if (monitor) {
    progress.overruns = ended->timing.overruns;
    progress.elapsed_s = ended->wall_s;
    (void)show();
  } else {
    (void)take_ticks();
  }
  return {};
}

void Session::Parts::look() {
  if (session == nullptr) return;
  if (in_monitor) {
    (void)hand_over->look(view);
    return;
  }
  if (!view_is_old) return;
  view_is_old = false;
  view.look(*session);
}

session::RunSummary Session::Parts::summary() const { return ended ? *ended : session->summary(); }

}  // namespace tactus
