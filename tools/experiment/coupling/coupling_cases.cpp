#include "tools/experiment/coupling/coupling_cases.h"

#include <array>

#include "sim/loader/scene_load.h"
#include "tools/experiment/shared_files.h"

namespace tactus::experiment {
namespace {

// splitmix64 (Steele, Lea, Flood 2014), in [-1, 1).
double next_random(std::uint64_t& state) {
  std::uint64_t z = state += 0x9e3779b97f4a7c15ull;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
  return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-52 - 1;
}

Vec3d jittered(const Vec3d& way, double share, std::uint64_t& state) {
  const double x = next_random(state), y = next_random(state), z = next_random(state);
  return way + Vec3d{x, y, z} * (share * norm(way));
}

std::filesystem::path path_of(const CouplingCase& one) {
  return one.own_hand ? std::filesystem::path(one.file) : shared_file("scenes") / one.file;
}

}  // namespace

std::span<const CouplingCase> coupling_cases() {
  // Name, file, members, where the hand presses, how far it slides.
  static const std::array<CouplingCase, 7> cases{{
      {"stack", "stack20.toml", 10, {0, 0, -0.006}, {0.0004, 0, -0.003}},
      {"card-house", "card_house.toml", 12, {0, 0, -0.004}, {0.001, 0, -0.001}},
      {"pile", "pile250.toml", 64, {0, 0, -0.010}, {0.03, 0, -0.004}},
      {"press", "press.toml", 16, {0, 0, -0.008}, {0.03, 0, -0.004}},
      {"peg", "peg_in_shaft.toml", 8, {0, 0, -0.006}, {0.003, 0.002, -0.002}},
      {"chain", "chain.toml", 8, {0.018, 0, 0}, {0.04, 0, 0}},
      {"wall", "wall.toml", 30, {0, 0.028, 0}, {0.01, 0.012, 0}},
  }};
  return cases;
}

std::vector<std::string> coupling_case_names() {
  std::vector<std::string> names;
  for (const CouplingCase& one : coupling_cases()) names.push_back(one.name);
  return names;
}

Result<CouplingCase> case_of_file(const std::string& path) {
  auto loaded = sim::load_scene(path);
  if (!loaded.ok()) return loaded.status();
  CouplingCase one;
  one.name = loaded.value().name;
  one.file = path;
  one.members = loaded.value().members;
  one.own_hand = true;
  return one;
}

Result<sim::Scene> load_case_scene(const CouplingCase& one) { return sim::load_scene(path_of(one)); }

std::vector<std::string> files_of(std::span<const CouplingCase> cases) {
  std::vector<std::string> files;
  for (const CouplingCase& one : cases) files.push_back(path_of(one).string());
  return files;
}

Result<sim::Scene> load_coupling_case(const CouplingCase& one, std::uint64_t seed) {
  auto loaded = load_case_scene(one);
  if (!loaded.ok() || one.own_hand) return loaded;
  sim::Scene scene = std::move(loaded).value();
  Vec3d press = one.press_m, slide = one.slide_m;
  if (seed > 0) {
    std::uint64_t state = seed;
    press = jittered(press, 0.1, state);
    slide = jittered(slide, 0.2, state);
  }
  const Vec3d start = scene.bodies[scene.proxy].motion.pose.position;
  const Vec3d hold = start + press;
  constexpr double kMoves = (HandTimes::kEnd - HandTimes::kHeld) / 3;
  scene.hand.path = {{0, start, {}},
                     {HandTimes::kPressed, hold, {}},
                     {HandTimes::kHeld, hold, {}},
                     {HandTimes::kHeld + kMoves, hold + slide, {}},
                     {HandTimes::kHeld + 2 * kMoves, hold + slide * 1.1, {}},
                     {HandTimes::kEnd, hold + slide * 1.5, {}}};
  scene.hand.repeat = false;
  return scene;
}

}  // namespace tactus::experiment
