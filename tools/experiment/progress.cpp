#include "tools/experiment/progress.h"

#include <fmt/format.h>
#include <unistd.h>

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

}  // namespace tactus::experiment
