// A run with several hands: a session for each, on one global world.
//
// Each hand has its device, loop, governor, faults and tape; a fault of one takes no force from the others. What one
// does reaches the others through the global world: after one to two of its steps (1.5 in the mean). Which sub-world a
// body belongs to: sim/global_world_devices.cpp.
// Thread: as Session, hand by hand.
#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "tools/session/session.h"

namespace tactus::session {

// Name of a hand's file: "my.tape" of the first, "my.2.tape" of the second.
std::filesystem::path file_of_hand(const std::filesystem::path& path, unsigned hand);

class Hands {
 public:
  // `options`, `hardware`: one for each hand of the scene; the options of the world are those of the first. Error, one
  // line: as Session::create, with the hand before it if there are several, or a number of them that is not the
  // scene's.
  static Result<Hands> create(const sim::Scene& scene, std::vector<RunOptions> options, std::vector<Hardware> hardware);
  Hands(Hands&&) = default;
  Hands& operator=(Hands&&) = default;
  ~Hands();

  unsigned count() const noexcept { return static_cast<unsigned>(hands_.size()); }
  Session& operator[](unsigned hand) noexcept { return *hands_[hand]; }
  const Session& operator[](unsigned hand) const noexcept { return *hands_[hand]; }
  sim::GlobalWorld& world() noexcept { return *hands_.front()->global; }
  std::vector<Session*> sessions();

  // As Session::record, with a tape for each hand; empty: history only.
  Status record(const std::filesystem::path& tape);

 private:
  Hands() = default;
  std::vector<std::unique_ptr<Session>> hands_;
};

}  // namespace tactus::session
