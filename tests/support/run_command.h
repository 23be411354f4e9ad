// A command of the shell: its exit status and what it printed.
#pragma once

#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <csignal>
#include <cstdio>
#include <string>
#include <vector>

namespace tactus::test {

struct CommandOutput {
  int exit_code{-1};  // -1: a signal ended it
  std::string out;    // of standard output
};

inline CommandOutput run_command(const std::string& command) {
  FILE* pipe = popen(command.c_str(), "r");
  REQUIRE(pipe != nullptr);
  CommandOutput output;
  char buffer[4096];
  for (std::size_t n; (n = fread(buffer, 1, sizeof buffer, pipe)) > 0;) output.out.append(buffer, n);
  const int status = pclose(pipe);
  if (WIFEXITED(status)) output.exit_code = WEXITSTATUS(status);
  return output;
}

// A program that runs until it is told to stop: as soon as it has printed all `texts`, it gets SIGTERM. One that never
// prints them runs until ctest's own time limit.
inline CommandOutput run_until(const std::vector<std::string>& texts, const std::string& command) {
  int ends[2];
  REQUIRE(pipe(ends) == 0);
  const pid_t program = fork();
  REQUIRE(program >= 0);
  if (program == 0) {
    dup2(ends[1], STDOUT_FILENO);
    close(ends[0]);
    close(ends[1]);
    execl("/bin/sh", "sh", "-c", ("exec " + command).c_str(), nullptr);
    _exit(127);
  }
  close(ends[1]);
  CommandOutput output;
  bool told = false;
  char buffer[4096];
  for (ssize_t n; (n = read(ends[0], buffer, sizeof buffer)) > 0;) {
    output.out.append(buffer, static_cast<std::size_t>(n));
    const auto printed = [&](const std::string& text) { return output.out.find(text) != std::string::npos; };
    if (!told && std::all_of(texts.begin(), texts.end(), printed)) told = kill(program, SIGTERM) == 0;
  }
  close(ends[0]);
  int status = 0;
  waitpid(program, &status, 0);
  if (WIFEXITED(status)) output.exit_code = WEXITSTATUS(status);
  return output;
}

}  // namespace tactus::test
