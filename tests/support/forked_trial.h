// A trial in a process of its own, which a system call filter or _exit() ends, and what it counted there.
#pragma once

#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <new>
#include <type_traits>

namespace tactus::test {

// Runs body(counts) in a child process, which must end itself by _exit(0), and returns the counts. They are in shared
// memory, so that the child needs no system call to hand them over.
template <class Counts, class Body>
Counts run_forked(Body&& body) {
  static_assert(std::is_trivially_copyable_v<Counts>);
  void* const shared = mmap(nullptr, sizeof(Counts), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  REQUIRE(shared != MAP_FAILED);
  auto& counts = *new (shared) Counts;
  const pid_t child = fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    body(counts);
    _exit(1);
  }
  int status = 0;
  REQUIRE(waitpid(child, &status, 0) == child);
  REQUIRE(WIFEXITED(status));
  REQUIRE(WEXITSTATUS(status) == 0);
  const Counts result = counts;
  munmap(shared, sizeof(Counts));
  return result;
}

}  // namespace tactus::test
