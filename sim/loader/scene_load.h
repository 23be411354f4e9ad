// Loads a scene from its TOML text and reports all mistakes in one pass.
//
// Every mistake has its line and column, the key, what was found and what is accepted. A mistake never hides the next
// one, except if the text is not TOML. A scene with warnings only (an effect declared but not used, a card house that
// cannot stand) is accepted. Units: SI, in the key names. Frame: world, z up.
// Thread: [setup]. Bound: the limits below; beyond them the scene is rejected with a mistake like any other.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "rt/base/result.h"
#include "rt/text/diagnostics.h"
#include "rt/text/toml.h"
#include "sim/model/scene.h"

namespace tactus::sim {

inline constexpr std::size_t kMaxSceneBytes = text::kMaxTomlBytes;
inline constexpr unsigned kMaxSceneBodies = 100'000;
inline constexpr unsigned kMaxWaypoints = 10'000;

// The scene, or an error whose message is that of the diagnostics. `diagnostics`, when given, is filled in any case.
Result<Scene> parse_scene(std::string_view text, std::string_view name, text::Diagnostics* diagnostics = nullptr);
Result<Scene> load_scene(const std::filesystem::path& path, text::Diagnostics* diagnostics = nullptr);

// The keys that the loader requests for this text, in order, each key of a table once: see scene_keys.h.
std::vector<text::AskedKey> asked_keys(std::string_view text);

// Hash of a scene's text with its files' data (Scene::source): FNV-1a, 64 bit, 16 hexadecimal digits.
std::string source_hash(std::string_view source);

// The highest contact frequency that both worlds solve accurately: 0.25 / h for the longer of their sub-steps [Hz].
// The global step of r ticks has r x global_sub_steps_per_tick sub-steps, so its sub-step does not depend on r.
double max_contact_hertz(const SolverChoice& solver, double tick_s) noexcept;

}  // namespace tactus::sim
