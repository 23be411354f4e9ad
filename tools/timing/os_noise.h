// Reads the osnoise events of the kernel's tracer for one core: each interrupt, soft interrupt and other thread that
// used the core, with name, start and duration.
//
// The events are produced while the tracer `osnoise` or `timerlat` is on. Their own threads are disabled if the kernel
// supports it (osnoise/options); otherwise timerlat is used, whose thread then wakes once a second on the core, with
// priority over the loop. A separate trace instance is created and removed again; the two settings shared by all
// instances are restored. Thread: one, normal. Needs tracefs and the right to write there (root). Units in the names;
// times are
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
  enum class Kind { kInterrupt, kThread };  // interrupts of all kinds; another thread
  Kind kind{Kind::kInterrupt};
  std::string name;
  std::int64_t number{0};  // a thread's id, an interrupt's vector
  std::int64_t from_ns{0}, duration_ns{0};
};

// Parses a line of the trace; empty if it is not such an event.
std::optional<Noise> parse_noise(const std::string& line);

class OsNoise {
 public:
  // Error, one line: why this kernel or this user cannot trace.
  static Result<std::unique_ptr<OsNoise>> start(int cpu, const std::string& tracefs = "/sys/kernel/tracing");
  ~OsNoise();
  OsNoise(const OsNoise&) = delete;
  OsNoise& operator=(const OsNoise&) = delete;

  // Events since the last call, without idle time and without the given thread.
  std::vector<Noise> read(int except_thread);

 private:
  OsNoise() = default;
  Status set_up(int cpu, const std::string& tracefs);
  void take(const std::string& line, int except_thread, std::vector<Noise>& into);

  struct Saved {
    std::string file, text;
  };
  std::string instance_;      // folder of the trace instance; empty until created
  std::vector<Saved> saved_;  // as they were
  int pipe_{-1};
  std::string rest_;  // incomplete last line
};

}  // namespace tactus::timing
