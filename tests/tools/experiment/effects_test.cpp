#include "tools/experiment/effects.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "sim/loader/scene_effects.h"
#include "sim/loader/scene_load.h"

using namespace tactus;
using namespace tactus::experiment;

TEST_CASE("The scenes of experiment effects are good, and declare and use their effect as they say") {
  for (const auto& name : effect_names()) {
    const auto* effect = sim::find_effect(name);
    REQUIRE(effect != nullptr);
    for (const EffectState state : {EffectState::kOff, EffectState::kUnused, EffectState::kUsed}) {
      const auto scene = sim::parse_scene(effect_scene(name, state), name);
      INFO(name << " " << static_cast<int>(state) << ": " << scene.message());
      REQUIRE(scene.ok());
      CHECK(scene.value().effects.*effect->declared == (state != EffectState::kOff));
      // Sleep needs time, and collision of the proxy is there for as long as there is something to meet.
      if (name != "sleeping" && name != "ccd")
        CHECK(sim::is_in_use(scene.value(), *effect) == (state == EffectState::kUsed));
    }
  }
}

TEST_CASE("A row is good where an effect that is not used costs at most 0.1 %") {
  CHECK(EffectRow{"joints", {1e6, 1.0009e6, 2e6}}.good());
  CHECK_FALSE(EffectRow{"joints", {1e6, 1.0011e6, 2e6}}.good());
  const auto json = nlohmann::json::parse(effects_json({{"joints", {1, 2, 3}}}));
  CHECK(json["rows"][0]["effect"] == "joints");
  CHECK(json["rows"][0]["instructions_off"] == 1);
  CHECK(json["rows"][0]["instructions_unused"] == 2);
  CHECK(json["rows"][0]["instructions_used"] == 3);
}
