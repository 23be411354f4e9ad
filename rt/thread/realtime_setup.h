// Makes the calling thread a real-time thread, and says of every privilege whether it was really granted.
//
// Nothing here fails silently and nothing stops the run: a refused call is a line with its cure, and the report as a
// whole is `degraded`. Thread: [setup], each call on the thread that it is for; the report is a value that any thread
// may keep. Bound: kMaxSetupSteps lines of kSetupMessageBytes; longer texts are cut.
// Source: sched(7), mlockall(2), capabilities(7), Linux Documentation/power/pm_qos_interface.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <type_traits>
#include <utility>

#include "rt/base/bounded_vector.h"
#include "rt/base/denormals.h"

namespace tactus::loop {

inline constexpr std::uint32_t kMaxSetupSteps = 12;
inline constexpr std::size_t kSetupMessageBytes = 240;

struct SetupRequest {
  int cpu{-1};                      // core to stay on; -1: do not pin
  int priority{80};                 // SCHED_FIFO 1..99; 0: stay a normal thread
  bool lock_memory{true};           // all pages of the process, present and future
  bool hold_cpu_awake{true};        // /dev/cpu_dma_latency held at 0 µs while the CpuAwake lives
  std::uint32_t stack_KiB{128};     // stack to touch below the caller
  std::uint32_t timer_slack_ns{1};  // matters without SCHED_FIFO only; the kernel's default is 50 000
};

struct SetupStep {
  const char* name{""};  // one word, literal
  bool ok{true};
  bool privilege{false};  // without it the loop cannot keep its deadlines: counts for degraded()
  std::array<char, kSetupMessageBytes> text{};

  std::string_view message() const noexcept { return text.data(); }  // what is so, or what failed and the cure
};

struct SetupReport {
  FixedVector<SetupStep, kMaxSetupSteps> steps;
  bool preempt_rt{false};  // the kernel is a PREEMPT_RT one

  // A real-time privilege is missing: refused, or not even asked for. (A core of its own need not be asked for.)
  bool degraded() const noexcept;
  // A step failed, privilege or not: the kernel is not a real-time one, for example.
  bool failed() const noexcept;
  // The step of that name, or null.
  const SetupStep* find(std::string_view name) const noexcept;
};

// Holds the request that no CPU sleeps deeper than C0/C1: dropped by the kernel when the file is closed.
class CpuAwake {
 public:
  CpuAwake() = default;
  ~CpuAwake() { release(); }
  CpuAwake(CpuAwake&& other) noexcept : file_(std::exchange(other.file_, -1)) {}
  CpuAwake& operator=(CpuAwake&& other) noexcept {
    if (this != &other) release(), file_ = std::exchange(other.file_, -1);
    return *this;
  }

  // 0, or the errno that says why not.
  int hold() noexcept;
  void release() noexcept;
  bool held() const noexcept { return file_ >= 0; }

 private:
  int file_{-1};
};

// Steps, in order: kernel, cpu, memory, heap, stack, cpu-latency, timer-slack, denormals, priority (last: what comes
// before may take its time).
SetupReport setup_realtime(const SetupRequest& request, CpuAwake& awake) noexcept;

// The calling thread may do what `capability` allows (CAP_... of linux/capability.h): its effective set has it.
bool has_capability(unsigned capability) noexcept;

// True on a PREEMPT_RT kernel.
bool kernel_is_preempt_rt() noexcept;

static_assert(std::is_trivially_copyable_v<SetupReport>);

}  // namespace tactus::loop
