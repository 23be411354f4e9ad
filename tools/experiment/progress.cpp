#include "tools/experiment/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <memory>

namespace tactus::experiment {

namespace {

// Limits the number of lines in a log.
constexpr std::chrono::seconds kBetweenLines{30};

}  // namespace

Progress terminal_progress() {
  if (isatty(STDERR_FILENO) == 0)
    return [last = std::chrono::steady_clock::now()](const std::string& doing) mutable {
      const auto now = std::chrono::steady_clock::now();
      if (now - last < kBetweenLines) return;
      last = now;
      fmt::print(stderr, "{}\n", doing);
    };
  const std::shared_ptr<void> cleaner(nullptr, [](void*) { fmt::print(stderr, "\r\033[K"); });
  return [cleaner](const std::string& doing) {
    fmt::print(stderr, "\r\033[K{}", doing);
    std::fflush(stderr);
  };
}

void WorkProgress::say(const std::string& doing, double done) const {
  if (!progress_) return;
  const double elapsed_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  progress_(done > 0 ? fmt::format("{}, about {:.0f} s left", doing, std::max(0.0, elapsed_s * (work_ / done - 1)))
                     : doing);
}

}  // namespace tactus::experiment
