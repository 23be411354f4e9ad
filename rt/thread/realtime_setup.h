// Makes the calling thread a real-time thread and reports for every privilege whether it was granted.
//
// No step fails silently and none stops the run: a refused call adds a line with its remedy, and the report as a whole
// is `degraded`. Thread: [setup], each call on the thread that it configures; the report is a value that any thread may
// keep. Bound: kMaxSetupSteps lines of kSetupMessageBytes; longer texts are truncated.
// Source: sched(7), mlockall(2), capabilities(7), Linux Documentation/power/pm_qos_interface.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "rt/base/bounded_vector.h"
#include "rt/base/denormals.h"

namespace tactus::loop {

inline constexpr std::uint32_t kMaxSetupSteps = 12;
inline constexpr std::size_t kSetupMessageBytes = 240;

struct SetupRequest {
  int cpu{-1};                      // core to pin the thread to; -1: do not pin
  int priority{80};                 // SCHED_FIFO 1..99; 0: not a real-time thread
  bool lock_memory{true};           // all pages of the process, present and future
  bool hold_cpu_awake{true};        // /dev/cpu_dma_latency held at 0 µs while the CpuAwake lives
  std::uint32_t stack_KiB{128};     // stack to touch below the caller
  std::uint32_t timer_slack_ns{1};  // only used without SCHED_FIFO; the kernel's default is 50 000
};

struct SetupStep {
  const char* name{""};  // one word, literal
  bool ok{true};
  bool privilege{false};  // needed to meet deadlines: counts for degraded()
  std::array<char, kSetupMessageBytes> text{};

  std::string_view message() const noexcept { return text.data(); }  // the result, or the failure and its remedy
};

struct SetupReport {
  FixedVector<SetupStep, kMaxSetupSteps> steps;
  bool preempt_rt{false};  // the kernel is PREEMPT_RT

  // A real-time privilege is missing: refused or not requested. (A core of its own need not be requested.)
  bool degraded() const noexcept;
  // A step failed, privilege or not; for example, the kernel is not a real-time kernel.
  bool failed() const noexcept;
  // The step of that name, or null.
  const SetupStep* find(std::string_view name) const noexcept;
};

// Keeps the request that no CPU sleeps deeper than C0/C1; the kernel drops it when the file is closed.
class CpuAwake {
 public:
  CpuAwake() = default;
  ~CpuAwake() { release(); }
  CpuAwake(CpuAwake&& other) noexcept : file_(std::exchange(other.file_, -1)) {}
  CpuAwake& operator=(CpuAwake&& other) noexcept {
    if (this != &other) {
      release();
      file_ = std::exchange(other.file_, -1);
    }
    return *this;
  }

  // Returns 0 or the errno of the failure.
  int hold() noexcept;
  void release() noexcept;
  bool held() const noexcept { return file_ >= 0; }

 private:
  int file_{-1};
};

// Performs the steps in this order: kernel, cpu, memory, heap, stack, cpu-latency, timer-slack, denormals, priority
// (last, because the others may be slow).
SetupReport setup_realtime(const SetupRequest& request, CpuAwake& awake) noexcept;

// True if the calling thread's effective set contains `capability` (CAP_... of linux/capability.h).
bool has_capability(unsigned capability) noexcept;

bool kernel_is_preempt_rt() noexcept;

// Cores on which the scheduler may put this process, ascending; empty: unknown. [setup]; allocates.
std::vector<int> allowed_cpus();

// True if the calling thread could stay on this core: it is online and in the cpuset. A core isolated at boot is not
// among allowed_cpus(), and may be one. The thread's own cores are the same afterwards. [setup]
bool may_stay_on(int cpu) noexcept;

static_assert(std::is_trivially_copyable_v<SetupReport>);

}  // namespace tactus::loop
