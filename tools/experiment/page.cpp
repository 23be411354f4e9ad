#include "tools/experiment/page.h"

#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <nlohmann/json.hpp>

#include "tools/experiment/shared_files.h"
#include "tools/json_text.h"
#include "tools/version/provenance.h"

namespace tactus::experiment {
namespace {

// Exit status of the page script: matplotlib is missing; the file cannot be written.
constexpr int kLibraryMissing = 3, kFileRefused = 4;

bool write_all(int to, const std::string& text) {
  for (std::size_t done = 0; done < text.size();) {
    const ssize_t wrote = write(to, text.data() + done, text.size() - done);
    if (wrote <= 0) return false;
    done += static_cast<std::size_t>(wrote);
  }
  return true;
}

// Runs the script with what it is to do, and `input` on its standard input.
Status run_writer(const std::string& what, const std::string& path, const std::string& input) {
  const std::string writer = shared_file("experiment_page").string();
  if (access(writer.c_str(), R_OK) != 0)
    return Status::error(fmt::format("--page: the page's writer is not there: {}; install tactus as a whole", writer));
  std::array<int, 2> pipe_ends{};
  if (pipe(pipe_ends.data()) != 0) return Status::error("--page: no pipe to the page's writer");
  std::signal(SIGPIPE, SIG_IGN);  // the exit status reports a script that ended early
  const pid_t child = fork();
  if (child < 0) return Status::error("--page: the page's writer could not be started");
  if (child == 0) {
    dup2(pipe_ends[0], STDIN_FILENO);
    close(pipe_ends[0]);
    close(pipe_ends[1]);
    execlp("python3", "python3", writer.c_str(), what.c_str(), path.c_str(), nullptr);
    _exit(kLibraryMissing);
  }
  close(pipe_ends[0]);
  const bool written = write_all(pipe_ends[1], input);
  close(pipe_ends[1]);
  int status = 0;
  if (waitpid(child, &status, 0) != child || !WIFEXITED(status)) return Status::error("--page: the page's writer died");
  if (WEXITSTATUS(status) == kLibraryMissing)
    return Status::error("--page: needs python3 with matplotlib; install what Debian calls python3-matplotlib");
  if (WEXITSTATUS(status) == kFileRefused) return Status::error(fmt::format("--page: {}: cannot be written", path));
  if (WEXITSTATUS(status) != 0 || !written)
    return Status::error(fmt::format("--page: {} failed, as it says above; no page was written", writer));
  return Status::good();
}

}  // namespace

Status check_page_writer() { return run_writer("--check", "", ""); }

Status write_page(const std::string& experiment, const std::string& json, const std::string& command,
                  const std::string& path) {
  return run_writer(experiment, path,
                    fmt::format("{{\"made\": {},\n\"data\": {}}}\n", json_text(to_json(provenance(command))), json));
}

}  // namespace tactus::experiment
