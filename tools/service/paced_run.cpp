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

// `Run`: what a tick is: of one hand, or of several.
template <class Run>
class PacedRun {
 public:
  PacedRun(Run& run, Pacing& pacing, const std::atomic<bool>& stop, std::uint64_t ticks)
      : run_(run), pacing_(pacing), stop_(stop), left_(ticks == 0 ? ~std::uint64_t{0} : ticks) {}

  void run() {
    began_ns_ = last_ns_ = MonotonicClock::now_ns();
    while (left_ > 0 && !stop_.load(relaxed)) {
      const std::uint64_t done = run_some();
      run_.drain();
      look();
      if (done > 0) continue;
      run_.show();
      std::this_thread::sleep_for(kPause);
    }
  }

 private:
  static constexpr auto relaxed = std::memory_order_relaxed;

  // Ticks that are due now, at most a batch.
  std::uint64_t run_some() {
    const std::int64_t now_ns = MonotonicClock::now_ns();
    const double passed_s = 1e-9 * static_cast<double>(now_ns - last_ns_);
    last_ns_ = now_ns;
    if (!pacing_.playing.load(relaxed)) {
      owed_s_ = 0;
      return run_single();
    }
    const double pace = pacing_.pace.load(relaxed), period_s = run_.period_s();
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
    if (take(pacing_.ticks)) {
      tick();
      return 1;
    }
    if (!take(pacing_.cycles)) return 0;
    std::uint64_t done = 0;
    constexpr std::uint64_t kLongestCycle = 10'000;  // of a world that has stalled
    do {
      tick();
      ++done;
    } while (!run_.synchronised() && done < kLongestCycle && left_ > 0);
    return done;
  }

  void tick() {
    run_.tick();
    --left_;
    if (run_.synchronised()) run_.show();
  }

  void look() {
    const std::int64_t now_ns = MonotonicClock::now_ns();
    if (now_ns < next_look_ns_) return;
    next_look_ns_ = now_ns + kLook_ns;
    run_.look(1e-9 * static_cast<double>(now_ns - began_ns_));
  }

  Run& run_;
  Pacing& pacing_;
  const std::atomic<bool>& stop_;
  std::uint64_t left_;
  double owed_s_{0};
  std::int64_t began_ns_{0}, last_ns_{0}, next_look_ns_{0};
};

class OneHand {
 public:
  OneHand(session::Session& session, session::VirtualRun& run, const PacedHooks& hooks)
      : session_(session), run_(run), hooks_(hooks) {}

  double period_s() const noexcept { return session_.options.period_s(); }
  void tick() { out_ = run_.tick(hooks_.requests.exchange(0, std::memory_order_relaxed)); }
  // The direct coupling has no cycle: each tick is one.
  bool synchronised() const noexcept { return session_.global == nullptr || session_.driver->synchronised(); }
  void drain() {
    if (session_.drain != nullptr) session_.drain->drain();
  }
  void show() {
    if (hooks_.stepped != nullptr && session_.global != nullptr) hooks_.stepped(hooks_.context, *session_.global);
  }
  void look(double elapsed_s) {
    if (!hooks_.look) return;
    live_.show(session_, out_);
    hooks_.look(live_, elapsed_s);
  }

 private:
  session::Session& session_;
  session::VirtualRun& run_;
  const PacedHooks& hooks_;
  loop::TickOutput out_;
  session::LiveStatus live_;
};

class AllHands {
 public:
  AllHands(session::Hands& hands, const PacedHandsHooks& hooks)
      : hands_(hands), hooks_(hooks), run_(hands), asked_(hands.count(), 0), live_(hands.count()) {
    for (session::LiveStatus& live : live_) shown_.push_back(&live);
  }

  double period_s() const noexcept { return hands_[0].options.period_s(); }
  void tick() {
    for (std::size_t hand = 0; hand < asked_.size(); ++hand)
      asked_[hand] = hooks_.requests[hand]->exchange(0, std::memory_order_relaxed);
    run_.tick(asked_);
  }
  bool synchronised() const noexcept { return hands_[0].driver->synchronised(); }
  void drain() {
    for (unsigned hand = 0; hand < hands_.count(); ++hand)
      if (hands_[hand].drain != nullptr) hands_[hand].drain->drain();
  }
  void show() {
    if (hooks_.stepped.stepped != nullptr) hooks_.stepped.stepped(hooks_.stepped.context, hands_.world());
  }
  void look(double elapsed_s) {
    if (!hooks_.look) return;
    for (unsigned hand = 0; hand < hands_.count(); ++hand)
      live_[hand].show(hands_[hand], hands_[hand].driver->output());
    hooks_.look(shown_, elapsed_s);
  }

 private:
  session::Hands& hands_;
  const PacedHandsHooks& hooks_;
  session::VirtualRun run_;
  std::vector<std::uint32_t> asked_;
  std::vector<session::LiveStatus> live_;
  std::vector<const session::LiveStatus*> shown_;
};

}  // namespace

Result<session::RunSummary> run_paced(session::Session& session, session::VirtualRun& run, const PacedHooks& hooks,
                                      std::uint64_t ticks) {
  set_denormals_flush();
  if (Status status = session::VirtualRun::check(session); !status.ok()) return status;
  OneHand hand(session, run, hooks);
  PacedRun(hand, hooks.pacing, hooks.stop, ticks).run();
  session::RunSummary summary = session.summary();
  session.close_tape(summary);
  return summary;
}

Result<std::vector<session::RunSummary>> run_paced(session::Hands& hands, const PacedHandsHooks& hooks,
                                                   std::uint64_t ticks) {
  set_denormals_flush();
  if (Status status = session::VirtualRun::check(hands[0]); !status.ok()) return status;
  AllHands all(hands, hooks);
  PacedRun(all, hooks.pacing, hooks.stop, ticks).run();
  std::vector<session::RunSummary> summaries;
  for (unsigned hand = 0; hand < hands.count(); ++hand) {
    summaries.push_back(hands[hand].summary());
    hands[hand].close_tape(summaries.back());
  }
  return summaries;
}

}  // namespace tactus::service
