// Loads a scene and ticks a haptic loop once, with nothing but what is installed.
#include <cstdio>

#include "rt/loop/haptic_loop.h"
#include "sim/loader/scene_load.h"

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const auto scene = tactus::sim::load_scene(argv[1]);
  if (!scene.ok()) {
    std::fprintf(stderr, "%s\n", scene.message().c_str());
    return 1;
  }
  tactus::loop::LoopConfig config;
  config.sub_world.scheme = tactus::haptics::CouplingScheme::kDirect;
  config.sub_world.proxy = scene.value().proxy;
  config.sub_world.step.dt = config.period_s;
  config.sub_world.capacities = {.bodies = 64, .fixed_bodies = 8, .pairs = 512, .contacts = 256, .border_contacts = 4};
  tactus::loop::HapticLoop loop(config, {});
  tactus::loop::TickInput in;
  tactus::loop::TickOutput out;
  loop.tick(in, out);
  std::printf("%zu bodies, one tick\n", scene.value().bodies.size());
  return 0;
}
