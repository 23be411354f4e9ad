// A running controller that is watched: the connection that keeps it watched, its shared memory, and its scene.
//
// Thread: one. Bound: as of the watcher; opening waits for the controller's answer (service::watch_control).
#pragma once

#include <filesystem>
#include <memory>

#include "sim/model/scene.h"
#include "tools/publication/watcher.h"
#include "tools/session/run_options.h"

namespace tactus::publication {

class WatchedController {
 public:
  // Watches the run behind this socket, until the end of this object. Error, one line: no run answers, it refuses,
  // another version's, or its scene cannot be read.
  static Result<std::unique_ptr<WatchedController>> open(const std::filesystem::path& socket);
  ~WatchedController();
  WatchedController(const WatchedController&) = delete;
  WatchedController& operator=(const WatchedController&) = delete;

  Watcher& watcher() noexcept { return *watcher_; }
  const session::TapeSettings& settings() const noexcept { return settings_; }
  const sim::Scene& scene() const noexcept { return scene_; }
  // The run is over, or its process is gone: nothing new will come.
  bool ended() const;

 private:
  explicit WatchedController(int connection) noexcept : connection_(connection) {}

  int connection_;
  std::unique_ptr<Watcher> watcher_;
  session::TapeSettings settings_;
  sim::Scene scene_;
};

}  // namespace tactus::publication
