// The signals that end a run as it ends by itself: force faded, device in IDLE. Thread: [setup]; g_stop: [any].
#pragma once

#include <atomic>
#include <csignal>

namespace tactus::tools {

inline std::atomic<bool> g_stop{false};  // set by a signal, after stop_on_signals()

// SIGINT, SIGTERM, and SIGHUP, the end of the terminal: a Falcon whose host dies keeps its last force. Where SIGHUP is
// ignored, as under nohup, it stays so.
inline void stop_on_signals() {
  const auto handler = [](int) { g_stop.store(true); };
  std::signal(SIGINT, handler);
  std::signal(SIGTERM, handler);
  if (std::signal(SIGHUP, handler) == SIG_IGN) std::signal(SIGHUP, SIG_IGN);
}

}  // namespace tactus::tools
