// tactus experiment effects: cost of an effect in a tick when it is not declared, declared but not used, and used.
//
// Each effect is measured on the same scene in these three states. Instructions are counted by callgrind, which runs
// this program again, once per row and state, and counts some ticks of the haptic thread's world. Sleeping exists only
// in the global world, so its three counts are equal. Also measures the time that the effects of a given scene take,
// for `tactus scene check`. Thread: one, on one core. Units in the names.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "sim/model/scene.h"
#include "tools/experiment/progress.h"

namespace tactus::experiment {

enum class EffectState : std::uint32_t { kOff = 0, kUnused = 1, kUsed = 2 };

struct EffectRow {
  std::string effect;
  std::array<double, 3> instructions{};  // a tick, by state; 0: not counted
  // Not declared and not used must cost the same.
  bool good() const noexcept;
};

// Names of all effects.
std::vector<std::string> effect_names();
// The scene of a row, as text.
std::string effect_scene(const std::string& effect, EffectState state);

// `program`: this program's own path. Without valgrind nothing is counted.
std::vector<EffectRow> run_effects(const std::vector<std::string>& effects, const std::string& program,
                                   const Progress& progress);
// Runs under valgrind: some ticks to settle, then the counted ones.
void count_effect(const std::string& effect, EffectState state);

std::string effects_table(const std::vector<EffectRow>& rows);
std::string effects_json(const std::vector<EffectRow>& rows);

// Time that an effect used by the scene adds to a tick of all bodies [us, CPU time]: median of ticks with it minus
// median of ticks without it, measured alternately. Empty for a scene that is too large to measure. Spread: half the
// range of the results of six parts of the measurement; a smaller difference is not significant.
struct EffectTime {
  std::string effect;
  double added_us{0}, spread_us{0}, tick_us{0};
};
std::vector<EffectTime> time_effects(const sim::Scene& scene);

}  // namespace tactus::experiment
