// Ticks whose instructions tools/bench/view_instructions counts: bench_watched_tick SCENE sub-world|direct MODE TICKS,
// on one thread. MODE: untimed, as in virtual time; alone, with the record of each tick's times, as in real time;
// watched, the same with a watcher.
//
// The clock of the last two counts its own readings: so the ticks of both are the same, bit by bit.
#include <cstdio>
#include <cstdlib>
#include <string_view>

#include "rt/base/denormals.h"
#include "rt/loop/timed_tick.h"
#include "sim/loader/scene_load.h"
#include "sim/model/choice_names.h"
#include "sim/snapshot_server.h"
#include "tools/publication/publication.h"
#include "tools/session/session.h"

namespace tactus::bench {

struct CountingClock {
  static inline std::int64_t now{0};
  static std::int64_t now_ns() noexcept { return ++now; }
  static std::int64_t thread_cpu_ns() noexcept { return ++now; }
};

// The haptic thread's share: what is counted.
template <class Clock>
[[gnu::noinline]] void haptic_tick(session::Session& session) {
  loop::TimedTick<hal::AnyDevice, loop::NoLines, Clock> tick(*session.driver, 1'000'000);
  const std::int64_t now_ns = Clock::now_ns();
  tick({.scheduled_ns = now_ns, .woke_ns = now_ns}, [&]() noexcept { return session.operator_bits(); });
}

Status run(const char* file, std::string_view coupling, std::string_view mode, int ticks) {
  auto scene = sim::load_scene(file);
  if (!scene.ok()) return scene.status();
  session::RunOptions options;
  options.virtual_time = true;
  options.duration_s = 1;
  const auto scheme = sim::parse_coupling_scheme(coupling);
  if (!scheme) return Status::error("the coupling's name is wrong");
  options.coupling = *scheme;
  auto made = session::Session::create(std::move(scene).value(), options);
  if (!made.ok()) return made.status();
  session::Session& session = *made.value();
  auto opened = publication::Publication::create(session.scene, options.period_s(), "{}");
  if (!opened.ok()) return opened.status();
  const std::shared_ptr<publication::Publication> publication(opened.value().release());
  if (mode == "watched") publication->watchers() = 1;
  session.shown = {publication->tap(), &publication->watchers(), publication};
  if (Status status = session.record(""); !status.ok()) return status;
  set_denormals_flush();
  std::optional<sim::SnapshotServer> server;
  if (session.global != nullptr) server.emplace(*session.global, *session.exchange).publish_first();
  for (int i = 0; i < ticks; ++i) {
    if (server && server->serve()) publication::Publication::stepped(publication.get(), *session.global);
    mode == "untimed" ? haptic_tick<loop::VirtualClock>(session) : haptic_tick<CountingClock>(session);
    session.count_tick();
    session.drain->drain();
  }
  std::printf("%016llx\n", static_cast<unsigned long long>(session.loop->state_hash()));
  return Status::good();
}

}  // namespace tactus::bench

int main(int argc, char** argv) {
  if (argc != 5) {
    std::fputs("usage: bench_watched_tick SCENE sub-world|direct untimed|alone|watched TICKS\n", stderr);
    return 2;
  }
  const tactus::Status status = tactus::bench::run(argv[1], argv[2], argv[3], std::atoi(argv[4]));
  if (!status.ok()) std::fprintf(stderr, "bench_watched_tick: %s\n", status.message().c_str());
  return status.ok() ? 0 : 2;
}
