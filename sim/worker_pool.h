// Worker threads that share the work of the global world's steps: the executor behind --world-threads.
//
// Work is divided into as many ranges as there are threads, always in the same way for the same count, so that a
// thread's data stays in its core's caches. Each worker waits for its own range: it spins for a while, since the next
// range comes within microseconds during a step, and then sleeps until it is woken. If a worker has not started its
// range when the caller has finished its own, the caller runs that range too: a thread without a core delays only a
// range that it has started.
// Thread: construction and destruction [setup]; the executor by one thread at a time, of normal priority. Bound: as
// many ranges as threads. Errors: status() has what could not be set for a worker; it runs without it.
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
  // `threads`: includes the caller, so threads - 1 workers. `cpus`: a core for each worker; a worker beyond its end
  // runs on any.
  explicit WorkerPool(std::uint32_t threads, std::span<const int> cpus = {});
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  std::uint32_t threads() const noexcept { return static_cast<std::uint32_t>(workers_.size()) + 1; }
  const Status& status() const noexcept { return status_; }  // the first error of a worker's set-up
  physics::Executor executor() noexcept;                     // without workers, the caller does all the work

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
  physics::Executor::Work work_{nullptr};  // for the ranges that are open or taken
  void* context_{nullptr};
  Status status_{Status::good()};
};

}  // namespace tactus::sim
