#include "sim/global_thread.h"

#include "rt/base/clock.h"
#include "rt/base/denormals.h"
#include "sim/thread_placement.h"

namespace tactus::sim {
namespace {

// A stall sleeps in intervals of at most this, so that stop() need not wait for its end.
constexpr std::chrono::nanoseconds kLongestSleep{5'000'000};

}  // namespace

GlobalThread::GlobalThread(GlobalWorld& world, haptics::Exchange& exchange, GlobalThreadOptions options)
    : GlobalThread(world, std::vector{&exchange}, std::move(options)) {}

GlobalThread::GlobalThread(GlobalWorld& world, std::vector<haptics::Exchange*> exchanges, GlobalThreadOptions options)
    : world_(world), server_(world, std::move(exchanges)), options_(std::move(options)) {}

GlobalThread::~GlobalThread() { stop(); }

Status GlobalThread::start() {
  TACTUS_CHECK(!thread_.joinable(), 0, 0);
  server_.publish_first();
  thread_ = std::thread([this] { run(); });
  const Status normal = make_normal(thread_);
  const Status pinned = pin(thread_, options_.cpu);
  return normal.ok() ? pinned : normal;
}

void GlobalThread::stop() noexcept {
  stop_.store(true, std::memory_order_relaxed);
  if (thread_.joinable()) thread_.join();
}

GlobalThread::Progress GlobalThread::progress() const noexcept {
  return {cycles_.load(std::memory_order_relaxed), last_step_ns_.load(std::memory_order_relaxed),
          longest_step_ns_.load(std::memory_order_relaxed)};
}

void GlobalThread::run() noexcept {
  set_denormals_flush();
  while (!stop_.load(std::memory_order_relaxed)) {
    if (!server_.has_report()) {
      wait_for_reports();
      continue;
    }
    waiting_since_ns_ = 0;
    stall_before(server_.next_report());
    const std::int64_t begin_ns = MonotonicClock::now_ns();
    (void)server_.serve();
    const std::int64_t time_ns = MonotonicClock::now_ns() - begin_ns;
    step_times_.record(time_ns);
    last_step_ns_.store(time_ns, std::memory_order_relaxed);
    longest_step_ns_.store(std::max(time_ns, longest_step_ns_.load(std::memory_order_relaxed)),
                           std::memory_order_relaxed);
    cycles_.fetch_add(1, std::memory_order_relaxed);
    tell();
  }
}

void GlobalThread::wait_for_reports() noexcept {
  const std::int64_t now_ns = MonotonicClock::now_ns();
  if (!server_.is_waited_for())
    waiting_since_ns_ = 0;
  else if (waiting_since_ns_ == 0)
    waiting_since_ns_ = now_ns;
  else if (static_cast<double>(now_ns - waiting_since_ns_) > 1e9 * kPatienceSteps * world_.step_s())
    server_.leave_out_the_missing();
  sleep(options_.poll_period);
}

void GlobalThread::tell() const noexcept {
  if (options_.stepped.stepped != nullptr) options_.stepped.stepped(options_.stepped.context, world_);
}

void GlobalThread::stall_before(std::uint64_t report) noexcept {
  for (const Stall& stall : options_.stalls) {
    if (stall.at_report != report) continue;
    auto left = stall.duration;
    while (left.count() > 0 && !stop_.load(std::memory_order_relaxed)) {
      sleep(std::min(left, kLongestSleep));
      left -= kLongestSleep;
    }
  }
}

void GlobalThread::sleep(std::chrono::nanoseconds duration) const noexcept {
  MonotonicClock::sleep_until_ns(MonotonicClock::now_ns() + duration.count());
}

}  // namespace tactus::sim
