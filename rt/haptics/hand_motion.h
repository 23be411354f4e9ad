// How a scripted hand moves between way points: named in a scene, computed by the simulated hand (hal/hand.h).
// Thread: [any].
#pragma once

namespace tactus::haptics {

enum class HandMotion {
  kSmoothStep,  // position, velocity and acceleration continuous; zero velocity at each way point
  kLinear,      // straight line at constant velocity, with a velocity step at each way point
  kCubic,       // through each way point with its given velocity: position and velocity continuous (Hermite)
};

}  // namespace tactus::haptics
