#include "sim/model/scene_effects.h"

#include <fmt/format.h>

#include <algorithm>
#include <type_traits>

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

// One row for each effect, in the order of DeclaredEffects.
constexpr EffectInfo kEffects[] = {
    {.name = "gravity",
     .declared = &DeclaredEffects::gravity,
     .used = pulls,
     .unused = "no body falls, or gravity_m_per_s2 is zero",
     .cost = "one addition a body and sub-step"},
    {.name = "friction",
     .declared = &DeclaredEffects::friction,
     .used = has_friction,
     .unused = "every coefficient is zero",
     .cost = "two rows more at every contact point, in every relax sweep"},
    {.name = "gyroscopic",
     .declared = &DeclaredEffects::gyroscopic,
     .used = tumbles,
     .unused = "every body is a sphere, a cube or fixed",
     .cost = "a small system of equations a body that is no sphere and no cube, every sub-step"},
    {.name = "sleeping",
     .declared = &DeclaredEffects::sleeping,
     .used = sleeps,
     .unused = "",
     .cost = "a look at every body that is awake, once a global step; what sleeps costs nothing"},
    {.name = "damping",
     .declared = &DeclaredEffects::damping,
     .used = damps,
     .unused = "both rates in [damping] are zero",
     .cost = "two products a body and sub-step"},
    {.name = "drag",
     .declared = &DeclaredEffects::drag,
     .used = drags,
     .unused = "the fluid has no density, or no body a drag coefficient",
     .cost = "a root and a division a body and sub-step"},
    {.name = "kinematic",
     .declared = &DeclaredEffects::kinematic,
     .used = is_scripted,
     .unused = "no body is kinematic",
     .cost = "a look at its path a kinematic body and sub-step"},
    {.name = "joints",
     .declared = &DeclaredEffects::joints,
     .used = is_joined,
     .unused = "there is no [[joint]]",
     .cost = "about as much as two contacts a joint: its rows in every sweep, its masses every sub-step"},
    {.name = "torsional",
     .declared = &DeclaredEffects::torsional,
     .used = resists_spin,
     .unused = "no body has friction and a contact_radius_m",
     .cost = "three rows more in every sweep, at contacts of one point"},
    {.name = "rolling",
     .declared = &DeclaredEffects::rolling,
     .used = resists_rolling,
     .unused = "no body has a rolling_friction_m",
     .cost = "three rows more in every sweep, at contacts of one point"},
    {.name = "restitution",
     .declared = &DeclaredEffects::restitution,
     .used = bounces,
     .unused = "every restitution is zero",
     .cost = "a look at every point of contacts that may bounce, every sub-step; a pass over those that do"},
    {.name = "attraction",
     .declared = &DeclaredEffects::attraction,
     .used = attracts,
     .unused = "there is no [[attraction]], or no body has an attraction_weight",
     .cost = "a root and a division a body, source and sub-step"},
    {.name = "ccd",
     .declared = &DeclaredEffects::ccd,
     .used = may_meet,
     .unused = "there is nothing that the proxy could meet",
     .cost = "a comparison; where the proxy is faster than 10 m/s, a look at what it may reach, every sub-step",
     .hand_only = true},
    {.name = "texture",
     .declared = &DeclaredEffects::texture,
     .used = has_grain,
     .unused = "no body has a texture_height_m",
     .cost = "a look at every contact; three sines a point of the proxy's on a grained surface",
     .hand_only = true},
    {.name = "transients",
     .declared = &DeclaredEffects::transients,
     .used = rings,
     .unused = "no body has a transient_strength_Ns_per_m",
     .cost = "a look at every contact; a sine and a cosine for each impact that still rings",
     .hand_only = true},
};
static_assert(std::size(kEffects) == sizeof(DeclaredEffects), "an effect without a row");

// Is the effect in use in this world?
struct InUse {
  const Scene& scene;
  bool global;  // the global world

  bool operator()(bool DeclaredEffects::*declared) const {
    const EffectInfo& effect = *find_effect(declared);
    return is_in_use(scene, effect) && !(global && effect.hand_only);
  }
};

// The set-up of an effect object, by its class: the default if no effect that needs the object is in use. An object in
// rt/physics/effects/effect_list.h without one does not compile.
template <class Object>
typename Object::Setup setup_of(const Scene& scene, const InUse& in_use) = delete;

template <>
physics::Gravity::Setup setup_of<physics::Gravity>(const Scene&, const InUse& in_use) {
  return {.on = in_use(&DeclaredEffects::gravity)};
}
template <>
physics::Damping::Setup setup_of<physics::Damping>(const Scene& scene, const InUse& in_use) {
  if (!in_use(&DeclaredEffects::damping)) return {};
  return scene.effect_data.damping;
}
template <>
physics::Drag::Setup setup_of<physics::Drag>(const Scene& scene, const InUse& in_use) {
  if (!in_use(&DeclaredEffects::drag)) return {};
  return {.per_m = scene.effect_data.drag_per_m, .flow = scene.effect_data.flow_m_per_s};
}
template <>
physics::Attraction::Setup setup_of<physics::Attraction>(const Scene& scene, const InUse& in_use) {
  if (!in_use(&DeclaredEffects::attraction)) return {};
  return {.sources = scene.effect_data.attraction, .weight_by_id = scene.effect_data.attraction_weight};
}
template <>
physics::ScriptedMotion::Setup setup_of<physics::ScriptedMotion>(const Scene& scene, const InUse& in_use) {
  if (!in_use(&DeclaredEffects::kinematic)) return {};
  return {.scripts = scene.effect_data.scripts, .keys = scene.effect_data.path_keys};
}
template <>
physics::Joints::Setup setup_of<physics::Joints>(const Scene& scene, const InUse& in_use) {
  if (!in_use(&DeclaredEffects::joints)) return {};
  return {.joints = scene.effect_data.joints};
}
template <>
physics::ContactTorque::Setup setup_of<physics::ContactTorque>(const Scene& scene, const InUse& in_use) {
  if (!in_use(&DeclaredEffects::torsional) && !in_use(&DeclaredEffects::rolling)) return {};
  return {.by_id = scene.effect_data.patches};
}
template <>
physics::Restitution::Setup setup_of<physics::Restitution>(const Scene& scene, const InUse& in_use) {
  if (!in_use(&DeclaredEffects::restitution)) return {};
  return {.by_id = scene.effect_data.restitution};
}
template <>
physics::ContinuousCollision::Setup setup_of<physics::ContinuousCollision>(const Scene& scene, const InUse& in_use) {
  if (!in_use(&DeclaredEffects::ccd)) return {};
  return {.proxy = scene.proxy, .shapes = scene.shapes()};
}
template <>
physics::Texture::Setup setup_of<physics::Texture>(const Scene& scene, const InUse& in_use) {
  if (!in_use(&DeclaredEffects::texture)) return {};
  return {.proxy = scene.proxy, .by_id = scene.effect_data.grain};
}
template <>
physics::Transients::Setup setup_of<physics::Transients>(const Scene& scene, const InUse& in_use) {
  if (!in_use(&DeclaredEffects::transients)) return {};
  return {.proxy = scene.proxy, .by_id = scene.effect_data.ringing};
}

template <class... Object>
physics::EffectSetups setups_of(std::type_identity<std::tuple<Object...>>, const Scene& scene, const InUse& in_use) {
  return {setup_of<Object>(scene, in_use)...};
}

}  // namespace

std::span<const EffectInfo> known_effects() noexcept { return kEffects; }

const EffectInfo* find_effect(bool DeclaredEffects::*declared) noexcept {
  return std::find_if(std::begin(kEffects), std::end(kEffects), [&](const auto& e) { return e.declared == declared; });
}

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
  return setups_of(std::type_identity<physics::EffectObjects>(), scene, {scene, false});
}

physics::EffectSetups global_effect_setups(const Scene& scene) {
  return setups_of(std::type_identity<physics::EffectObjects>(), scene, {scene, true});
}

void choose_effects(const Scene& scene, physics::StepSettings& settings) {
  settings.gravity = scene.effects.gravity ? scene.gravity_m_per_s2 : Vec3d{};
  settings.friction = is_in_use(scene, *find_effect(&DeclaredEffects::friction));
  settings.gyroscopic = is_in_use(scene, *find_effect(&DeclaredEffects::gyroscopic));
}

}  // namespace tactus::sim
