#include "sim/model/scene.h"

#include <utility>

#include "rt/base/check.h"

namespace tactus::sim {

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
