// Loads the other cores while the loop is timed, by child processes of normal priority; the destructor ends them.
//
//   none      nothing
//   cpu       arithmetic, one process a core
//   memory    streams through memory larger than the caches, one process a core: uses up the bandwidth
//   stress-ng arithmetic, memory, files and context switches by that program, if installed
// The core of the haptic thread is left out, unless it is the only one. Thread: normal; start it before other threads
// exist. Bound: one process a core.
#pragma once

#include <string>
#include <vector>

#include "rt/base/result.h"

namespace tactus::timing {

enum class LoadKind { kNone, kCpu, kMemory, kStressNg };

// Error, one line, for any other word.
Result<LoadKind> parse_load(const std::string& word);

class Load {
 public:
  Load() = default;
  ~Load() { stop(); }
  Load(const Load&) = delete;
  Load& operator=(const Load&) = delete;

  // Starts the load on all cores that this process may use, except `spare_cpu`. Error, one line: the program is missing
  // or no process can be started.
  Status start(LoadKind kind, int spare_cpu);
  void stop() noexcept;
  std::size_t processes() const { return children_.size(); }

 private:
  std::vector<int> children_;  // process ids
};

}  // namespace tactus::timing
