// Runs the parts of an experiment in other processes: on this machine (--workers), or on a scheduler of Dask
// distributed (--scheduler). A part is this program's own command with --part K, which prints the part's result as
// bytes (experiment/part_bytes.h); the sweep's Python module runs them. Thread: [setup].
#pragma once

#include <string>
#include <vector>

#include "tools/experiment/part_bytes.h"
#include "tools/tactus/experiment_output.h"

namespace CLI {
class App;
}

namespace tactus::tools {

struct PartOptions {
  unsigned workers{0};
  std::string scheduler;
  bool trust_network{false};
  int part{-1};  // 0 or more: print the result of this part, nothing else

  void add(CLI::App& command);
  bool elsewhere() const { return workers > 0 || !scheduler.empty(); }
};

struct PartWork {
  std::vector<std::string> arguments;  // of this program, for the parts, experiment NAME first; --part K is added
  std::size_t count{0};
  std::vector<std::string> scenes;  // paths of the scene files that the parts read
};

// Returns the parts' results, in order. The parts that are done are kept in this folder until all are, and are not done
// again by the same command: as long as the program, the arguments, and the scenes with the files that they name are
// the same. Error, one line: a part failed. An interruption (Ctrl-C, SIGTERM, SIGHUP) ends the workers at once, says
// that what is done is kept, and ends the program with status 1, as it ends `tactus sweep`.
Result<std::vector<std::string>> run_parts(const PartOptions& options, const PartWork& work);

// Same, as values.
template <class T>
Result<std::vector<T>> parts_of(const PartOptions& options, const PartWork& work) {
  auto bytes = run_parts(options, work);
  if (!bytes.ok()) return bytes.status();
  std::vector<T> parts;
  for (const std::string& one : bytes.value()) {
    auto part = experiment::from_part_bytes<T>(one);
    if (!part.ok()) return part.status();
    parts.push_back(std::move(part).value());
  }
  return parts;
}

// --- inside
int print_part_bytes(const std::string& bytes);
int no_such_part(const std::string& experiment, std::size_t count);

// Prints the result of part options.part of `count`. Returns the exit status; an error is reported.
template <class Compute>
int print_part(const PartOptions& options, const std::string& experiment, std::size_t count, Compute&& compute) {
  const auto part = static_cast<std::size_t>(options.part);
  if (part >= count) return no_such_part(experiment, count);
  auto result = compute(part);
  if (!result.ok()) return experiment_failed(experiment, result.message());
  return print_part_bytes(experiment::to_part_bytes(std::move(result).value()));
}

}  // namespace tactus::tools
