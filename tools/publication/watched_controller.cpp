#include "tools/publication/watched_controller.h"

#include <sys/socket.h>
#include <unistd.h>

#include "sim/loader/scene_load.h"
#include "tools/service/control_server.h"

namespace tactus::publication {

Result<std::unique_ptr<WatchedController>> WatchedController::open(const std::filesystem::path& socket) {
  const auto run = service::watch_control(socket);
  if (!run.ok()) return run.status();
  std::unique_ptr<WatchedController> controller(new WatchedController(run.value().connection));
  auto watcher = Watcher::open(run.value().memory);
  if (!watcher.ok()) return watcher.status();
  controller->watcher_ = std::move(watcher).value();
  auto settings = session::from_tape_text(controller->watcher_->text());
  if (!settings.ok()) return settings.status();
  controller->settings_ = std::move(settings).value();
  auto scene = sim::parse_scene(controller->settings_.scene_source, controller->settings_.scene_name);
  if (!scene.ok()) return Status::error("the run's scene: " + scene.message());
  const session::RunOptions& options = controller->settings_.options;
  if (options.hands != scene.value().hands()) return Status::error("the run's scene has other hands than the run");
  controller->scene_ = sim::scene_of_hand(std::move(scene).value(), options.hand);
  return controller;
}

WatchedController::~WatchedController() { close(connection_); }

bool WatchedController::ended() const {
  char byte = 0;
  // The controller's end of the connection closes even if the controller is killed.
  const bool left = recv(connection_, &byte, 1, MSG_PEEK | MSG_DONTWAIT) == 0;
  return left || watcher_->ended();
}

}  // namespace tactus::publication
