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
#include "sim/model/scene.h"

namespace tactus::sim {

inline constexpr std::size_t kMaxSceneBytes = 4u << 20;
inline constexpr unsigned kMaxSceneBodies = 100'000;
inline constexpr unsigned kMaxWaypoints = 10'000;
inline constexpr std::size_t kMaxReportedMistakes = 100;  // more are counted, not listed

struct Mistake {
  unsigned line{0}, column{0};  // from 1; 0 if it has no position in the text
  std::string where;            // "[body.3] mass_kg": tables of an array count from 1, in the order of the file
  std::string what;             // what was found
  std::string accepted;         // what is accepted
};

// A key that the loader requested from a table, present or not: from these the scene language is documented.
struct AskedKey {
  enum class Type { kUnknown, kNumber, kCount, kSeed, kFlag, kText, kWord, kVector, kTable, kArray };
  std::string table{};  // "[simulation]", "[[body]]", "[hand] path"; empty: the file's own keys
  std::string key{};    // "mass_kg"
  Type type{Type::kUnknown};
  std::string fallback{};  // the default, in the file's syntax; empty: none
  double low{0}, high{0};  // range of a number, a count, each component of a vector; high: entries of an array
  std::vector<std::string> words{};  // accepted words
  bool required{false};
};

struct SceneDiagnostics {
  std::string name;                       // of the file, as given
  std::vector<Mistake> mistakes;          // by line and column
  std::vector<Mistake> warnings;          // same
  std::size_t left_out{0};                // mistakes beyond kMaxReportedMistakes
  std::vector<AskedKey>* asked{nullptr};  // receives the requested keys; null: not recorded

  bool ok() const noexcept { return mistakes.empty(); }
  bool full() const noexcept { return mistakes.size() >= kMaxReportedMistakes; }
  void add(Mistake mistake);  // only counted when full()
  // One line each, by line and column: "scenes/x.toml:12:3: [body.3] mass_kg: -1 is not a mass; accepted: a number >=
  // 1e-06 and <= 1e+06".
  std::string message() const;
  std::string warning_message() const;
};

// The scene, or an error whose message is that of the diagnostics. `diagnostics`, when given, is filled in any case.
Result<Scene> parse_scene(std::string_view text, std::string_view name, SceneDiagnostics* diagnostics = nullptr);
Result<Scene> load_scene(const std::filesystem::path& path, SceneDiagnostics* diagnostics = nullptr);

// The keys that the loader requests for this text, in order, each key of a table once: see scene_keys.h.
std::vector<AskedKey> asked_keys(std::string_view text);

// Hash of a scene's text with its files' data (Scene::source): FNV-1a, 64 bit, 16 hexadecimal digits.
std::string source_hash(std::string_view source);

// The highest contact frequency that both worlds solve accurately: 0.25 / h for the longer of their sub-steps [Hz].
// The global step of r ticks has r x global_sub_steps_per_tick sub-steps, so its sub-step does not depend on r.
double max_contact_hertz(const SolverChoice& solver, double tick_s) noexcept;

}  // namespace tactus::sim
