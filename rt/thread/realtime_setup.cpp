#include "rt/thread/realtime_setup.h"

#include <fcntl.h>
#include <linux/capability.h>
#include <malloc.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <cerrno>
#include <cstdarg>
#include <cstdio>
#include <cstring>

namespace tactus::loop {
namespace {

[[gnu::format(printf, 5, 6)]] void add_step(SetupReport& report, const char* name, bool privilege, bool ok,
                                            const char* format, ...) noexcept {
  SetupStep step;
  step.name = name;
  step.privilege = privilege;
  step.ok = ok;
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(step.text.data(), step.text.size(), format, arguments);
  va_end(arguments);
  const bool added = report.steps.try_push(step);
  TACTUS_CHECK(added, report.steps.size(), kMaxSetupSteps);
}

void report_kernel(SetupReport& report) noexcept {
  utsname kernel{};
  uname(&kernel);
  report.preempt_rt = kernel_is_preempt_rt();
  add_step(report, "kernel", false, report.preempt_rt,
           report.preempt_rt ? "%.60s is a PREEMPT_RT kernel"
                             : "%.60s is not a PREEMPT_RT kernel: wake-ups are late now and then; boot a real-time one",
           kernel.release);
}

void pin_to_cpu(const SetupRequest& request, SetupReport& report) noexcept {
  if (request.cpu < 0) return add_step(report, "cpu", true, true, "not asked for: runs on any core");
  const long count = sysconf(_SC_NPROCESSORS_CONF);
  if (request.cpu >= CPU_SETSIZE || request.cpu >= count) {
    return add_step(report, "cpu", true, false, "there is no cpu %d: cpus here are 0 to %ld", request.cpu, count - 1);
  }
  cpu_set_t set;
  CPU_ZERO(&set);
  CPU_SET(static_cast<unsigned>(request.cpu), &set);
  if (sched_setaffinity(0, sizeof set, &set) != 0) {
    return add_step(report, "cpu", true, false,
                    "cannot stay on cpu %d (%s): bring it online, or take it into the cpuset", request.cpu,
                    strerrordesc_np(errno));
  }
  add_step(report, "cpu", true, true, "stays on cpu %d", request.cpu);
}

// With a finite limit and without the capability, locking future pages would make some later allocation of any thread
// fail, which is worse than not locking. Then only the present pages are locked, if they fit, and the step counts as
// failed.
void lock_memory(const SetupRequest& request, SetupReport& report) noexcept {
  if (!request.lock_memory) return add_step(report, "memory", true, false, "not asked for: pages may be taken away");
  rlimit limit{};
  getrlimit(RLIMIT_MEMLOCK, &limit);
  if (limit.rlim_cur < limit.rlim_max) {
    limit.rlim_cur = limit.rlim_max;
    setrlimit(RLIMIT_MEMLOCK, &limit);
    getrlimit(RLIMIT_MEMLOCK, &limit);
  }
  if (limit.rlim_cur != RLIM_INFINITY && !has_capability(CAP_IPC_LOCK)) {
    const bool present = mlockall(MCL_CURRENT) == 0;
    return add_step(report, "memory", true, false,
                    "%s locked: the limit is %llu KiB; set 'memlock unlimited' for this user in "
                    "/etc/security/limits.d, or give CAP_IPC_LOCK",
                    present ? "only the present pages are" : "nothing is",
                    static_cast<unsigned long long>(limit.rlim_cur / 1024));
  }
  if (mlockall(MCL_CURRENT | MCL_FUTURE) != 0) {
    return add_step(report, "memory", true, false, "mlockall: %s; free memory, or raise the control group's limit",
                    strerrordesc_np(errno));
  }
  add_step(report, "memory", true, true, "all pages are locked, future ones too");
}

// Memory that another thread returns to the kernel interrupts this thread (TLB shootdown on its core). So the heap
// returns nothing and uses no separate mappings for large blocks.
void keep_heap(SetupReport& report) noexcept {
  const bool kept = mallopt(M_TRIM_THRESHOLD, -1) == 1 && mallopt(M_MMAP_MAX, 0) == 1;
  add_step(report, "heap", false, kept,
           kept ? "keeps its pages" : "this allocator gives pages back at will: the loop may be interrupted for it");
}

// noinline: the block lies below every frame that the loop will use and is released before it runs.
[[gnu::noinline]] void touch_below(std::size_t bytes) noexcept {
  auto* block = static_cast<volatile char*>(__builtin_alloca(bytes));
  for (std::size_t i = 0; i < bytes; i += 1024) block[bytes - 1 - i] = 0;  // downwards, as a stack grows
}

std::size_t stack_left() noexcept {
  pthread_attr_t attributes;
  if (pthread_getattr_np(pthread_self(), &attributes) != 0) return 0;
  void* lowest = nullptr;
  std::size_t size = 0;
  pthread_attr_getstack(&attributes, &lowest, &size);
  pthread_attr_destroy(&attributes);
  const auto here = reinterpret_cast<std::uintptr_t>(__builtin_frame_address(0));
  const auto low = reinterpret_cast<std::uintptr_t>(lowest);
  return here > low ? here - low : 0;
}

void touch_stack(const SetupRequest& request, SetupReport& report) noexcept {
  constexpr std::size_t kMargin = 16 * 1024;  // for the frames of this call and of a signal handler
  const std::size_t wanted = std::size_t{request.stack_KiB} * 1024, left = stack_left();
  const std::size_t usable = left > kMargin ? left - kMargin : 0;
  const bool enough = wanted <= usable;
  if (const std::size_t bytes = enough ? wanted : usable; bytes > 0) touch_below(bytes);
  if (enough) return add_step(report, "stack", false, true, "%u KiB touched", request.stack_KiB);
  add_step(report, "stack", false, false, "%u KiB asked for, %zu KiB there: start the thread with a larger stack",
           request.stack_KiB, usable / 1024);
}

void hold_cpu_awake(const SetupRequest& request, CpuAwake& awake, SetupReport& report) noexcept {
  if (!request.hold_cpu_awake) return add_step(report, "cpu-latency", true, false, "not asked for: cores may sleep");
  const int error = awake.hold();
  if (error == 0) return add_step(report, "cpu-latency", true, true, "cores are kept awake (0 us)");
  add_step(report, "cpu-latency", true, false,
           "/dev/cpu_dma_latency: %s; make it writable for this user by a udev rule, or boot with "
           "processor.max_cstate=1",
           strerrordesc_np(error));
}

void set_timer_slack(const SetupRequest& request, SetupReport& report) noexcept {
  // 0 would select the default.
  const unsigned long slack = request.timer_slack_ns > 0 ? request.timer_slack_ns : 1;
  const bool ok = prctl(PR_SET_TIMERSLACK, slack, 0, 0, 0) == 0;
  if (ok) return add_step(report, "timer-slack", false, true, "%lu ns", slack);
  add_step(report, "timer-slack", false, false, "prctl: %s; normal sleeps end up to 50 us late",
           strerrordesc_np(errno));
}

void flush_denormals(SetupReport& report) noexcept {
  set_denormals_flush();
  const bool ok = denormals_flushed();
  add_step(report, "denormals", false, ok, ok ? "flushed to zero" : "this CPU does not flush them: slow near rest");
}

void set_priority(const SetupRequest& request, SetupReport& report) noexcept {
  if (request.priority == 0) return add_step(report, "priority", true, false, "not asked for: a normal thread");
  const int low = sched_get_priority_min(SCHED_FIFO), high = sched_get_priority_max(SCHED_FIFO);
  if (request.priority < low || request.priority > high) {
    return add_step(report, "priority", true, false, "there is no SCHED_FIFO %d: accepted are %d to %d, and 0 for none",
                    request.priority, low, high);
  }
  sched_param parameters{};
  parameters.sched_priority = request.priority;
  if (sched_setscheduler(0, SCHED_FIFO, &parameters) != 0) {
    return add_step(report, "priority", true, false,
                    "SCHED_FIFO %d: %s; set 'rtprio %d' for this user in /etc/security/limits.d, or give CAP_SYS_NICE",
                    request.priority, strerrordesc_np(errno), high);
  }
  add_step(report, "priority", true, true, "SCHED_FIFO %d", request.priority);
}

}  // namespace

bool SetupReport::degraded() const noexcept {
  for (const SetupStep& step : steps) {
    if (step.privilege && !step.ok) return true;
  }
  return false;
}

bool SetupReport::failed() const noexcept {
  for (const SetupStep& step : steps)
    if (!step.ok) return true;
  return degraded();
}

const SetupStep* SetupReport::find(std::string_view name) const noexcept {
  for (const SetupStep& step : steps) {
    if (name == step.name) return &step;
  }
  return nullptr;
}

int CpuAwake::hold() noexcept {
  if (held()) return 0;
  const int file = open("/dev/cpu_dma_latency", O_WRONLY | O_CLOEXEC);
  if (file < 0) return errno;
  const std::int32_t longest_wake_us = 0;
  if (write(file, &longest_wake_us, sizeof longest_wake_us) != sizeof longest_wake_us) {
    const int error = errno;
    close(file);
    return error;
  }
  file_ = file;
  return 0;
}

void CpuAwake::release() noexcept {
  if (held()) close(std::exchange(file_, -1));
}

SetupReport setup_realtime(const SetupRequest& request, CpuAwake& awake) noexcept {
  SetupReport report;
  report_kernel(report);
  pin_to_cpu(request, report);
  lock_memory(request, report);
  keep_heap(report);
  touch_stack(request, report);
  hold_cpu_awake(request, awake, report);
  set_timer_slack(request, report);
  flush_denormals(report);
  set_priority(request, report);
  return report;
}

bool has_capability(unsigned capability) noexcept {
  __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
  __user_cap_data_struct sets[_LINUX_CAPABILITY_U32S_3]{};
  if (syscall(SYS_capget, &header, sets) != 0) return false;
  return (sets[capability / 32].effective >> (capability % 32) & 1u) != 0;
}

bool kernel_is_preempt_rt() noexcept {
  if (const int file = open("/sys/kernel/realtime", O_RDONLY | O_CLOEXEC); file >= 0) {
    char answer = '0';
    const bool read_it = read(file, &answer, 1) == 1;
    close(file);
    if (read_it) return answer == '1';
  }
  utsname kernel{};
  return uname(&kernel) == 0 && std::strstr(kernel.version, "PREEMPT_RT") != nullptr;
}

std::vector<int> allowed_cpus() {
  std::vector<int> cpus;
  cpu_set_t set;
  CPU_ZERO(&set);
  if (sched_getaffinity(0, sizeof set, &set) != 0) return cpus;
  for (int cpu = 0; cpu < CPU_SETSIZE; ++cpu)
    if (CPU_ISSET(static_cast<unsigned>(cpu), &set)) cpus.push_back(cpu);
  return cpus;
}

bool may_stay_on(int cpu) noexcept {
  if (cpu < 0 || cpu >= CPU_SETSIZE) return false;
  cpu_set_t before, wanted;
  CPU_ZERO(&wanted);
  CPU_SET(static_cast<unsigned>(cpu), &wanted);
  if (sched_getaffinity(0, sizeof before, &before) != 0) return false;
  if (sched_setaffinity(0, sizeof wanted, &wanted) != 0) return false;
  sched_setaffinity(0, sizeof before, &before);
  return true;
}

}  // namespace tactus::loop
