// Any bytes as a scene: the loader refuses or accepts them, and what it accepts is a scene that the world can hold.
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "rt/base/check.h"
#include "sim/loader/scene_load.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tactus;
  text::Diagnostics diagnostics;
  const auto scene = sim::parse_scene({reinterpret_cast<const char*>(data), size}, "scenes/fuzz.toml", &diagnostics);
  TACTUS_CHECK(scene.ok() == diagnostics.ok(), scene.ok(), diagnostics.mistakes.size());
  if (!scene.ok()) {
    TACTUS_CHECK(!scene.message().empty(), 0, 0);
    return 0;
  }
  const auto& bodies = scene.value().bodies;
  TACTUS_CHECK(bodies.size() <= sim::kMaxSceneBodies, bodies.size(), sim::kMaxSceneBodies);
  TACTUS_CHECK(scene.value().proxy < bodies.size(), scene.value().proxy, bodies.size());
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const auto& body = bodies[i];
    TACTUS_CHECK(body.id == i, body.id, i);
    TACTUS_CHECK(is_finite(body.motion.pose) && is_finite(body.motion.velocity), i, 0);
    const bool moves = body.kind == physics::BodyKind::kDynamic;
    TACTUS_CHECK(!moves || (body.mass > 0 && body.inertia.x > 0 && body.inertia.y > 0 && body.inertia.z > 0), i,
                 body.mass);
  }
  TACTUS_CHECK(!scene.value().hand.path.empty(), 0, 0);
  return 0;
}
