// Parts that the bench's simulated devices share: the scene's hand, and commands from a FIFO.
//
// Thread: [setup]; ControlLines::next() the control period's: at most a line's bytes, no wait. A mistake ends the
// program with status 2 and one line.
#pragma once

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "firmware/boards/linux/linux_program.h"
#include "hal/hand.h"
#include "sim/loader/scene_load.h"

namespace tactus::vm {

[[noreturn]] inline void fail(const std::string& message) {
  std::fprintf(stderr, "bench: %s\n", message.c_str());
  std::exit(2);
}

// Stores the value of an option.
using TakeValue = std::function<void(const char* value)>;
inline TakeValue into(std::string& text) {
  return [&text](const char* value) { text = value; };
}
template <class Number>
TakeValue into(Number& number) {
  return [&number](const char* value) { number = static_cast<Number>(std::atoi(value)); };
}
// Takes the pairs OPTION VALUE from argv[first] on.
inline void read_pairs(int argc, char** argv, int first, const std::map<std::string_view, TakeValue>& options) {
  for (int i = first; i + 1 < argc; i += 2) {
    const auto option = options.find(argv[i]);
    if (option == options.end()) fail("unknown option " + std::string(argv[i]));
    option->second(argv[i + 1]);
  }
}

// Makes this thread real-time, prints "ready", and calls bench.run() until a signal or the line `quit`.
template <class Bench>
int serve(Bench& bench, int priority) {
  if (const std::string refused = firmware::make_realtime(priority, -1); !refused.empty()) fail(refused);
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  std::printf("ready\n");
  bench.run(firmware::stop_on_signals());
  return 0;
}

inline sim::Scene read_scene(const std::string& file) {
  auto scene = sim::load_scene(file);
  if (!scene.ok()) fail(scene.message());
  return std::move(scene).value();
}

// The scene says where the hand goes in the world; the device wants it in its own frame.
inline hal::HandModel hand_of(const sim::Scene& scene, bool still) {
  const Posed device_from_world = inverse(scene.device.world_from_device);
  std::vector<hal::HandWaypoint> path;
  for (const sim::ScriptWaypoint& point : scene.hand.path) {
    const Quatd turn = device_from_world.rotation * quat_from_rotation_vector(point.rotation_vector_rad);
    path.push_back({point.time_s, (device_from_world * point.position_m) * (1.0 / scene.device.motion_scale),
                    hal::rotation_vector_of(turn)});
  }
  if (still) path.resize(std::min<std::size_t>(path.size(), 1));
  hal::HandParameters parameters;
  parameters.stiffness_N_per_m = scene.hand.stiffness_N_per_m;
  parameters.damping_Ns_per_m = scene.hand.damping_Ns_per_m;
  parameters.mass_kg = scene.hand.mass_kg;
  parameters.stiffness_Nm_per_rad = scene.hand.stiffness_Nm_per_rad;
  parameters.damping_Nms_per_rad = scene.hand.damping_Nms_per_rad;
  parameters.repeat = scene.hand.repeat;
  return hal::HandModel(parameters, path);
}

// Lines from the FIFO as they come; never waits.
class ControlLines {
 public:
  explicit ControlLines(const std::string& fifo) {
    // Both directions, so that a writer that closes it is not an end of file.
    if (!fifo.empty() && (file_ = open(fifo.c_str(), O_RDWR | O_NONBLOCK)) < 0) fail("cannot open " + fifo);
  }
  bool next(std::string& line) {
    char byte;
    while (file_ >= 0 && read(file_, &byte, 1) == 1) {
      if (byte == '\n') {
        line = std::exchange(partial_, {});
        return true;
      }
      partial_ += byte;
    }
    return false;
  }

 private:
  int file_{-1};
  std::string partial_;
};

}  // namespace tactus::vm
