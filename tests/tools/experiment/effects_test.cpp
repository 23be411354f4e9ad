#include "tools/experiment/effects.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "sim/loader/scene_load.h"
#include "sim/loader/scene_report.h"
#include "sim/model/scene_effects.h"

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

TEST_CASE("What an effect costs is shown where it is above the spread of its measurement, and else the spread") {
  sim::SceneReport report;
  report.effects = {{"joints", true, true, "rows", 5.8, 16, 0.3}, {"rolling", true, true, "rows", -0.07, 16, 0.2}};
  const std::string text = sim::to_text(report);
  CHECK(text.find("measured: 5.8 us of 16 us") != std::string::npos);
  CHECK(text.find("measured: below the measurement's spread of 0.2 us, of 16 us") != std::string::npos);
  CHECK(text.find("-0.07") == std::string::npos);
  const auto scene = sim::parse_scene(effect_scene("rolling", EffectState::kUsed), "rolling");
  REQUIRE(scene.ok());
  for (const EffectTime& time : time_effects(scene.value())) CHECK(time.spread_us >= 0);
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
