#include "sim/model/scene.h"

#include <algorithm>
#include <utility>

#include "rt/base/check.h"

namespace tactus::sim {

unsigned Scene::moving_bodies() const noexcept {
  return static_cast<unsigned>(std::count_if(
      bodies.begin(), bodies.end(), [](const physics::Body& body) { return body.kind != physics::BodyKind::kFixed; }));
}

Scene scene_of_hand(Scene scene, unsigned hand) {
  TACTUS_CHECK(hand < scene.hands(), hand, scene.hands());
  if (hand == 0) return scene;
  HandPart& other = scene.more_hands[hand - 1];
  std::swap(scene.proxy, other.proxy);
  std::swap(scene.device, other.device);
  std::swap(scene.coupling, other.coupling);
  std::swap(scene.hand, other.hand);
  return scene;
}

}  // namespace tactus::sim
