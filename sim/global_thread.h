// The thread of the global world: normal priority, on its own core if configured. It polls for reports.
//
// It sleeps between polls, so that the haptic thread need not wake it. With several devices a step starts when all
// reports have arrived, at the latest kPatienceSteps step lengths after the first: if a haptic thread stops, the world
// continues for the other devices. Thread: start and stop by one normal thread; progress() by any. Units: ns, as named.
// Bound: a report is read at most one poll period (and the scheduler's delay) after it was published. Errors: start()
// returns what could not be set; the thread then runs without it.
#pragma once

#include <atomic>
#include <chrono>
#include <thread>
#include <vector>

#include "rt/base/histogram.h"
#include "sim/snapshot_server.h"

namespace tactus::sim {

// For tests and fault injection: delays the world once by `duration`, before it serves this report.
struct Stall {
  std::uint64_t at_report{0};
  std::chrono::nanoseconds duration{0};
};

// Called after each step, on the global world's thread, which waits for it. Null: none.
struct StepObserver {
  void (*stepped)(void* context, const GlobalWorld& world) noexcept {nullptr};
  void* context{nullptr};
};

struct GlobalThreadOptions {
  int cpu{-1};  // CPU to run on; -1: any
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

  // Longest time that a device with a report waits for the reports of the others, in lengths of a global step. Then the
  // world continues without the missing ones.
  static constexpr double kPatienceSteps = 2;

  GlobalThread(GlobalWorld& world, haptics::Exchange& exchange, GlobalThreadOptions options);
  // One exchange for each of the world's devices, in their order.
  GlobalThread(GlobalWorld& world, std::vector<haptics::Exchange*> exchanges, GlobalThreadOptions options);
  ~GlobalThread();
  GlobalThread(const GlobalThread&) = delete;
  GlobalThread& operator=(const GlobalThread&) = delete;

  // Publishes G(0), then starts the thread. Error: the thread runs, but without the requested CPU or priority.
  Status start();
  // Returns when the current step is done. The caller may then use the world and step_times().
  void stop() noexcept;

  Progress progress() const noexcept;
  // After stop(): ns from reading the report to publishing the snapshot, one entry per cycle, without stalls.
  const Histogram& step_times() const noexcept { return step_times_; }

 private:
  void run() noexcept;
  void wait_for_reports() noexcept;
  void tell() const noexcept;
  void stall_before(std::uint64_t report) noexcept;
  void sleep(std::chrono::nanoseconds duration) const noexcept;

  const GlobalWorld& world_;
  SnapshotServer server_;
  GlobalThreadOptions options_;
  Histogram step_times_;
  std::int64_t waiting_since_ns_{0};  // when a device began to wait for the others' reports; 0: none waits
  std::atomic<std::uint64_t> cycles_{0};
  std::atomic<std::int64_t> last_step_ns_{0}, longest_step_ns_{0};
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace tactus::sim
