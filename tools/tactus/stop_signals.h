// The signals that end a run as it ends by itself: force faded, device in IDLE. Thread: [setup].
#pragma once

#include <csignal>

namespace tactus::tools {

// SIGINT, SIGTERM, and SIGHUP, the end of the terminal: a Falcon whose host dies keeps its last force. Where SIGHUP is
// ignored, as under nohup, it stays so.
inline void stop_on_signals(void (*handler)(int)) {
  std::signal(SIGINT, handler);
  std::signal(SIGTERM, handler);
  if (std::signal(SIGHUP, handler) == SIG_IGN) std::signal(SIGHUP, SIG_IGN);
}

}  // namespace tactus::tools
