#include "tools/tactus/viewer_process.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstring>
#include <string>
#include <string_view>
#include <thread>

namespace tactus::tools {

Result<std::unique_ptr<ViewerProcess>> ViewerProcess::start(const std::filesystem::path& socket) {
  return start(socket, false);
}

Result<std::unique_ptr<ViewerProcess>> ViewerProcess::start_silent(const std::filesystem::path& socket) {
  auto started = start(socket, true);
  if (!started.ok()) return started;
  if (const Status status = started.value()->read_address(); !status.ok()) return status;
  return started;
}

Result<std::unique_ptr<ViewerProcess>> ViewerProcess::start(const std::filesystem::path& socket, bool silent) {
  int ends[2]{-1, -1};
  if (silent && pipe2(ends, O_CLOEXEC) != 0) return Status::error("the viewer cannot be started: no pipe");
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  if (silent) posix_spawn_file_actions_adddup2(&files, ends[1], STDERR_FILENO);
  posix_spawn_file_actions_adddup2(&files, STDERR_FILENO, STDOUT_FILENO);  // standard output is for the run's summary
  // A process group of its own: Ctrl-C reaches only the run, which then ends the viewer.
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  std::string program = "tactus", command = "view", option = "--socket", path = socket.string();
  char* const arguments[] = {program.data(), command.data(), option.data(), path.data(), nullptr};
  pid_t process = -1;
  const int error = posix_spawn(&process, "/proc/self/exe", &files, &attributes, arguments, environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&files);
  if (silent) close(ends[1]);
  if (error == 0) return std::unique_ptr<ViewerProcess>(new ViewerProcess(process, ends[0]));
  if (silent) close(ends[0]);
  return Status::error(std::string("the viewer cannot be started: ") + strerrordesc_np(error));
}

Status ViewerProcess::read_address() {
  constexpr int kPatience_ms = 10'000;
  constexpr std::string_view kScheme = "http://";
  std::string said;
  pollfd ready{output_, POLLIN, 0};
  while (said.find('\n') == std::string::npos && poll(&ready, 1, kPatience_ms) == 1) {
    char bytes[256];
    const ssize_t got = read(output_, bytes, sizeof bytes);
    if (got <= 0) break;
    said.append(bytes, static_cast<std::size_t>(got));
  }
  said = said.substr(0, said.find('\n'));
  const std::size_t at = said.find(kScheme);
  if (at == std::string::npos) return Status::error(said.empty() ? "the viewer prints no address" : said);
  address_ = said.substr(at);
  return Status::good();
}

ViewerProcess::~ViewerProcess() {
  kill(process_, SIGTERM);
  if (output_ >= 0) close(output_);
  constexpr int kTries = 100;
  for (int i = 0; i < kTries; ++i) {
    if (waitpid(process_, nullptr, WNOHANG) != 0) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  kill(process_, SIGKILL);
  (void)waitpid(process_, nullptr, 0);
}

}  // namespace tactus::tools
