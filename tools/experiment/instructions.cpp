#include "tools/experiment/instructions.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>

#if __has_include(<valgrind/callgrind.h>)
#include <valgrind/callgrind.h>
#define TACTUS_COUNTS_INSTRUCTIONS 1
#else
#define CALLGRIND_START_INSTRUMENTATION
#define CALLGRIND_STOP_INSTRUMENTATION
#define TACTUS_COUNTS_INSTRUCTIONS 0
#endif

namespace tactus::experiment {

bool can_count_instructions() {
  return TACTUS_COUNTS_INSTRUCTIONS != 0 && std::system("command -v valgrind >/dev/null 2>&1") == 0;
}

void start_counting() noexcept { CALLGRIND_START_INSTRUMENTATION; }

void stop_counting() noexcept { CALLGRIND_STOP_INSTRUMENTATION; }

double counted_instructions(const std::string& program, const std::string& arguments) {
  const std::string out = fmt::format("/tmp/tactus-callgrind.{}", getpid());
  const std::string command =
      fmt::format("valgrind --tool=callgrind --callgrind-out-file={} --instr-atstart=no '{}' {} >/dev/null 2>&1", out,
                  program, arguments);
  if (std::system(command.c_str()) != 0) return 0;
  std::ifstream file(out);
  double instructions = 0;
  for (std::string line; std::getline(file, line);)
    if (line.starts_with("summary:") || line.starts_with("totals:"))
      instructions = std::strtod(line.c_str() + line.find(':') + 1, nullptr);
  std::remove(out.c_str());
  return instructions;
}

}  // namespace tactus::experiment
