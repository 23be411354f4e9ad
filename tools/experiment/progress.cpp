#include "tools/experiment/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <memory>

namespace tactus::experiment {

Progress terminal_progress() {
  if (isatty(STDERR_FILENO) == 0) return {};
  const std::shared_ptr<void> cleaner(nullptr, [](void*) { fmt::print(stderr, "\r\033[K"); });
  return [cleaner](const std::string& doing) {
    fmt::print(stderr, "\r\033[K{}", doing);
    std::fflush(stderr);
  };
}

void Pace::say(const std::string& doing, double done) const {
  if (!progress_) return;
  const double elapsed_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  progress_(done > 0 ? fmt::format("{}, about {:.0f} s left", doing, std::max(0.0, elapsed_s * (work_ / done - 1)))
                     : doing);
}

}  // namespace tactus::experiment
