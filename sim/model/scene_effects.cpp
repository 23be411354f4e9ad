#include "sim/model/scene_effects.h"

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
  return any_body(scene, [](const Body& b) { return b.friction > 0; });
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
template <double physics::ContactPatch::*kPart>
bool has_patch(const Scene& scene) {
  const auto& patches = scene.effect_data.patches;
  return std::any_of(patches.begin(), patches.end(), [](const auto& p) { return p.*kPart > 0; });
}
bool resists_spin(const Scene& scene) {
  return scene.effects.friction && has_friction(scene) && has_patch<&physics::ContactPatch::radius_m>(scene);
}
bool may_meet(const Scene& scene) {
  return any_body(scene, [&](const auto& b) { return b.id != scene.proxy; });
}
bool has_grain(const Scene& scene) { return !scene.effect_data.grain.empty(); }
bool rings(const Scene& scene) { return !scene.effect_data.ringing.empty(); }
bool resists_rolling(const Scene& scene) { return has_patch<&physics::ContactPatch::rolling_m>(scene); }

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
    {"ccd", &Effects::ccd, may_meet, "there is nothing that the proxy could meet",
     "a comparison; where the proxy is faster than 10 m/s, a look at what it may reach, every sub-step"},
    {"texture", &Effects::texture, has_grain, "no body has a texture_height_m",
     "a look at every contact; three sines a point of the proxy's on a grained surface"},
    {"transients", &Effects::transients, rings, "no body has a transient_strength_Ns_per_m",
     "a look at every contact; a sine and a cosine for each impact that still rings"},
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

physics::EffectSetups effect_setups(const Scene& scene) {
  const EffectData& data = scene.effect_data;
  physics::EffectSetups setups;
  std::get<physics::Gravity::Setup>(setups).on = is_in_use(scene, *find_effect("gravity"));
  if (scene.effects.damping) std::get<physics::Damping::Setup>(setups) = data.damping;
  std::get<physics::Drag::Setup>(setups) = {if_in_use(scene, "drag", data.drag_per_m), data.flow_m_per_s};
  std::get<physics::ScriptedMotion::Setup>(setups) = {if_in_use(scene, "kinematic", data.scripts), data.path_keys};
  std::get<physics::Joints::Setup>(setups) = {if_in_use(scene, "joints", data.joints)};
  std::get<physics::Restitution::Setup>(setups) = {if_in_use(scene, "restitution", data.restitution)};
  if (is_in_use(scene, *find_effect("torsional")) || is_in_use(scene, *find_effect("rolling")))
    std::get<physics::ContactTorque::Setup>(setups) = {data.patches};
  if (is_in_use(scene, *find_effect("attraction")))
    std::get<physics::Attraction::Setup>(setups) = {data.attraction, data.attraction_weight};
  if (is_in_use(scene, *find_effect("ccd")))
    std::get<physics::ContinuousCollision::Setup>(setups) = {scene.proxy, scene.hulls};
  std::get<physics::Texture::Setup>(setups) = {scene.proxy, if_in_use(scene, "texture", data.grain)};
  std::get<physics::Transients::Setup>(setups) = {scene.proxy, if_in_use(scene, "transients", data.ringing)};
  return setups;
}

physics::EffectSetups global_effect_setups(const Scene& scene) {
  physics::EffectSetups setups = effect_setups(scene);
  std::get<physics::ContinuousCollision::Setup>(setups) = {};
  std::get<physics::Texture::Setup>(setups) = {};
  std::get<physics::Transients::Setup>(setups) = {};
  return setups;
}

void choose_effects(const Scene& scene, physics::StepSettings& settings) {
  settings.gravity = scene.effects.gravity ? scene.gravity_m_per_s2 : Vec3d{};
  settings.friction = is_in_use(scene, *find_effect("friction"));
  settings.gyroscopic = is_in_use(scene, *find_effect("gyroscopic"));
}

}  // namespace tactus::sim
