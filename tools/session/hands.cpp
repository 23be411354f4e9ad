#include "tools/session/hands.h"

#include <fmt/format.h>

namespace tactus::session {

std::filesystem::path file_of_hand(const std::filesystem::path& path, unsigned hand) {
  if (hand == 0 || path.empty()) return path;
  std::filesystem::path own = path;
  return own.replace_extension(fmt::format("{}{}", hand + 1, path.extension().string()));
}

Result<Hands> Hands::create(const sim::Scene& scene, std::vector<RunOptions> options, std::vector<Hardware> hardware) {
  if (options.size() != scene.hands() || hardware.size() != scene.hands())
    return Status::error(fmt::format("{}: {} devices for {} hands ([[proxy]]); accepted: as many devices as hands",
                                     scene.name, options.size(), scene.hands()));
  Hands result;
  for (unsigned hand = 0; hand < scene.hands(); ++hand) {
    options[hand].hand = hand;
    auto session =
        Session::create_hand(sim::scene_of_hand(scene, hand), std::move(options[hand]), std::move(hardware[hand]));
    if (!session.ok() && scene.hands() == 1) return session.status();
    if (!session.ok()) return Status::error(fmt::format("hand {}: {}", hand + 1, session.message()));
    result.hands_.push_back(std::move(session).value());
  }
  if (const Status status = Session::share_world(result.sessions()); !status.ok()) return status;
  return result;
}

// The first session's scene is the world's: it goes last.
Hands::~Hands() {
  while (!hands_.empty()) hands_.pop_back();
}

std::vector<Session*> Hands::sessions() {
  std::vector<Session*> sessions;
  for (const auto& hand : hands_) sessions.push_back(hand.get());
  return sessions;
}

Status Hands::record(const std::filesystem::path& tape) {
  for (unsigned hand = 0; hand < count(); ++hand) {
    const std::filesystem::path own = file_of_hand(tape, hand);
    hands_[hand]->options.record = own;
    if (const Status status = hands_[hand]->record(own.string()); !status.ok()) return status;
  }
  return Status::good();
}

}  // namespace tactus::session
