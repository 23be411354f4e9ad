// Threads beside the global world's own that share the work of its steps: the executor behind --world-threads.
//
// Work is cut into as many ranges as there are threads, always the same for the same count, so that what a thread works
// on stays in its core's caches. Each worker waits for its own range: it spins a while, since the next one comes within
// microseconds during a step, and then sleeps until it is woken. Where it has not begun when the caller is done with
// its own range, the caller takes the worker's too: a thread that does not get a core delays nothing but what it began.
// Thread: construction and destruction [setup]; the executor by one thread at a time, of normal priority. Bound: as
// many ranges as threads. Errors: construction reports what a worker could not be given; it works without it.
#pragma once

#include <atomic>
#include <span>
#include <thread>
#include <vector>

#include "rt/base/result.h"
#include "rt/physics/executor.h"

namespace tactus::sim {

inline constexpr std::uint32_t kMaxWorldThreads = 64;

class WorkerPool {
 public:
  // `threads`: the caller's included, so one worker less. `cpus`: a core for each worker, or none.
  explicit WorkerPool(std::uint32_t threads, std::span<const int> cpus = {});
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  std::uint32_t threads() const noexcept { return static_cast<std::uint32_t>(workers_.size()) + 1; }
  const Status& status() const noexcept { return status_; }  // what a worker could not be given
  physics::Executor executor() noexcept;                     // shares nothing where there is no worker

 private:
  enum State : std::uint32_t { kIdle, kOpen, kTaken, kStop };
  struct alignas(64) Worker {
    std::atomic<std::uint32_t> state{kIdle};
    std::uint32_t begin{0}, end{0};
    std::thread thread;
  };

  static void share(void* self, std::uint32_t count, std::uint32_t grain, physics::Executor::Work work,
                    void* context) noexcept;
  void run(Worker& worker) noexcept;

  std::vector<Worker> workers_;
  physics::Executor::Work work_{nullptr};  // of the ranges that are open or taken
  void* context_{nullptr};
  Status status_{Status::good()};
};

}  // namespace tactus::sim
