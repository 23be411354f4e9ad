// tactus experiment effects: what an effect costs a tick that does not call for it, one that calls for it in vain, and
// one that uses it.
//
// The same scene three times for each effect: not declared; declared, with nothing that uses it; used. Instructions are
// counted by callgrind, which runs this program again, once a row and state, and counts some ticks of the world that
// the haptic thread would have. Sleeping is the global world's alone, so its three counts are the same there. And what
// the effects of a given scene cost in time, for `tactus scene check`. Thread: one, on one core. Units in the names.
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

// One for every effect that there is.
std::vector<std::string> effect_names();
// The scene of a row, as text.
std::string effect_scene(const std::string& effect, EffectState state);

// `program`: this program's own path. Nothing is counted where valgrind is missing.
std::vector<EffectRow> run_effects(const std::vector<std::string>& effects, const std::string& program,
                                   const Progress& progress);
// What runs under valgrind: some ticks to settle, then those that are counted.
void count_effect(const std::string& effect, EffectState state);

std::string effects_table(const std::vector<EffectRow>& rows);
std::string effects_json(const std::vector<EffectRow>& rows);

// What an effect that the scene uses adds to a tick of all its bodies [us, CPU time]: the median of ticks with it less
// that of ticks without it, in turns. Empty for a scene that is too large to try. Spread: half the range of what six
// parts of the measurement find, each by itself; a difference below it says nothing.
struct EffectTime {
  std::string effect;
  double added_us{0}, spread_us{0}, tick_us{0};
};
std::vector<EffectTime> time_effects(const sim::Scene& scene);

}  // namespace tactus::experiment
