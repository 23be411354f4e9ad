// What took a core away from the thread that should run there, as the kernel itself measures it: each interrupt, soft
// interrupt and other thread with its name, when it began and for how long, from the osnoise events of the kernel's
// tracer, for one core.
//
// The events come while one of the tracers `osnoise` and `timerlat` is on. Where the kernel can leave their own thread
// out (osnoise/options), it does; else timerlat is used, whose thread then wakes once a second on the core, above the
// loop. A trace instance of our own is made and taken away again; the two settings that all instances share are put
// back. Thread: one, normal. Needs tracefs and the right to write there (root). Units in the names; times are
// MonotonicClock's, to a microsecond. Source: Linux, Documentation/trace/osnoise-tracer.rst, timerlat-tracer.rst.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "rt/base/result.h"

namespace tactus::timing {

struct Noise {
  enum class Kind { kInterrupt, kThread };  // interrupts of all sorts; another thread
  Kind kind{Kind::kInterrupt};
  std::string name;
  std::int64_t number{0};  // a thread's id, an interrupt's vector
  std::int64_t from_ns{0}, duration_ns{0};
};

// A line of the trace; nothing where it is no such event.
std::optional<Noise> parse_noise(const std::string& line);

class OsNoise {
 public:
  // What is wrong, in one line, where this kernel or this user cannot.
  static Result<std::unique_ptr<OsNoise>> start(int cpu, const std::string& tracefs = "/sys/kernel/tracing");
  ~OsNoise();
  OsNoise(const OsNoise&) = delete;
  OsNoise& operator=(const OsNoise&) = delete;

  // Since the last call, without the core's idling and without this thread.
  std::vector<Noise> read(int except_thread);

 private:
  OsNoise() = default;
  Status set_up(int cpu, const std::string& tracefs);
  void take(const std::string& line, int except_thread, std::vector<Noise>& into);

  struct Saved {
    std::string file, text;
  };
  std::string instance_;      // our folder; empty until it is made
  std::vector<Saved> saved_;  // as they were
  int pipe_{-1};
  std::string rest_;  // of a line that was read in part
};

}  // namespace tactus::timing
