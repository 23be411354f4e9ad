#include "tools/timing/load.h"

#include <fmt/format.h>
#include <sched.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "tools/session/cores.h"

namespace tactus::timing {
namespace {

constexpr std::size_t kMemoryBytes = 256u << 20;  // beyond the caches of a PC

cpu_set_t set_of(const std::vector<int>& cpus) {
  cpu_set_t set;
  CPU_ZERO(&set);
  for (const int cpu : cpus) CPU_SET(static_cast<unsigned>(cpu), &set);
  return set;
}

[[noreturn]] void calculate() noexcept {
  volatile double x = 1;
  for (;;) x = x * 1.0000001 + 1e-9;
}

[[noreturn]] void stream() noexcept {
  void* block = mmap(nullptr, kMemoryBytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (block == MAP_FAILED) calculate();
  auto* bytes = static_cast<volatile std::uint64_t*>(block);
  for (std::uint64_t round = 0;; ++round)
    for (std::size_t i = 0; i < kMemoryBytes / sizeof(std::uint64_t); i += 8) bytes[i] = bytes[i] + round;
}

[[noreturn]] void run_stress_ng(std::size_t cores) noexcept {
  char count[16];
  std::snprintf(count, sizeof count, "%zu", cores);
  const char* const arguments[]{"stress-ng", "--quiet", "--cpu", count,      "--vm", count,  "--vm-bytes",
                                "64m",       "--hdd",   "1",     "--switch", "1",    nullptr};
  execvp(arguments[0], const_cast<char* const*>(arguments));
  _exit(127);
}

bool installed(const std::string& program) {
  const char* path = std::getenv("PATH");
  std::string folders = path != nullptr ? path : "";
  for (std::size_t at = 0; at <= folders.size();) {
    const std::size_t end = std::min(folders.find(':', at), folders.size());
    if (access((folders.substr(at, end - at) + "/" + program).c_str(), X_OK) == 0) return true;
    at = end + 1;
  }
  return false;
}

}  // namespace

Result<LoadKind> parse_load(const std::string& word) {
  if (word == "none") return LoadKind::kNone;
  if (word == "cpu") return LoadKind::kCpu;
  if (word == "memory") return LoadKind::kMemory;
  if (word == "stress-ng") return LoadKind::kStressNg;
  return Status::error(fmt::format("--load: '{}' is none; accepted: none, cpu, memory, stress-ng", word));
}

Status Load::start(LoadKind kind, int spare_cpu) {
  if (kind == LoadKind::kNone) return Status::good();
  if (kind == LoadKind::kStressNg && !installed("stress-ng"))
    return Status::error(
        "--load stress-ng: no such program here; install it (Debian: stress-ng), or use cpu or memory");
  const std::vector<int> cpus = session::cores_without(spare_cpu);
  const pid_t parent = getpid();
  const std::size_t count = kind == LoadKind::kStressNg ? 1 : cpus.size();
  // A child that receives SIGTERM or SIGINT must not run this program's handlers, not even before it has reset them.
  sigset_t endings, before;
  sigemptyset(&endings);
  sigaddset(&endings, SIGTERM);
  sigaddset(&endings, SIGINT);
  pthread_sigmask(SIG_BLOCK, &endings, &before);
  Status status = Status::good();
  for (std::size_t i = 0; i < count && status.ok(); ++i) {
    const cpu_set_t set = count == 1 ? set_of(cpus) : set_of({cpus[i]});
    const pid_t child = fork();
    if (child < 0) status = Status::error(fmt::format("--load: no process to be had: {}", strerrordesc_np(errno)));
    if (child > 0) children_.push_back(child);
    if (child != 0) continue;
    signal(SIGTERM, SIG_DFL);
    signal(SIGINT, SIG_DFL);
    pthread_sigmask(SIG_SETMASK, &before, nullptr);
    setpgid(0, 0);  // own process group, so that stop() also ends its children
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() != parent) _exit(0);
    sched_setaffinity(0, sizeof set, &set);
    if (kind == LoadKind::kStressNg) run_stress_ng(cpus.size());
    if (kind == LoadKind::kMemory) stream();
    calculate();
  }
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  return status;
}

void Load::stop() noexcept {
  for (const int child : children_) {
    kill(-child, SIGTERM);
    kill(child, SIGTERM);  // in case it has not created its group yet
  }
  for (const int child : children_)
    while (waitpid(child, nullptr, 0) < 0 && errno == EINTR) {}
  children_.clear();
}

}  // namespace tactus::timing
