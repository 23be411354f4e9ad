// The viewer of `tactus timing --with-viewer`: `tactus view` as a process of its own, with a page that takes every
// frame it is sent and draws nothing.
//
// Thread: open: main; prepare: the one that starts the run; attach, detach, counts: the one that samples the machine.
// Bound: a viewer that has no address within 10 s, or no end within 1 s, is an error, or is killed.
#pragma once

#include <atomic>
#include <memory>

#include "tools/private_folder.h"
#include "tools/service/control_server.h"
#include "tools/tactus/shown_run.h"
#include "tools/tactus/viewer_process.h"
#include "tools/timing/watched_windows.h"
#include "tools/view/page_client.h"

namespace tactus::tools {

class TimedViewer {
 public:
  // Before the run. Error: this build has no page, or no folder for a socket can be made.
  Status open();
  // Empty without open(). Of this object, which must outlive it.
  timing::WindowWatcher watcher();

 private:
  Result<session::RealtimeTaps> prepare(session::Session& session);
  Status attach();
  void detach();
  timing::WindowWatcher::Counts counts() const;

  std::unique_ptr<PrivateFolder> folder_;
  std::atomic<std::uint32_t> requests_{0};  // written by the control server, not read here
  std::atomic<bool> stop_{false};
  std::shared_ptr<ShownRun> shown_;
  std::unique_ptr<service::ControlServer> control_;
  std::uint64_t taken_{0};  // by pages that have left
  std::unique_ptr<ViewerProcess> viewer_;
  std::unique_ptr<view::PageClient> page_;
};

}  // namespace tactus::tools
