#include "tools/tactus/experiment_parts.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
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
#include "tools/tactus/python_module.h"

namespace tactus::tools {
namespace {

// All that the process prints, and its exit status; -1 if a signal ended it.
struct Printed {
  std::string text;
  int status{-1};
};

// While it waits, Ctrl-C is the other process's, which says what it leaves.
Result<Printed> print_of(std::vector<std::string> words) {
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) return Status::error(fmt::format("no pipe: {}", std::strerror(errno)));
  const pid_t process = fork();
  if (process == 0) {
    dup2(ends[1], STDOUT_FILENO);
    execv(arguments[0], arguments.data());
    _exit(127);
  }
  const int error = errno;
  const auto before = std::signal(SIGINT, SIG_IGN);
  close(ends[1]);
  Printed printed;
  char block[1 << 16];
  for (ssize_t got = 1; process > 0 && got != 0;) {
    got = read(ends[0], block, sizeof block);
    if (got > 0) printed.text.append(block, static_cast<std::size_t>(got));
    if (got < 0 && errno != EINTR) break;
  }
  close(ends[0]);
  int ended = 0;
  while (process > 0 && waitpid(process, &ended, 0) < 0 && errno == EINTR) {}
  std::signal(SIGINT, before);
  if (process < 0) return Status::error(fmt::format("no process: {}", std::strerror(error)));
  if (WIFEXITED(ended)) printed.status = WEXITSTATUS(ended);
  if (printed.status == 127) return Status::error(fmt::format("{} cannot be run", words[0]));
  return printed;
}

}  // namespace

void PartOptions::add(CLI::App& command, const char* what) {
  CLI::Option* here =
      command
          .add_option("--workers", workers,
                      fmt::format("{} in so many processes of this machine, with the same figures", what))
          ->check(CLI::Range(1, 1024));
  command
      .add_option("--scheduler", scheduler,
                  "in those of the workers of this scheduler of Dask distributed, such as tcp://127.0.0.1:8786, see "
                  "tactus sweep --help")
      ->excludes(here);
  command.add_flag("--trust-network", trust_network, "take a scheduler that is neither on loopback nor TLS");
  command.add_option("--part", part)->group("");
}

Result<std::vector<std::string>> run_parts(const PartOptions& options, const std::vector<std::string>& arguments,
                                           std::size_t count) {
  const std::string program = own_program();
  const std::filesystem::path module = python_module_folder(program);
  if (module.empty())
    return Status::error(
        "--workers and --scheduler need the Python module, which is built where Debian's pybind11-dev and python3-dev "
        "are");
  setenv("PYTHONPATH", module.c_str(), 1);
  const nlohmann::ordered_json task{
      {"program", program},         {"arguments", arguments},         {"parts", count},
      {"workers", options.workers}, {"scheduler", options.scheduler}, {"trust_network", options.trust_network}};
  auto printed = print_of({kPython, "-m", "tactus.sweep.parts", json_text(task)});
  if (!printed.ok()) return printed.status();
  if (printed.value().status == 1 && !printed.value().text.empty()) return Status::error(printed.value().text);
  if (printed.value().status != 0) return Status::error("its parts have not ended");
  std::vector<std::string> parts;
  std::string& text = printed.value().text;
  experiment::PartReader reader(text);
  for (std::size_t i = 0; i < count; ++i) reader(parts.emplace_back());
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
