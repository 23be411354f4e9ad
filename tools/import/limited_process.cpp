#include "tools/import/limited_process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <fstream>

#include "rt/base/sanitizer.h"

namespace tactus::scene_import {
namespace {

constexpr int kNotFound = 127;

std::size_t resident_bytes(pid_t process) {
  std::ifstream file(fmt::format("/proc/{}/statm", process));
  std::size_t all = 0, resident = 0;
  file >> all >> resident;
  return resident * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
}

bool write_all(int out, const std::string& text) {
  std::size_t at = 0;
  while (at < text.size()) {
    const ssize_t written = ::write(out, text.data() + at, text.size() - at);
    if (written <= 0) return false;
    at += static_cast<std::size_t>(written);
  }
  return true;
}

// Limits the address space, except under the address sanitizer, which reserves terabytes.
void limit_addresses([[maybe_unused]] std::size_t bytes) {
#if !TACTUS_ADDRESS_SANITIZER
  const rlimit space{bytes, bytes};
  (void)::setrlimit(RLIMIT_AS, &space);
#endif
}

// Called in the new process: sets its limits, resets signal handlers and closes the standard streams.
void confine(const Limits& limits) {
  const rlimit cpu{limits.cpu_s, limits.cpu_s}, core{0, 0};
  (void)::setrlimit(RLIMIT_CPU, &cpu);
  (void)::setrlimit(RLIMIT_CORE, &core);
  for (const int fatal : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGTERM}) (void)::signal(fatal, SIG_DFL);
  const int nowhere = ::open("/dev/null", O_RDWR | O_CLOEXEC);
  (void)::dup2(nowhere, STDIN_FILENO);
  (void)::dup2(nowhere, STDOUT_FILENO);
  (void)::dup2(nowhere, STDERR_FILENO);
}

// Reads until the process closes its end. Returns what went beyond its limit, or empty.
std::string read_answer(pid_t process, int in, const Limits& limits, std::string& answer) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(limits.wall_s);
  std::array<char, 65536> buffer;
  for (;;) {
    pollfd ready{in, POLLIN, 0};
    const int count = ::poll(&ready, 1, 50);
    if (std::chrono::steady_clock::now() > end) return fmt::format("takes longer than {} s", limits.wall_s);
    if (resident_bytes(process) > limits.memory_bytes)
      return fmt::format("needs more than {} MB of memory", limits.memory_bytes >> 20);
    if (count <= 0) continue;
    const ssize_t got = ::read(in, buffer.data(), buffer.size());
    if (got == 0 || (got < 0 && errno != EINTR)) return {};
    if (got > 0) answer.append(buffer.data(), static_cast<std::size_t>(got));
    if (answer.size() > limits.answer_bytes) return fmt::format("becomes more than {} MB", limits.answer_bytes >> 20);
  }
}

std::string end_of(int status, const Limits& limits) {
  if (WIFSIGNALED(status) && (WTERMSIG(status) == SIGXCPU || WTERMSIG(status) == SIGKILL))
    return fmt::format("takes longer than {} s of computing, or was killed", limits.cpu_s);
  if (WIFSIGNALED(status)) return fmt::format("ends its reader by the signal {}", strsignal(WTERMSIG(status)));
  if (WIFEXITED(status) && WEXITSTATUS(status) == kNotFound) return "needs a program that is not there";
  return fmt::format("ends its reader with status {}", WEXITSTATUS(status));
}

// `inside` returns false if it failed. Nothing that it throws leaves the new process.
Result<std::string> run(const std::function<bool(int)>& inside, const Limits& limits) {
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) return Status::error(fmt::format("no pipe: {}", std::strerror(errno)));
  const pid_t process = ::fork();
  if (process < 0) return Status::error(fmt::format("no process: {}", std::strerror(errno)));
  if (process == 0) {
    ::close(ends[0]);
    confine(limits);
    bool good = false;
    try {
      good = inside(ends[1]);
    } catch (...) {}
    ::_exit(good ? 0 : 1);
  }
  ::close(ends[1]);
  std::string answer;
  const std::string beyond = read_answer(process, ends[0], limits, answer);
  ::close(ends[0]);
  if (!beyond.empty()) ::kill(process, SIGKILL);
  int status = 0;
  while (::waitpid(process, &status, 0) < 0 && errno == EINTR) continue;
  if (!beyond.empty()) return Status::error(beyond);
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) return Status::error(end_of(status, limits));
  return answer;
}

}  // namespace

Result<std::string> run_program(const std::vector<std::string>& words, const Limits& limits) {
  std::vector<std::string> copies = words;
  std::vector<char*> arguments;
  for (std::string& word : copies) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  return run(
      [&arguments](int out) -> bool {
        (void)::dup2(out, STDOUT_FILENO);
        ::execvp(arguments[0], arguments.data());
        ::_exit(kNotFound);
      },
      limits);
}

Result<std::string> run_apart(const std::function<std::string()>& work, const Limits& limits) {
  return run(
      [&](int out) {
        limit_addresses(limits.memory_bytes);
        return write_all(out, work());
      },
      limits);
}

}  // namespace tactus::scene_import
