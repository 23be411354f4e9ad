// The thread of the global world: normal priority, its own core if asked, polling for reports.
//
// It sleeps between looks: the haptic thread wakes nobody. Thread: start and stop by one normal thread; progress() by
// any. Units: ns, as named. Bound: a report is seen at most one poll period (and the scheduler's own delay) after it
// was published. Errors: start says what could not be set; the thread then runs without it.
#pragma once

#include <atomic>
#include <chrono>
#include <thread>
#include <vector>

#include "rt/base/histogram.h"
#include "sim/snapshot_server.h"

namespace tactus::sim {

// For tests and fault injection: the world is late by this much, once, before it serves this report.
struct Stall {
  std::uint64_t at_report{0};
  std::chrono::nanoseconds duration{0};
};

// Told of each step, by the thread, which waits for it. A function and its context; the default is nobody.
struct StepObserver {
  void (*stepped)(void* context, const GlobalWorld& world) noexcept {nullptr};
  void* context{nullptr};
};

struct GlobalThreadOptions {
  int cpu{-1};  // to run on; -1: wherever
  std::chrono::nanoseconds poll_period{50'000};
  std::vector<Stall> stalls;
  StepObserver stepped{};
};

class GlobalThread {
 public:
  struct Progress {
    std::uint64_t cycles{0};
    std::int64_t last_step_ns{0}, longest_step_ns{0};
  };

  GlobalThread(GlobalWorld& world, haptics::Exchange& exchange, GlobalThreadOptions options);
  ~GlobalThread();
  GlobalThread(const GlobalThread&) = delete;
  GlobalThread& operator=(const GlobalThread&) = delete;

  // Publishes G(0), then starts. Not ok: running, but not where or as it was asked to.
  Status start();
  // Returns when the step under way is done. The world and step_times() are the caller's again.
  void stop() noexcept;

  Progress progress() const noexcept;
  // After stop: from the report to the snapshot, one entry a cycle; stalls not counted.
  const Histogram& step_times() const noexcept { return step_times_; }

 private:
  void run() noexcept;
  void tell() const noexcept;
  void stall_before(std::uint64_t report) noexcept;
  void sleep(std::chrono::nanoseconds duration) const noexcept;

  const GlobalWorld& world_;
  SnapshotServer server_;
  GlobalThreadOptions options_;
  Histogram step_times_;
  std::atomic<std::uint64_t> cycles_{0};
  std::atomic<std::int64_t> last_step_ns_{0}, longest_step_ns_{0};
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace tactus::sim
