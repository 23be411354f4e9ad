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

void Session::Parts::Hand::keep(std::uint64_t written) {
  const std::size_t capacity = history.size();
  history_size = static_cast<std::size_t>(std::min<std::uint64_t>(written, capacity));
  if (written > capacity)
    std::rotate(history.begin(), history.begin() + static_cast<std::ptrdiff_t>(written % capacity), history.end());
}

Error Session::Parts::check() const {
  if (scene.empty()) return {Kind::kUse, "Session::open: the scene is empty; accepted: after Scene::load"};
  if (!devices.empty() && devices.size() != each.size())
    return {Kind::kOption, fmt::format("Session::open: {}: {} devices for {} hands; accepted: one for each, null: the "
                                       "simulated one",
                                       scene.name(), devices.size(), each.size())};
  if (options.more_injects.size() >= each.size())
    return {Kind::kOption, fmt::format("more_injects: {} beside --inject, for {} hands; accepted: up to {}",
                                       options.more_injects.size(), each.size(), each.size() - 1)};
  if (options.real_time && each.size() > 1)
    return {Kind::kOption, fmt::format("real_time: {} has {} hands; accepted: --virtual-time, or `tactus run`",
                                       scene.name(), each.size())};
  return {};
}

Error Session::Parts::build_device(unsigned hand, session::Hardware& hardware) {
  const session::RunOptions& own_options = run_options[hand];
  if (!devices.empty() && devices[hand] != nullptr) {
    const DeviceProperties properties = devices[hand]->properties();
    if (const Status status = library::check_properties(properties); !status.ok())
      return {Kind::kOption, status.message()};
    auto adapter = std::make_unique<library::OwnDevice>(*devices[hand], properties, own_options.period_s());
    each[hand].own = adapter.get();
    hardware.device = std::make_unique<hal::AnyDevice>(std::move(adapter));
    return {};
  }
  const std::string profile_name = sim::scene_of_hand(library::Access::scene(scene), hand).device.profile;
  const auto profile = session::find_description(profile_name, own_options.device_file);
  if (!profile.ok()) return {Kind::kFile, profile.message()};
  auto opened = session::open_hardware(own_options, profile.value());
  if (!opened.ok()) return {Kind::kMachine, opened.message()};
  hardware = std::move(opened).value();
  return {};
}

Error Session::Parts::build() {
  DenormalsFlushed flushed;
  virtual_run.reset();
  sessions.clear();
  hands.reset();
  stop.store(false, std::memory_order_relaxed);
  for (Hand& hand : each) {
    hand.ended.reset();
    hand.own = nullptr;
    hand.started = false;
    hand.requests.store(0, std::memory_order_relaxed);
    hand.last = {};
    hand.history.resize(options.history_ticks);
    hand.history_size = 0;
  }
  if (Error error = check()) return error;
  std::vector<session::Hardware> hardware(each.size());
  for (unsigned hand = 0; hand < each.size(); ++hand)
    if (Error error = build_device(hand, hardware[hand])) return error;
  auto created = session::Hands::create(library::Access::scene(scene), run_options, std::move(hardware));
  if (!created.ok()) return {Kind::kOption, created.message()};
  hands.emplace(std::move(created).value());
  sessions = hands->sessions();
  view.bind(sessions);
  view_is_old = true;
  asked_.assign(each.size(), 0);
  if (options.real_time) {
    make_real_time();
    return {};
  }
  if (const Status status = session::VirtualRun::check(*sessions[0]); !status.ok())
    return {Kind::kMachine, status.message()};
  virtual_run.emplace(*hands);
  return {};
}

void Session::Parts::make_real_time() {
  const std::uint64_t bytes = std::bit_ceil(std::max<std::uint64_t>(options.history_ticks, 64) * kRecordBytes);
  ring = std::make_unique<Ring>(bytes);
  dropped_before = 0;
  hand_over = std::make_unique<library::StateHandOver>();
  hand_over->bind(sessions);
}

Error Session::Parts::start_devices() {
  for (unsigned hand = 0; hand < each.size(); ++hand) {
    if (each[hand].started) continue;
    const Status status = sessions[hand]->device->start();
    each[hand].started = status.ok();
    if (!status.ok()) return {Kind::kMachine, status.message()};
  }
  return {};
}

void Session::Parts::end() {
  if (!hands) return;
  for (Hand& hand : each)
    if (hand.own != nullptr) hand.own->finish();
  for (unsigned hand = 0; hand < each.size(); ++hand) {
    if (each[hand].ended) continue;
    session::RunSummary summary = sessions[hand]->summary();
    sessions[hand]->close_tape(summary);
    each[hand].ended = std::move(summary);
  }
}

void Session::Parts::step(std::uint64_t ticks) {
  DenormalsFlushed flushed;
  const double period_s = sessions[0]->options.period_s();
  std::uint64_t done = 0;
  for (; done < ticks && !stop.load(std::memory_order_relaxed); ++done) {
    for (std::size_t hand = 0; hand < each.size(); ++hand) {
      auto& requests = each[hand].requests;
      asked_[hand] = requests.load(std::memory_order_relaxed) != 0 ? requests.exchange(0) : 0u;
    }
    virtual_run->tick(asked_);
    for (unsigned hand = 0; hand < each.size(); ++hand) {
      Hand& of = each[hand];
      of.last = library::to_tick(*sessions[hand]->driver, period_s);
      of.history[done % of.history.size()] = of.last;
    }
  }
  stop.store(false, std::memory_order_relaxed);
  for (Hand& hand : each) hand.keep(done);
  view_is_old = view_is_old || done > 0;
}

// Reads the ring and keeps the newest history_ticks; returns the number of ticks lost.
std::uint64_t Session::Parts::take_ticks() {
  Hand& hand = each.front();
  const std::size_t capacity = hand.history.size();
  std::uint64_t taken = 0;
  RingRecord record;
  Tick tick;
  while (ring->try_pop(record, std::as_writable_bytes(std::span<Tick, 1>(&tick, 1))) == Pop::kRecord) {
    hand.history[taken++ % capacity] = tick;
  }
  const std::uint64_t dropped = ring->dropped();
  std::uint64_t lost = dropped - dropped_before;
  dropped_before = dropped;
  hand.keep(taken);
  if (taken > capacity) lost += taken - capacity;
  if (hand.history_size > 0) hand.last = hand.history[hand.history_size - 1];
  return lost;
}

Error Session::Parts::run(double duration_s, const Monitor& monitor) {
  DenormalsFlushed flushed;
  Hand& hand = each.front();
  sessions[0]->options.duration_s = duration_s;
  session::RealtimeHooks hooks;
  hooks.look_every = kLook;
  hooks.requests = &hand.requests;
  hooks.taps.context = this;
  hooks.taps.ticked = [](void* self, const session::Driver& driver) noexcept {
    auto& parts = *static_cast<Parts*>(self);
    const Tick tick = library::to_tick(driver, parts.sessions[0]->options.period_s());
    (void)parts.ring->try_push(0, std::span<const Tick, 1>(&tick, 1));  // the ring counts a tick that does not fit
  };
  if (monitor)
    hooks.taps.stepped = [](void* self, const sim::GlobalWorld& world) noexcept {
      static_cast<Parts*>(self)->hand_over->take(world);
    };
  Progress progress;
  const auto show = [&] {
    progress.ticks_lost = take_ticks();
    progress.ticks = {hand.history.data(), hand.history_size};
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
  auto summary = session::run_realtime(*sessions[0], hooks, stop);
  stop.store(false, std::memory_order_relaxed);
  hand.started = true;
  view_is_old = true;
  if (!summary.ok()) return {Kind::kMachine, summary.message()};
  hand.ended = std::move(summary).value();
  if (monitor) {
    progress.overruns = hand.ended->timing.overruns;
    progress.elapsed_s = hand.ended->wall_s;
    (void)show();
  } else {
    (void)take_ticks();
  }
  return {};
}

void Session::Parts::look() {
  if (!hands) return;
  if (in_monitor) {
    (void)hand_over->look(view);
    return;
  }
  if (!view_is_old) return;
  view_is_old = false;
  view.look(sessions);
}

session::RunSummary Session::Parts::summary(unsigned hand) const {
  return each[hand].ended ? *each[hand].ended : sessions[hand]->summary();
}

}  // namespace tactus
