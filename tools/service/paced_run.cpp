#include "tools/service/paced_run.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>

#include "rt/base/clock.h"
#include "rt/base/denormals.h"

namespace tactus::service {
namespace {

constexpr std::chrono::milliseconds kPause{4};
constexpr std::uint64_t kBatch = 50;            // ticks between two looks
constexpr std::int64_t kLook_ns = 200'000'000;  // between two calls of `look`
constexpr double kMaxOwed_s = 0.1;              // of simulated time: a run that cannot keep its pace does not burst
constexpr auto relaxed = std::memory_order_relaxed;

class PacedRun {
 public:
  PacedRun(session::Session& session, session::VirtualRun& run, const PacedHooks& hooks, std::uint64_t ticks)
      : session_(session), run_(run), hooks_(hooks), left_(ticks == 0 ? ~std::uint64_t{0} : ticks) {}

  void run() {
    began_ns_ = last_ns_ = MonotonicClock::now_ns();
    while (left_ > 0 && !hooks_.stop.load(relaxed)) {
      const std::uint64_t done = run_some();
      if (session_.drain != nullptr) session_.drain->drain();
      look();
      if (done > 0) continue;
      show();
      std::this_thread::sleep_for(kPause);
    }
  }

 private:
  // Ticks that are due now, at most a batch.
  std::uint64_t run_some() {
    const std::int64_t now_ns = MonotonicClock::now_ns();
    const double passed_s = 1e-9 * static_cast<double>(now_ns - last_ns_);
    last_ns_ = now_ns;
    if (!hooks_.pacing.playing.load(relaxed)) {
      owed_s_ = 0;
      return run_single();
    }
    const double pace = hooks_.pacing.pace.load(relaxed), period_s = session_.options.period_s();
    owed_s_ = std::min(owed_s_ + pace * passed_s, std::max(kMaxOwed_s, period_s));
    const auto due = pace == 0 ? kBatch : static_cast<std::uint64_t>(owed_s_ / period_s);
    const std::uint64_t now = std::min({due, kBatch, left_});
    owed_s_ = std::max(0.0, owed_s_ - static_cast<double>(now) * period_s);
    for (std::uint64_t i = 0; i < now; ++i) tick();
    return now;
  }

  // One tick, or one cycle, of those that were asked for.
  std::uint64_t run_single() {
    const auto take = [](std::atomic<std::uint32_t>& asked) {
      const std::uint32_t before = asked.load(relaxed);
      if (before > 0) asked.fetch_sub(1, relaxed);
      return before > 0;
    };
    if (take(hooks_.pacing.ticks)) {
      tick();
      return 1;
    }
    if (!take(hooks_.pacing.cycles)) return 0;
    std::uint64_t done = 0;
    constexpr std::uint64_t kLongestCycle = 10'000;  // of a world that has stalled
    do {
      tick();
      ++done;
    } while (!session_.driver->synchronised() && session_.global != nullptr && done < kLongestCycle && left_ > 0);
    return done;
  }

  void tick() {
    out_ = run_.tick(hooks_.requests.exchange(0, relaxed));
    --left_;
    if (session_.driver->synchronised()) show();
  }

  void show() {
    if (hooks_.stepped != nullptr && session_.global != nullptr) hooks_.stepped(hooks_.context, *session_.global);
  }

  void look() {
    const std::int64_t now_ns = MonotonicClock::now_ns();
    if (now_ns < next_look_ns_ || !hooks_.look) return;
    next_look_ns_ = now_ns + kLook_ns;
    live_.show(session_, out_);
    hooks_.look(live_, 1e-9 * static_cast<double>(now_ns - began_ns_));
  }

  session::Session& session_;
  session::VirtualRun& run_;
  const PacedHooks& hooks_;
  std::uint64_t left_;
  loop::TickOutput out_;
  session::LiveStatus live_;
  double owed_s_{0};
  std::int64_t began_ns_{0}, last_ns_{0}, next_look_ns_{0};
};

}  // namespace

Result<session::RunSummary> run_paced(session::Session& session, session::VirtualRun& run, const PacedHooks& hooks,
                                      std::uint64_t ticks) {
  set_denormals_flush();
  if (Status status = session::VirtualRun::check(session); !status.ok()) return status;
  PacedRun(session, run, hooks, ticks).run();
  session::RunSummary summary = session.summary();
  session.close_tape(summary);
  return summary;
}

}  // namespace tactus::service
