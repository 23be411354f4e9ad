#include "tools/experiment/effects.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <memory>
#include <nlohmann/json.hpp>

#include "rt/physics/world.h"
#include "sim/broad_phase/pair_grid.h"
#include "sim/loader/scene_load.h"
#include "sim/model/scene_effects.h"
#include "sim/model/step_settings.h"
#include "sim/model/world_capacities.h"
#include "tools/experiment/instructions.h"
#include "tools/experiment/statistics.h"
#include "tools/experiment/timing.h"
#include "tools/json_report.h"

namespace tactus::experiment {
namespace {

constexpr unsigned kSettleTicks = 200, kCountedTicks = 20;
constexpr double kTick_s = 1e-3, kMaxDifference = 1e-3;
constexpr std::uint32_t kTimedMost = 1000, kTimedTicks = 60;  // bodies; ticks with and without each effect
constexpr std::uint32_t kTimedParts = 6;

// All moving bodies of a scene in one world, stepped as the haptic thread steps its members.
class TickedWorld {
 public:
  explicit TickedWorld(const sim::Scene& scene)
      : world_(sim::member_capacities(scene, static_cast<std::uint32_t>(scene.bodies.size())), scene.shapes(),
               sim::effect_setups(scene)),
        settings_(sim::step_settings(scene, kTick_s, scene.solver.sub_steps)),
        grid_(static_cast<std::uint32_t>(scene.bodies.size())) {
    for (const auto& body : scene.bodies) TACTUS_CHECK(world_.insert(body), body.id, scene.bodies.size());
    world_.index_fixed_bodies();
  }
  void tick() noexcept {
    world_.begin_step(settings_);
    (void)grid_.find(world_.bounds(), world_.dynamic_pairs());
    (void)world_.finish_step(settings_);
  }

 private:
  physics::World world_;
  physics::StepSettings settings_;
  sim::PairGrid grid_;
};

std::string list_of(const std::vector<std::string>& effects) {
  std::string list;
  for (const auto& effect : effects) list += fmt::format("{}\"{}\"", list.empty() ? "" : ", ", effect);
  return "effects = [" + list + "]\n";
}

// Columns of cubes, spheres on the ground beside them, slabs in free flight; the extra keys declare and use an effect.
struct Bodies {
  std::string all, sphere, slab;  // extra keys, of each kind
  double friction{0.5}, slab_height_m{0.1};

  std::string text() const {
    std::string out = fmt::format("[[body]]\nshape = \"plane\"\nfriction = {}\n{}", friction, all);
    const auto body = [&](const std::string& shape, const std::string& name, double x, double y, double z,
                          const std::string& more) {
      out += fmt::format("[[body]]\n{}\nname = \"{}\"\nmass_kg = 1\nfriction = {}\nposition_m = [{}, {}, {}]\n{}{}",
                         shape, name, friction, x, y, z, all, more);
    };
    for (int i = 0; i < 16; ++i) {
      const double x = 0.2 * (i % 4), y = 0.2 * (i / 4);
      for (int k = 0; k < 3; ++k)
        body("shape = \"box\"\nsize_m = [0.1, 0.1, 0.1]", fmt::format("cube{}_{}", i, k), x, y, 0.05 + 0.1 * k, "");
      body("shape = \"sphere\"\nradius_m = 0.05", fmt::format("sphere{}", i), x + 2, y, 0.05, sphere);
      body(fmt::format("shape = \"box\"\nsize_m = [0.1, 0.1, {}]", slab_height_m), fmt::format("slab{}", i), x + 4, y,
           10, "angular_velocity_rad_per_s = [5, 3, 1]\n" + slab);
    }
    return out;
  }
};

constexpr const char* kProxyTables =
    "[proxy]\nshape = \"sphere\"\nradius_m = 0.01\nmass_kg = 0.2\nposition_m = [0, 0, 5]\n"
    "[simulation]\nratio = 10\n";

}  // namespace

bool EffectRow::good() const noexcept {
  return std::abs(instructions[1] - instructions[0]) <= kMaxDifference * instructions[0];
}

std::vector<std::string> effect_names() {
  std::vector<std::string> names;
  for (const auto& effect : sim::known_effects()) names.emplace_back(effect.name);
  return names;
}

std::string effect_scene(const std::string& effect, EffectState state) {
  std::vector<std::string> effects;
  for (const char* base : {"gravity", "friction"})
    if (effect != base) effects.emplace_back(base);
  if (state != EffectState::kOff) effects.push_back(effect);
  const bool used = state == EffectState::kUsed;
  Bodies bodies;
  std::string head, tail;
  if (effect == "gravity" && state == EffectState::kUnused) head = "gravity_m_per_s2 = [0, 0, 0]\n";
  if (effect == "friction" && !used) bodies.friction = 0;
  if (effect == "gyroscopic" && used) bodies.slab_height_m = 0.11;
  if (effect == "sleeping" && state != EffectState::kOff)
    tail = fmt::format("[sleeping]\nafter_s = {}\n", used ? 0.05 : 3600);
  if (effect == "damping" && used) tail = "[damping]\nlinear_per_s = 0.1\nangular_per_s = 0.1\n";
  if (effect == "drag" && used) tail = "[drag]\nfluid_density_kg_per_m3 = 1.2\n";
  if (effect == "kinematic" && used) bodies.slab = "kinematic = true\n";
  if (effect == "torsional" && used) bodies.sphere = "contact_radius_m = 0.005\n";
  if (effect == "rolling" && used) bodies.sphere = "rolling_friction_m = 0.001\n";
  if (effect == "restitution" && used) bodies.all = "restitution = 0.5\n";
  if (effect == "texture" && used) bodies.all = "texture_height_m = 1e-4\n";
  if (effect == "transients" && used) bodies.all = "transient_strength_Ns_per_m = 1\n";
  if (effect == "attraction" && used) {
    bodies.sphere = "attraction_weight = 1\n";
    tail = "[[attraction]]\nposition_m = [2, 0, 3]\nstrength_Nm2 = 0.01\n";
  }
  if (effect == "joints" && used)
    for (int i = 0; i < 16; ++i)
      tail += fmt::format("[[joint]]\nkind = \"hinge\"\na = \"cube{0}_0\"\nb = \"cube{0}_1\"\naxis = [0, 0, 1]\n", i);
  return list_of(effects) + head + kProxyTables + bodies.text() + tail;
}

void count_effect(const std::string& effect, EffectState state) {
  const auto loaded = sim::parse_scene(effect_scene(effect, state), effect);
  if (!loaded.ok()) std::abort();  // the test of these scenes reports the reason
  const sim::Scene& scene = loaded.value();
  TickedWorld world(scene);
  for (unsigned i = 0; i < kSettleTicks; ++i) world.tick();
  start_counting();
  for (unsigned i = 0; i < kCountedTicks; ++i) world.tick();
  stop_counting();
}

std::vector<EffectRow> run_effects(const std::vector<std::string>& effects, const std::string& program,
                                   const Progress& progress) {
  const bool counts = can_count_instructions();
  std::vector<EffectRow> rows;
  for (const auto& effect : effects) {
    EffectRow row{effect};
    for (std::uint32_t state = 0; counts && state < row.instructions.size(); ++state) {
      constexpr const char* kStates[] = {"off", "declared and not used", "used"};
      if (progress) progress(fmt::format("{} of {}: {}, {}", rows.size() + 1, effects.size(), effect, kStates[state]));
      row.instructions[state] =
          counted_instructions(program, fmt::format("experiment effects --count {}:{}", effect, state)) / kCountedTicks;
    }
    rows.push_back(row);
  }
  return rows;
}

std::string effects_table(const std::vector<EffectRow>& rows) {
  std::string text =
      fmt::format("{:<12} {:>13} {:>13} {:>10} {:>13} {:>10}\n", "effect", "off", "not used", "more", "used", "more");
  for (const EffectRow& row : rows) {
    const auto& n = row.instructions;
    const auto more = [&](double x) { return n[0] > 0 ? fmt::format("{:+.2f} %", 100 * (x / n[0] - 1)) : "-"; };
    text += fmt::format("{:<12} {:>13.0f} {:>13.0f} {:>10} {:>13.0f} {:>10}{}\n", row.effect, n[0], n[1], more(n[1]),
                        n[2], more(n[2]), row.good() ? "" : "  NOT FREE");
  }
  return text +
         "\nInstructions of a tick of 81 bodies, by callgrind: the effect not declared, declared with nothing that "
         "uses it, and used.\n"
         "sleeping acts in the global world alone. ccd has no key: declared, it looks ahead of the proxy.\n";
}

std::string effects_json(const std::vector<EffectRow>& rows) {
  using nlohmann::ordered_json;
  ordered_json list = ordered_json::array();
  for (const EffectRow& row : rows) {
    const auto number = [](double x) { return x > 0 ? ordered_json(x) : ordered_json(nullptr); };
    list.push_back({{"effect", row.effect},
                    {"instructions_off", number(row.instructions[0])},
                    {"instructions_unused", number(row.instructions[1])},
                    {"instructions_used", number(row.instructions[2])}});
  }
  return report_text(ordered_json{{"rows", list}}, 2);
}

namespace {

double spread_of(const std::vector<double>& with_us, const std::vector<double>& without_us) {
  double least = std::numeric_limits<double>::infinity(), most = -least;
  for (std::uint32_t part = 0; part < kTimedParts; ++part) {
    const auto median_of = [part](const std::vector<double>& us) {
      const auto size = static_cast<std::ptrdiff_t>(kTimedTicks / kTimedParts);
      const auto begin = us.begin() + size * static_cast<std::ptrdiff_t>(part);
      return median({begin, begin + size});
    };
    const double added_us = median_of(with_us) - median_of(without_us);
    least = std::min(least, added_us);
    most = std::max(most, added_us);
  }
  return 0.5 * (most - least);
}

}  // namespace

std::vector<EffectTime> time_effects(const sim::Scene& scene) {
  std::vector<EffectTime> times;
  if (scene.bodies.size() > kTimedMost) return times;
  for (const auto& effect : sim::known_effects()) {
    if (!sim::is_in_use(scene, effect) || effect.name == "sleeping")
      continue;  // sleeping exists only in the global world
    sim::Scene without = scene;
    without.effects.*effect.declared = false;
    TickedWorld with_it(scene), without_it(without);
    std::vector<double> with_us, without_us;
    const auto timed = [](TickedWorld& world, std::vector<double>& us) {
      const double start = thread_time_us();
      world.tick();
      us.push_back(thread_time_us() - start);
    };
    for (std::uint32_t i = 0; i < kTimedTicks; ++i) {
      timed(with_it, with_us);
      timed(without_it, without_us);
    }
    times.push_back({.effect = std::string(effect.name),
                     .added_us = median(with_us) - median(without_us),
                     .spread_us = spread_of(with_us, without_us),
                     .tick_us = median(with_us)});
  }
  return times;
}

}  // namespace tactus::experiment
