// A running controller, watched through its shared memory; what pages ask for goes over its control socket.
//
// The tape of a fault, which the run writes while it is watched, is served beside by a viewer of its own.
// The viewer has none of the run's privileges. Thread: one, the server's. Bound: as of the watcher; a request waits for
// the run's answer.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "tools/publication/watched_controller.h"
#include "tools/view/fault_viewer.h"
#include "tools/view/view_source.h"

namespace tactus::view {

class LiveSource final : public ViewSource {
 public:
  // Watches the run behind this socket. Error: of WatchedController::open.
  static Result<std::unique_ptr<LiveSource>> open(const std::filesystem::path& socket);
  // From now on a fault's tape is served, with these files.
  void show_faults(std::map<std::string, std::string> files) { fault_viewer_.emplace(std::move(files)); }

  std::string hand() const override;
  const std::string& scene(std::size_t) const override { return scene_; }
  Update look(std::size_t view, std::vector<publication::TickEntry>& ticks, publication::Frame& frame) override;
  bool ended() override { return controller_->ended(); }
  std::string status() override;
  Answer ask(const PageMessage& message) override;
  bool real_device() const override { return real_device_; }

 private:
  LiveSource(std::filesystem::path socket, std::unique_ptr<publication::WatchedController> controller);

  Answer request(const std::string& line) const;
  Answer lead(const PageMessage& message) const;

  std::filesystem::path socket_;
  std::unique_ptr<publication::WatchedController> controller_;
  std::string scene_, state_;  // as the run says it
  std::uint64_t faults_{0};
  bool real_device_;
  std::uint64_t hand_id_;  // identifies this viewer when it requests the hand
  std::optional<FaultViewer> fault_viewer_;
};

}  // namespace tactus::view
