#include "tests/support/syscall_filter.h"

#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cstddef>

namespace tactus::test {
namespace {

std::atomic<std::uint64_t> g_refused{0};
std::atomic<long> g_first{-1};

void count_refusal(int, siginfo_t* info, void*) {
  if (g_refused.fetch_add(1) == 0) g_first.store(info->si_syscall);
}

}  // namespace

bool install_syscall_filter(std::span<const long> allowed) noexcept {
  if (allowed.size() > kMaxAllowed) return false;
  struct sigaction action {};
  action.sa_sigaction = count_refusal;
  action.sa_flags = SA_SIGINFO;
  if (sigaction(SIGSYS, &action, nullptr) != 0) return false;
  // The haptic thread blocks all signals; a blocked SIGSYS would end the process instead of being counted.
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGSYS);
  if (pthread_sigmask(SIG_UNBLOCK, &set, nullptr) != 0) return false;

  std::array<sock_filter, kMaxAllowed * 2 + 8> program{};
  unsigned short length = 0;
  const auto load = [&](std::size_t offset) {
    program[length++] = BPF_STMT(BPF_LD | BPF_W | BPF_ABS, static_cast<std::uint32_t>(offset));
  };
  const auto allow_if = [&](std::uint32_t number) {
    program[length++] = BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, number, 0, 1);
    program[length++] = BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW);
  };
  load(offsetof(seccomp_data, arch));
  program[length++] = BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, AUDIT_ARCH_X86_64, 1, 0);
  program[length++] = BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_TRAP);
  load(offsetof(seccomp_data, nr));
  allow_if(SYS_rt_sigreturn);
  for (const long number : allowed) allow_if(static_cast<std::uint32_t>(number));
  program[length++] = BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_TRAP);

  const sock_fprog filter{length, program.data()};
  if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) return false;
  return syscall(SYS_seccomp, SECCOMP_SET_MODE_FILTER, 0, &filter) == 0;
}

std::uint64_t refused_syscalls() noexcept { return g_refused.load(); }
long first_refused_syscall() noexcept { return g_first.load(); }

}  // namespace tactus::test
