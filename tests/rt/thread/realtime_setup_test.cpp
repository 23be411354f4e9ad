#include "rt/thread/realtime_setup.h"

#include <linux/capability.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <catch2/catch.hpp>

#include <algorithm>
#include <fstream>
#include <functional>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "tests/support/rt_guard.h"
#include "tests/support/skip.h"

using namespace tactus;
using namespace tactus::loop;

namespace {

// The set-up changes the process too (locked memory, limits), so each case has a process of its own. Its exit status is
// the number of the first claim that failed.
class Claims {
 public:
  void that(bool holds) {
    ++number_;
    if (!holds && failed_ == 0) failed_ = number_;
  }
  int failed() const { return failed_; }

 private:
  int number_{0}, failed_{0};
};

constexpr int kCannot = 77;  // exit status of a process that lacks a privilege

// 0, or the number of the first claim that does not hold.
int in_own_process(const std::function<void(Claims&)>& work) {
  const pid_t child = fork();
  if (child == 0) {
    Claims claims;
    work(claims);
    _exit(claims.failed());
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

// A user without any privilege: no real-time priority, no memory to lock, no capability.
void drop_privileges() {
  const rlimit nothing{0, 0};
  setrlimit(RLIMIT_RTPRIO, &nothing);
  setrlimit(RLIMIT_MEMLOCK, &nothing);
  if (geteuid() == 0 && setresuid(65534, 65534, 65534) != 0) _exit(255);
}

SetupRequest modest() {
  SetupRequest request;
  request.cpu = -1;
  request.priority = 0;
  request.lock_memory = false;
  request.hold_cpu_awake = false;
  request.stack_KiB = 16;
  return request;
}

int own_cpu() {
  cpu_set_t set;
  CPU_ZERO(&set);
  sched_getaffinity(0, sizeof set, &set);
  for (unsigned cpu = 0; cpu < CPU_SETSIZE; ++cpu) {
    if (CPU_ISSET(cpu, &set)) return static_cast<int>(cpu);
  }
  return -1;
}

// Faults of writing to so much stack below the caller.
[[gnu::noinline]] std::uint64_t faults_of_using(std::size_t KiB) {
  const test::RtGuard guard;
  auto* block = static_cast<volatile char*>(__builtin_alloca(KiB * 1024));
  for (std::size_t i = 0; i < KiB * 1024; i += 1024) block[KiB * 1024 - 1 - i] = 1;
  return guard.minor_faults();
}

bool contains(std::string_view text, std::string_view part) { return text.find(part) != std::string_view::npos; }

}  // namespace

TEST_CASE("the report has each step once, in its order, and no line is empty", "[loop][threads]") {
  CpuAwake awake;
  SetupReport report;
  std::thread([&] { report = setup_realtime(modest(), awake); }).join();
  const char* const names[] = {"kernel",      "cpu",         "memory",    "heap",    "stack",
                               "cpu-latency", "timer-slack", "denormals", "priority"};
  REQUIRE(report.steps.size() == std::size(names));
  for (std::uint32_t i = 0; i < report.steps.size(); ++i) {
    CHECK(std::string(report.steps[i].name) == names[i]);
    CHECK(!report.steps[i].message().empty());
    CHECK(report.steps[i].message().size() < kSetupMessageBytes - 1);
  }
  CHECK(report.find("cpu") == &report.steps[1]);
  CHECK(report.find("no-such") == nullptr);
  CHECK(report.preempt_rt == kernel_is_preempt_rt());
  CHECK(report.find("kernel")->ok == report.preempt_rt);
}

TEST_CASE("a thread that asks for no privileges is degraded, not silently normal", "[loop][threads]") {
  CpuAwake awake;
  SetupReport report;
  std::thread([&] { report = setup_realtime(modest(), awake); }).join();
  CHECK(report.degraded());
  CHECK(!report.find("priority")->ok);
  CHECK(!report.find("memory")->ok);
  CHECK(!awake.held());
}

TEST_CASE("only a missing privilege makes the report degraded", "[loop]") {
  SetupReport report;
  CHECK(!report.degraded());
  SetupStep kernel;
  kernel.ok = false;
  REQUIRE(report.steps.try_push(kernel));
  CHECK(!report.degraded());
  SetupStep granted;
  granted.privilege = true;
  REQUIRE(report.steps.try_push(granted));
  CHECK(!report.degraded());
  granted.ok = false;
  REQUIRE(report.steps.try_push(granted));
  CHECK(report.degraded());
}

TEST_CASE("what the report calls done is so: affinity, priority, timer slack, denormals, locked pages", "[loop]") {
  const int failed = in_own_process([](Claims& claims) {
    SetupRequest request;
    request.cpu = own_cpu();
    request.priority = 10;
    CpuAwake awake;
    const SetupReport report = setup_realtime(request, awake);
    cpu_set_t set;
    CPU_ZERO(&set);
    sched_getaffinity(0, sizeof set, &set);
    claims.that(report.find("cpu")->ok);  // 1: our own cpu can always be had
    claims.that(CPU_COUNT(&set) == 1 && CPU_ISSET(static_cast<unsigned>(request.cpu), &set));  // 2
    sched_param parameters{};
    sched_getparam(0, &parameters);
    const bool fifo = sched_getscheduler(0) == SCHED_FIFO && parameters.sched_priority == 10;
    claims.that(report.find("priority")->ok == fifo);                  // 3
    claims.that(prctl(PR_GET_TIMERSLACK, 0, 0, 0, 0) == 1 || fifo);    // 4: a real-time thread has none
    claims.that(denormals_flushed() && report.find("denormals")->ok);  // 5
    claims.that(report.find("cpu-latency")->ok == awake.held());       // 6
    claims.that(report.find("stack")->ok);                             // 7
    awake.release();
    claims.that(!awake.held());  // 8
  });
  CHECK(failed == 0);
}

TEST_CASE("a page mapped after memory is locked is there before it is touched", "[loop]") {
  TACTUS_NEEDS(test::RtGuard::available(), "a sanitizer swallows mlockall and says that it worked");
  const int failed = in_own_process([](Claims& claims) {
    CpuAwake awake;
    if (!setup_realtime(SetupRequest{}, awake).find("memory")->ok) _exit(kCannot);
    void* page = mmap(nullptr, 4096, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    unsigned char there = 0;
    claims.that(page != MAP_FAILED && mincore(page, 4096, &there) == 0 && (there & 1) != 0);
  });
  TACTUS_NEEDS(failed != kCannot, "needs root or the limit memlock, to lock memory");
  CHECK(failed == 0);
}

TEST_CASE("a requested priority is set", "[loop]") {
  const int failed = in_own_process([](Claims& claims) {
    SetupRequest request;
    request.priority = 10;
    CpuAwake awake;
    if (!setup_realtime(request, awake).find("priority")->ok) _exit(kCannot);
    sched_param parameters{};
    sched_getparam(0, &parameters);
    claims.that(sched_getscheduler(0) == SCHED_FIFO && parameters.sched_priority == 10);
  });
  TACTUS_NEEDS(failed != kCannot, "needs root or the limit rtprio, for a real-time priority");
  CHECK(failed == 0);
}

TEST_CASE("without privileges each refused call is a line with its remedy, and the thread works on", "[loop]") {
  TACTUS_NEEDS(geteuid() != 0 || test::RtGuard::available(), "a sanitizer swallows mlockall and says that it worked");
  const int failed = in_own_process([](Claims& claims) {
    drop_privileges();
    CpuAwake awake;
    const SetupReport report = setup_realtime(SetupRequest{}, awake);
    claims.that(report.degraded());                                         // 1
    claims.that(!report.find("priority")->ok);                              // 2
    claims.that(contains(report.find("priority")->message(), "limits.d"));  // 3
    claims.that(!report.find("memory")->ok);                                // 4
    claims.that(contains(report.find("memory")->message(), "memlock"));     // 5
    claims.that(report.find("denormals")->ok);                              // 6
    // Nothing is locked for the future, so memory can still be had.
    void* block = mmap(nullptr, 1u << 20, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    claims.that(block != MAP_FAILED);                                           // 7
    claims.that(report.find("cpu-latency")->ok == awake.held());                // 8
    if (access("/dev/cpu_dma_latency", W_OK) != 0) claims.that(!awake.held());  // 9
  });
  CHECK(failed == 0);
}

TEST_CASE("a cpu or a priority that does not exist is refused, with what is accepted", "[loop]") {
  const int failed = in_own_process([](Claims& claims) {
    cpu_set_t before, after;
    sched_getaffinity(0, sizeof before, &before);
    SetupRequest request = modest();
    request.cpu = 5000;
    request.priority = 100;
    CpuAwake awake;
    SetupReport report = setup_realtime(request, awake);
    sched_getaffinity(0, sizeof after, &after);
    claims.that(!report.find("cpu")->ok && contains(report.find("cpu")->message(), "0 to"));               // 1
    claims.that(!report.find("priority")->ok && contains(report.find("priority")->message(), "1 to 99"));  // 2
    claims.that(report.degraded());                                                                        // 3
    claims.that(CPU_EQUAL(&before, &after) != 0 && sched_getscheduler(0) == SCHED_OTHER);                  // 4
    request.priority = -1;
    report = setup_realtime(request, awake);
    claims.that(!report.find("priority")->ok);  // 5
  });
  CHECK(failed == 0);
}

TEST_CASE("the requested stack is touched at the start: later use causes no page fault", "[loop][threads]") {
  struct Answer {
    bool ok{false};
    std::uint64_t faults{0};
  } answer;
  pthread_attr_t attributes;
  pthread_attr_init(&attributes);
  pthread_attr_setstacksize(&attributes, 2048 * 1024);  // a sanitizer takes a part of it
  pthread_t thread{};
  const auto body = [](void* to) -> void* {
    SetupRequest request = modest();
    request.stack_KiB = 256;
    CpuAwake awake;
    const SetupReport report = setup_realtime(request, awake);
    auto* result = static_cast<Answer*>(to);
    result->ok = report.find("stack")->ok;
    if (result->ok) result->faults = faults_of_using(200);  // its frame begins a little above setup_realtime's
    return nullptr;
  };
  REQUIRE(pthread_create(&thread, &attributes, body, &answer) == 0);
  pthread_join(thread, nullptr);
  pthread_attr_destroy(&attributes);
  CHECK(answer.ok);
  if (test::RtGuard::available()) CHECK(answer.faults == 0);
}

TEST_CASE("a stack smaller than what shall be touched is a failed step, not a crash", "[loop][threads]") {
  SetupReport report;
  pthread_attr_t attributes;
  pthread_attr_init(&attributes);
  pthread_attr_setstacksize(&attributes, 256 * 1024);
  pthread_t thread{};
  const auto body = [](void* to) -> void* {
    SetupRequest request = modest();
    request.stack_KiB = 1024;
    CpuAwake awake;
    *static_cast<SetupReport*>(to) = setup_realtime(request, awake);
    return nullptr;
  };
  REQUIRE(pthread_create(&thread, &attributes, body, &report) == 0);
  pthread_join(thread, nullptr);
  pthread_attr_destroy(&attributes);
  REQUIRE(report.find("stack") != nullptr);
  CHECK(!report.find("stack")->ok);
  CHECK(contains(report.find("stack")->message(), "1024 KiB asked for"));
}

TEST_CASE("a capability is had exactly if the kernel lists it as effective", "[loop]") {
  std::ifstream status("/proc/thread-self/status");
  std::uint64_t effective = 0;
  bool found = false;
  for (std::string word; !found && status >> word;) found = word == "CapEff:" && (status >> std::hex >> effective);
  REQUIRE(found);
  for (unsigned capability = 0; capability <= CAP_LAST_CAP; ++capability) {
    CAPTURE(capability);
    CHECK(has_capability(capability) == ((effective >> capability & 1u) != 0));
  }
}

TEST_CASE("the allowed CPUs are those that the scheduler may choose from, ascending") {
  cpu_set_t set;
  CPU_ZERO(&set);
  REQUIRE(sched_getaffinity(0, sizeof set, &set) == 0);
  const std::vector<int> cpus = allowed_cpus();
  CHECK(cpus.size() == static_cast<std::size_t>(CPU_COUNT(&set)));
  CHECK(std::is_sorted(cpus.begin(), cpus.end()));
  for (const int cpu : cpus) CHECK(CPU_ISSET(static_cast<unsigned>(cpu), &set));
}

TEST_CASE("a thread may stay on each allowed CPU, not on one that does not exist, and its own CPUs stay the same") {
  const std::vector<int> before = allowed_cpus();
  for (const int cpu : before) CHECK(may_stay_on(cpu));
  for (const int cpu : {-1, static_cast<int>(sysconf(_SC_NPROCESSORS_CONF)), CPU_SETSIZE, 1 << 20})
    CHECK_FALSE(may_stay_on(cpu));
  CHECK(allowed_cpus() == before);
}

TEST_CASE("no capability is left without root's rights", "[loop]") {
  TACTUS_NEEDS(geteuid() == 0, "needs root, to give its rights up");
  CHECK(in_own_process([](Claims& claims) {
          drop_privileges();
          for (unsigned capability = 0; capability <= CAP_LAST_CAP; ++capability)
            claims.that(!has_capability(capability));
        }) == 0);
}
