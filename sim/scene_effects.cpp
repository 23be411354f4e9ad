#include "sim/scene_effects.h"

#include <fmt/format.h>

#include <algorithm>

#include "rt/physics/integrate.h"

namespace tactus::sim {
namespace {

using physics::Body;

template <class Condition>
bool any_body(const Scene& scene, Condition condition) {
  return std::any_of(scene.bodies.begin(), scene.bodies.end(), condition);
}
bool has_friction(const Scene& scene) {
  return any_body(scene, [](const Body<double>& b) { return b.friction > 0; });
}

bool pulls(const Scene& scene) {
  return scene.gravity_m_per_s2 != Vec3d{} && any_body(scene, [](const auto& b) { return b.gravity_scale > 0; });
}
// A body with three equal moments of inertia has no gyroscopic term.
bool tumbles(const Scene& scene) {
  return any_body(
      scene, [](const auto& b) { return b.kind == physics::BodyKind::kDynamic && physics::is_anisotropic(b.inertia); });
}
bool sleeps(const Scene&) { return true; }
bool damps(const Scene& scene) { return scene.effect_data.damping.used(); }
bool drags(const Scene& scene) { return !scene.effect_data.drag_per_m.empty(); }
bool is_scripted(const Scene& scene) { return !scene.effect_data.scripts.empty(); }
bool is_joined(const Scene& scene) { return !scene.effect_data.joints.empty(); }
bool bounces(const Scene& scene) { return !scene.effect_data.restitution.empty(); }
bool attracts(const Scene& scene) {
  return !scene.effect_data.attraction.empty() && !scene.effect_data.attraction_weight.empty();
}
template <double physics::ContactPatch<double>::*kPart>
bool has_patch(const Scene& scene) {
  const auto& patches = scene.effect_data.patches;
  return std::any_of(patches.begin(), patches.end(), [](const auto& p) { return p.*kPart > 0; });
}
bool resists_spin(const Scene& scene) {
  return scene.effects.friction && has_friction(scene) && has_patch<&physics::ContactPatch<double>::radius_m>(scene);
}
bool resists_rolling(const Scene& scene) { return has_patch<&physics::ContactPatch<double>::rolling_m>(scene); }

// One line for each effect.
constexpr EffectInfo kEffects[] = {
    {"gravity", &Effects::gravity, pulls, "no body falls, or gravity_m_per_s2 is zero",
     "one addition a body and sub-step"},
    {"friction", &Effects::friction, has_friction, "every coefficient is zero",
     "two rows more at every contact point, in every relax sweep"},
    {"gyroscopic", &Effects::gyroscopic, tumbles, "every body is a sphere, a cube or fixed",
     "a small system of equations a body that is no sphere and no cube, every sub-step"},
    {"sleeping", &Effects::sleeping, sleeps, "",
     "a look at every body that is awake, once a global step; what sleeps costs nothing"},
    {"damping", &Effects::damping, damps, "both rates in [damping] are zero", "two products a body and sub-step"},
    {"drag", &Effects::drag, drags, "the fluid has no density, or no body a drag coefficient",
     "a root and a division a body and sub-step"},
    {"kinematic", &Effects::kinematic, is_scripted, "no body is kinematic",
     "a look at its path a kinematic body and sub-step"},
    {"joints", &Effects::joints, is_joined, "there is no [[joint]]",
     "about as much as two contacts a joint: its rows in every sweep, its masses every sub-step"},
    {"torsional", &Effects::torsional, resists_spin, "no body has friction and a contact_radius_m",
     "three rows more in every sweep, at contacts of one point"},
    {"rolling", &Effects::rolling, resists_rolling, "no body has a rolling_friction_m",
     "three rows more in every sweep, at contacts of one point"},
    {"restitution", &Effects::restitution, bounces, "every restitution is zero",
     "a look at every point of contacts that may bounce, every sub-step; a pass over those that do"},
    {"attraction", &Effects::attraction, attracts, "there is no [[attraction]], or no body has an attraction_weight",
     "a root and a division a body, source and sub-step"},
};

template <class T>
std::span<const T> if_in_use(const Scene& scene, std::string_view effect, const std::vector<T>& list) {
  return is_in_use(scene, *find_effect(effect)) ? std::span<const T>(list) : std::span<const T>();
}

}  // namespace

std::span<const EffectInfo> known_effects() noexcept { return kEffects; }

const EffectInfo* find_effect(std::string_view name) noexcept {
  const auto* found =
      std::find_if(std::begin(kEffects), std::end(kEffects), [&](const auto& e) { return e.name == name; });
  return found == std::end(kEffects) ? nullptr : found;
}

std::string effect_words() {
  std::string words;
  for (const auto& effect : kEffects) words += fmt::format("{}{}", words.empty() ? "" : ", ", effect.name);
  return words;
}

bool is_in_use(const Scene& scene, const EffectInfo& effect) {
  return scene.effects.*effect.declared && effect.used(scene);
}

physics::EffectSetups<double> effect_setups(const Scene& scene) {
  const EffectData& data = scene.effect_data;
  physics::EffectSetups<double> setups;
  std::get<physics::Gravity<double>::Setup>(setups).on = is_in_use(scene, *find_effect("gravity"));
  if (scene.effects.damping) std::get<physics::Damping<double>::Setup>(setups) = data.damping;
  std::get<physics::Drag<double>::Setup>(setups) = {if_in_use(scene, "drag", data.drag_per_m), data.flow_m_per_s};
  std::get<physics::Kinematics<double>::Setup>(setups) = {if_in_use(scene, "kinematic", data.scripts), data.path_keys};
  std::get<physics::Joints<double>::Setup>(setups) = {if_in_use(scene, "joints", data.joints)};
  std::get<physics::Restitution<double>::Setup>(setups) = {if_in_use(scene, "restitution", data.restitution)};
  if (is_in_use(scene, *find_effect("torsional")) || is_in_use(scene, *find_effect("rolling")))
    std::get<physics::ContactTorque<double>::Setup>(setups) = {data.patches};
  if (is_in_use(scene, *find_effect("attraction")))
    std::get<physics::Attraction<double>::Setup>(setups) = {data.attraction, data.attraction_weight};
  return setups;
}

void choose_effects(const Scene& scene, physics::StepSettings<double>& settings) {
  settings.gravity = scene.effects.gravity ? scene.gravity_m_per_s2 : Vec3d{};
  settings.friction = is_in_use(scene, *find_effect("friction"));
  settings.gyroscopic = is_in_use(scene, *find_effect("gyroscopic"));
}

}  // namespace tactus::sim
