#include "tools/tactus/timed_viewer.h"

#include <chrono>
#include <thread>

#include "tools/experiment/shared_files.h"
#include "tools/view/server.h"

namespace tactus::tools {

Status TimedViewer::open() {
  const auto files = view::load_files(experiment::shared_file("view"));
  if (!files.ok()) return files.status();
  auto folder = PrivateFolder::make();
  if (!folder.ok()) return folder.status();
  folder_ = std::move(folder).value();
  return Status::good();
}

timing::WindowWatcher TimedViewer::watcher() {
  if (folder_ == nullptr) return {};
  return {.prepare = [this](session::Session& session) { return prepare(session); },
          .attach = [this] { return attach(); },
          .detach = [this] { detach(); },
          .counts = [this] { return counts(); }};
}

Result<session::RealtimeTaps> TimedViewer::prepare(session::Session& session) {
  shown_ = ShownRun::make(session);
  if (shown_ == nullptr) return Status::error("the system has no memory to watch the run in");
  service::Watchable watchable;
  shown_->add_to(watchable);
  auto control = service::ControlServer::open(folder_->path() / "control", requests_, stop_, {},
                                              session.global != nullptr, watchable);
  if (!control.ok()) return control.status();
  control_ = std::move(control).value();
  session::RealtimeTaps taps;
  taps.stepped = &ShownRun::stepped;
  taps.context = shown_.get();
  return taps;
}

Status TimedViewer::attach() {
  auto viewer = ViewerProcess::start_silent(folder_->path() / "control");
  if (!viewer.ok()) return viewer.status();
  viewer_ = std::move(viewer).value();
  auto page = view::PageClient::open(viewer_->address());
  if (!page.ok()) return page.status();
  page_ = std::move(page).value();
  return Status::good();
}

void TimedViewer::detach() {
  if (page_ != nullptr) taken_ += page_->frames();
  page_.reset();
  viewer_.reset();
  constexpr int kTries = 100;  // of 10 ms, until the control socket has noticed that the viewer left
  for (int i = 0; i < kTries && shown_->watchers() != 0; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
}

timing::WindowWatcher::Counts TimedViewer::counts() const {
  return {.frames = taken_ + (page_ != nullptr ? page_->frames() : 0), .watchers = shown_->watchers()};
}

}  // namespace tactus::tools
