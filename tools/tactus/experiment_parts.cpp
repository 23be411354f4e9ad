#include "tools/tactus/experiment_parts.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>

#include "tools/json_text.h"
#include "tools/tactus/commands.h"
#include "tools/tactus/experiment_output.h"
#include "tools/tactus/help_texts.h"
#include "tools/tactus/in_range.h"
#include "tools/tactus/python_module.h"

namespace tactus::tools {
namespace {

constexpr int kInterrupted = 130;  // of tactus.sweep.parts, as a shell has it

// All that the process prints, and its exit status; -1 if a signal ended it.
struct Printed {
  std::string text;
  int status{-1};
};

volatile std::sig_atomic_t g_process = 0;  // id of the process to which the handler passes the signal on
void pass_on(int signal) { kill(static_cast<pid_t>(g_process), signal); }

// Until destroyed, passes signals that would end this process on to another process, which ends its workers and reports
// what it leaves. Ctrl-C at a terminal reaches that process twice; the second signal has no effect.
class PassedSignals {
 public:
  explicit PassedSignals(pid_t process) {
    g_process = process;
    for (std::size_t i = 0; i < kSignals.size(); ++i) {
      struct sigaction act {};
      act.sa_handler = pass_on;
      sigaction(kSignals[i], &act, &before_[i]);
      if (before_[i].sa_handler == SIG_IGN) sigaction(kSignals[i], &before_[i], nullptr);  // as under nohup
    }
  }
  ~PassedSignals() {
    for (std::size_t i = 0; i < kSignals.size(); ++i) sigaction(kSignals[i], &before_[i], nullptr);
  }
  static bool passes(int signal) { return std::find(kSignals.begin(), kSignals.end(), signal) != kSignals.end(); }
  PassedSignals(const PassedSignals&) = delete;
  PassedSignals& operator=(const PassedSignals&) = delete;

 private:
  static constexpr std::array<int, 3> kSignals{SIGINT, SIGTERM, SIGHUP};
  std::array<struct sigaction, 3> before_{};
};

// In the new process.
[[noreturn]] void become(const std::vector<char*>& arguments, int output) {
  prctl(PR_SET_PDEATHSIG, SIGTERM);  // if this program is killed
  dup2(output, STDOUT_FILENO);
  execv(arguments[0], arguments.data());
  _exit(127);
}

Result<Printed> print_of(std::vector<std::string> words) {
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) return Status::error(fmt::format("no pipe: {}", std::strerror(errno)));
  const pid_t process = fork();
  if (process == 0) become(arguments, ends[1]);
  const int error = errno;
  close(ends[1]);
  if (process < 0) {
    close(ends[0]);
    return Status::error(fmt::format("no process: {}", std::strerror(error)));
  }
  const PassedSignals signals(process);
  Printed printed;
  char block[1 << 16];
  for (ssize_t got = 1; got != 0;) {
    got = read(ends[0], block, sizeof block);
    if (got > 0) printed.text.append(block, static_cast<std::size_t>(got));
    if (got < 0 && errno != EINTR) break;
  }
  close(ends[0]);
  int ended = 0;
  while (waitpid(process, &ended, 0) < 0 && errno == EINTR) {}
  if (WIFEXITED(ended)) printed.status = WEXITSTATUS(ended);
  if (WIFSIGNALED(ended) && PassedSignals::passes(WTERMSIG(ended)))  // the signal ended it before it could report
    printed = {.text = "interrupted; the same command goes on", .status = kInterrupted};
  if (printed.status == 127) return Status::error(fmt::format("{} cannot be run", words[0]));
  return printed;
}

}  // namespace

void PartOptions::add(CLI::App& command) {
  CLI::Option* here = command.add_option("--workers", workers, help::kWorkers)->check(in_range(1, 1024));
  command.add_option("--scheduler", scheduler, help::kScheduler)->excludes(here);
  command.add_flag("--trust-network", trust_network, help::kTrustNetwork);
  command.add_option("--part", part)->group("");
}

Result<std::vector<std::string>> run_parts(const PartOptions& options, const PartWork& work) {
  const std::string program = own_program();
  const std::filesystem::path module = python_module_folder(program);
  if (module.empty())
    return Status::error(
        "--workers and --scheduler need the Python module, which is built where Debian's pybind11-dev and python3-dev "
        "are");
  setenv("PYTHONPATH", module.c_str(), 1);
  const nlohmann::ordered_json task{{"program", program},
                                    {"arguments", work.arguments},
                                    {"parts", work.count},
                                    {"scenes", work.scenes},
                                    {"workers", options.workers},
                                    {"scheduler", options.scheduler},
                                    {"trust_network", options.trust_network}};
  auto printed = print_of({kPython, "-m", "tactus.sweep.parts", json_text(task)});
  if (!printed.ok()) return printed.status();
  const auto& [said, status] = printed.value();
  if (status == kInterrupted)
    std::exit(complain(fmt::format("tactus {} {}: {}", work.arguments[0], work.arguments[1], said), kExitVerdictBad));
  if (status == 1 && !said.empty()) return Status::error(said);
  if (status != 0) return Status::error("its parts have not ended");
  std::vector<std::string> parts;
  experiment::PartReader reader(said);
  for (std::size_t i = 0; i < work.count; ++i) reader(parts.emplace_back());
  if (!reader.ok() || !reader.at_end()) return Status::error("the parts' results are cut off");
  return parts;
}

int print_part_bytes(const std::string& bytes) {
  return std::fwrite(bytes.data(), 1, bytes.size(), stdout) == bytes.size() && std::fflush(stdout) == 0
             ? kExitGood
             : kExitMachineCannot;
}

int no_such_part(const std::string& experiment, std::size_t count) {
  return experiment_failed(experiment, fmt::format("--part: accepted: 0 to {}", count - 1));
}

}  // namespace tactus::tools
