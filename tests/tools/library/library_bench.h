// Sessions for the tests of the library: scenes of the project or of the test, opened through the public headers.
#pragma once

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "tactus/tactus.h"

namespace tactus::test {

// Every coupling, each on a scene that it suits.
inline const std::vector<std::pair<const char*, const char*>> kSceneForCoupling{
    {"card_house.toml", "sub-world"}, {"press.toml", "direct"}, {"stack20.toml", "interpolation"},
    {"wall.toml", "static"},          {"press.toml", "planes"}, {"chain.toml", "sub-world"},
    {"workshop.toml", "sub-world"}};

inline Scene scene_of(const std::string& name) {
  Scene scene;
  const Error error = scene.load(TACTUS_SOURCE_DIR "/sim/scenes/" + name);
  INFO(error.message());
  REQUIRE_FALSE(error);
  return scene;
}

// A step that must work.
inline void step(Session& session, std::uint64_t ticks) {
  const Error error = session.step(ticks);
  INFO(error.message());
  REQUIRE_FALSE(error);
}

inline Session session_of(const Scene& scene, const Options& options = {}) {
  Session session;
  const Error error = session.open(scene, options);
  INFO(error.message());
  REQUIRE_FALSE(error);
  return session;
}

inline double length(const Vector3& v) { return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }

}  // namespace tactus::test
