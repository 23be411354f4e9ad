// What keeps the other cores busy while the loop is timed: child processes of normal priority, gone with the object.
//
//   none      nothing
//   cpu       arithmetic, one process a core
//   memory    streams through memory larger than the caches, one process a core: takes the bandwidth away
//   stress-ng arithmetic, memory, files and context switches by that program, where it is installed
// The core of the haptic thread is left out, unless it is the only one. Thread: normal; start it before other threads
// are there. Bound: one process a core.
#pragma once

#include <string>
#include <vector>

#include "rt/base/result.h"

namespace tactus::timing {

enum class LoadKind { kNone, kCpu, kMemory, kStressNg };

// One line on anything else.
Result<LoadKind> parse_load(const std::string& word);

class Load {
 public:
  Load() = default;
  ~Load() { stop(); }
  Load(const Load&) = delete;
  Load& operator=(const Load&) = delete;

  // On all cores that this process may use but `spare_cpu`. One line where the program is missing or no process is to
  // be had.
  Status start(LoadKind kind, int spare_cpu);
  void stop() noexcept;
  std::size_t processes() const { return children_.size(); }

 private:
  std::vector<int> children_;  // process ids
};

// The cores that this process may use, without `spare_cpu` where another is left.
std::vector<int> cores_without(int spare_cpu);

}  // namespace tactus::timing
