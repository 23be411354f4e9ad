#include "sim/worker_pool.h"

#include "rt/base/check.h"
#include "rt/base/denormals.h"
#include "sim/thread_placement.h"

namespace tactus::sim {
namespace {

// About a tenth of a millisecond: longer than most serial parts of a step, and short after the end of a step.
constexpr int kSpins = 2000;

// Executes the CPU's hint for a spin-wait loop.
void pause() noexcept {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#else
  asm volatile("yield");
#endif
}

}  // namespace

WorkerPool::WorkerPool(std::uint32_t threads, std::span<const int> cpus) : workers_(threads > 1 ? threads - 1 : 0) {
  TACTUS_CHECK(threads <= kMaxWorldThreads, threads, kMaxWorldThreads);
  for (std::size_t i = 0; i < workers_.size(); ++i) {
    Worker& worker = workers_[i];
    worker.thread = std::thread([this, &worker] { run(worker); });
    for (const Status& status : {make_normal(worker.thread), pin(worker.thread, i < cpus.size() ? cpus[i] : -1)})
      if (!status.ok() && status_.ok()) status_ = status;
  }
}

WorkerPool::~WorkerPool() {
  for (Worker& worker : workers_) {
    worker.state.store(kStop, std::memory_order_release);
    worker.state.notify_one();
    worker.thread.join();
  }
}

physics::Executor WorkerPool::executor() noexcept {
  return workers_.empty() ? physics::Executor{} : physics::Executor{&WorkerPool::share, this};
}

void WorkerPool::share(void* self, std::uint32_t count, std::uint32_t grain, physics::Executor::Work work,
                       void* context) noexcept {
  TACTUS_CHECK(denormals_flushed(), count, grain);  // as in the workers: results must not depend on the thread
  auto& pool = *static_cast<WorkerPool*>(self);
  const std::uint32_t ranges = std::min(pool.threads(), count / grain);
  const auto start = [&](std::uint64_t k) { return static_cast<std::uint32_t>(k * count / ranges); };
  pool.work_ = work;
  pool.context_ = context;
  for (std::uint32_t k = 1; k < ranges; ++k) {
    Worker& worker = pool.workers_[k - 1];
    worker.begin = start(k);
    worker.end = start(k + 1);
    worker.state.store(kOpen, std::memory_order_release);
    worker.state.notify_one();
  }
  work(context, 0, start(1));
  // From the last worker back: the first worker was notified first.
  for (std::uint32_t k = ranges; k-- > 1;) {
    Worker& worker = pool.workers_[k - 1];
    std::uint32_t open = kOpen;
    if (!worker.state.compare_exchange_strong(open, kTaken, std::memory_order_relaxed)) continue;
    work(context, worker.begin, worker.end);
    worker.state.store(kIdle, std::memory_order_relaxed);
  }
  for (std::uint32_t k = 1; k < ranges; ++k)
    for (int spins = 0; pool.workers_[k - 1].state.load(std::memory_order_acquire) != kIdle; ++spins)
      spins < kSpins ? pause() : std::this_thread::yield();
}

void WorkerPool::run(Worker& worker) noexcept {
  set_denormals_flush();
  for (int spins = 0;;) {
    std::uint32_t state = worker.state.load(std::memory_order_relaxed);
    if (state == kStop) return;
    // Meanwhile the caller may have taken this range and opened the next: acquire makes the range that is open now
    // visible.
    if (state == kOpen && worker.state.compare_exchange_strong(state, kTaken, std::memory_order_acquire)) {
      work_(context_, worker.begin, worker.end);
      worker.state.store(kIdle, std::memory_order_release);
      spins = 0;
    } else if (++spins < kSpins) {
      pause();
    } else {
      worker.state.wait(state, std::memory_order_relaxed);
    }
  }
}

}  // namespace tactus::sim
