// Holds the calling thread to a few system calls, by the kernel itself (seccomp): any other is not carried out, and is
// counted. For tests of what the haptic thread may ask of the kernel after its start.
//
// Thread: install() on the thread that is held, which it is from then on until it ends; the counts [any]. Linux on
// x86-64. Bound: kMaxAllowed calls. Source: seccomp(2).
#pragma once

#include <cstdint>
#include <span>

namespace tactus::test {

inline constexpr std::size_t kMaxAllowed = 16;

// `allowed`: numbers of system calls (SYS_...); the return from the signal handler that counts is added. False: this
// kernel has no such filter.
[[nodiscard]] bool install_syscall_filter(std::span<const long> allowed) noexcept;

// In this process so far: how many were refused, and the first of them (-1: none).
std::uint64_t refused_syscalls() noexcept;
long first_refused_syscall() noexcept;

}  // namespace tactus::test
