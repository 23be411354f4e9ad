#include "sim/loader/scene_load_effects.h"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>

#include "rt/text/nearest_word.h"
#include "sim/model/given_pose.h"
#include "sim/model/scene_effects.h"

namespace tactus::sim {
namespace {

using physics::Body;
using physics::BodyKind;
using physics::ShapeKind;

constexpr text::Range kRate{"a rate", 0, 1e4};
constexpr double kSteepestGrain = 1;

double face_area(const physics::Hull& hull, std::uint32_t face) {
  const auto loop = hull.topology.loop(face);
  Vec3d twice;
  for (std::size_t k = 1; k + 1 < loop.size(); ++k)
    twice += cross(hull.vertex(loop[k]) - hull.vertex(loop[0]), hull.vertex(loop[k + 1]) - hull.vertex(loop[0]));
  return 0.5 * norm(twice);
}

// Projected area, mean over all directions: of a convex shape a quarter of its surface (Cauchy).
double area_across(const Scene& scene, const physics::Shape& shape) {
  const double r = shape.radius;
  const Vec3d& e = shape.half_extents;
  switch (shape.kind) {
    case ShapeKind::kSphere:
      return std::numbers::pi * r * r;
    case ShapeKind::kCapsule:
      return std::numbers::pi * r * (r + shape.half_length);
    case ShapeKind::kCylinder:
      return 0.5 * std::numbers::pi * r * (r + 2 * shape.half_length);
    case ShapeKind::kCone:
      return 0.25 * std::numbers::pi * r * (r + std::hypot(r, 2 * shape.half_length));
    case ShapeKind::kBox:
      return 2 * (e.x * e.y + e.y * e.z + e.z * e.x);
    case ShapeKind::kHull: {
      double area = 0;
      const auto& hull = scene.hulls[shape.index];
      for (std::uint32_t face = 0; face < hull.topology.faces; ++face) area += face_area(hull, face);
      return 0.25 * area;
    }
    case ShapeKind::kCompound: {  // at most: parts hide each other
      double area = 0;
      for (const auto& part : scene.compounds[shape.index].parts) area += area_across(scene, part.shape);
      return area;
    }
    case ShapeKind::kPlane:
    case ShapeKind::kMesh:
      return 0;
  }
  return 0;
}

template <class T>
T& entry_of(std::vector<T>& by_id, BodyId id) {
  if (by_id.size() <= id) by_id.resize(id + 1);
  return by_id[id];
}

}  // namespace

// Adds a mistake if the key is present and its effect is not declared.
bool EffectReader::needs(text::TableReader& table, const char* key, bool DeclaredEffects::*effect) {
  if (!table.has(key) || scene_.effects.*effect) return true;
  const std::string_view name = find_effect(effect)->name;
  table.mistake(key, fmt::format("set, but the effect {} is not declared", name),
                fmt::format("\"{}\" among the effects, or no {}", name, key));
  return false;
}

void EffectReader::read_list(text::TableReader& root) {
  std::vector<std::string_view> words;
  for (const auto& effect : known_effects()) words.push_back(effect.name);
  for (const text::TomlNode& item : root.array("effects", 64)) {
    const EffectInfo* found = item.kind == text::TomlKind::kText ? find_effect(item.text) : nullptr;
    if (found == nullptr) {
      const auto nearest = text::nearest_word(item.text, words);
      diagnostics_.add({.line = item.line,
                        .column = item.column,
                        .where = "effects",
                        .what = fmt::format("{} is not an effect{}", item.shown(),
                                            nearest.empty() ? "" : fmt::format(", did you mean {}?", nearest)),
                        .accepted = effect_words()});
      continue;
    }
    bool& flag = scene_.effects.*found->declared;
    if (flag)
      diagnostics_.add({.line = item.line,
                        .column = item.column,
                        .where = "effects",
                        .what = item.shown() + " is there twice",
                        .accepted = "once"});
    flag = true;
  }
}

void EffectReader::read_tables(text::TableReader& root) {
  needs(root, "damping", &DeclaredEffects::damping);
  text::TableReader damping(root.table("damping"), "[damping]", diagnostics_);
  scene_.effect_data.damping = {damping.number("linear_per_s", 0, kRate), damping.number("angular_per_s", 0, kRate)};
  damping.finish();
  needs(root, "drag", &DeclaredEffects::drag);
  text::TableReader drag(root.table("drag"), "[drag]", diagnostics_);
  density_kg_per_m3_ = drag.number("fluid_density_kg_per_m3", 0, {"a density", 0, 1e5});
  drag_coefficient_ = drag.number("coefficient", 0.5, {"a drag coefficient", 0, 100});
  scene_.effect_data.flow_m_per_s = drag.vector("flow_m_per_s", {}, {"a velocity", -100, 100});
  drag.finish();
}

EffectReader::Surface EffectReader::read_surface(text::TableReader& table) {
  needs(table, "restitution", &DeclaredEffects::restitution);
  needs(table, "contact_radius_m", &DeclaredEffects::torsional);
  needs(table, "rolling_friction_m", &DeclaredEffects::rolling);
  Surface surface;
  surface.restitution = table.number("restitution", 0, {"a coefficient of restitution", 0, 1});
  surface.patch.radius_m = table.number("contact_radius_m", 0, {"a radius", 0, 10});
  surface.patch.rolling_m = table.number("rolling_friction_m", 0, {"a length", 0, 10});
  needs(table, "attraction_weight", &DeclaredEffects::attraction);
  surface.attraction_weight = table.number("attraction_weight", 0, {"a weight", -1e3, 1e3});
  read_feel(table, surface);
  return surface;
}

// Keys of effects on the hand only: texture and transients.
void EffectReader::read_feel(text::TableReader& table, Surface& surface) {
  needs(table, "texture_height_m", &DeclaredEffects::texture);
  surface.grain.height_m = table.number("texture_height_m", 0, {"a height", 0, 0.01});
  surface.grain.wavelength_m = table.number("texture_wavelength_m", 0.002, {"a length", 1e-4, 1});
  const double slope = 2 * std::numbers::pi * surface.grain.height_m / surface.grain.wavelength_m;
  if (slope > kSteepestGrain)
    table.mistake(
        "texture_height_m", fmt::format("the grain's slope is {:.3g}", slope),
        fmt::format("at most texture_wavelength_m / {:.3g}: a slope of 1", 2 * std::numbers::pi / kSteepestGrain));
  needs(table, "transient_strength_Ns_per_m", &DeclaredEffects::transients);
  surface.ringing.strength_Ns_per_m =
      table.number("transient_strength_Ns_per_m", 0, {"newtons for a metre per second", 0, 1e3});
  surface.ringing.frequency_Hz = table.number("transient_frequency_Hz", 150, {"a frequency", 10, 400});
  surface.ringing.decay_s = table.number("transient_decay_s", 0.01, {"a time", 0.001, 1});
}

void EffectReader::set_surface(BodyId id, const Surface& surface) {
  if (surface.restitution > 0) entry_of(scene_.effect_data.restitution, id) = surface.restitution;
  if (surface.patch.radius_m > 0 || surface.patch.rolling_m > 0)
    entry_of(scene_.effect_data.patches, id) = surface.patch;
  if (surface.grain.height_m > 0) entry_of(scene_.effect_data.grain, id) = surface.grain;
  if (surface.ringing.strength_Ns_per_m > 0) entry_of(scene_.effect_data.ringing, id) = surface.ringing;
  if (surface.attraction_weight != 0) entry_of(scene_.effect_data.attraction_weight, id) = surface.attraction_weight;
}

void EffectReader::read_body(text::TableReader& table, Body& body) {
  const std::string name = table.text("name", "", 100);
  if (!name.empty() && !ids_.emplace(name, body.id).second)
    table.mistake("name", fmt::format("\"{}\" is another body's name", name), "a name of its own");
  needs(table, "kinematic", &DeclaredEffects::kinematic);
  if (table.flag("kinematic", false) && body.kind == BodyKind::kDynamic) return read_script(table, body);
  if (table.has("kinematic") && body.kind == BodyKind::kFixed && table.flag("kinematic", false))
    table.mistake("kinematic", "a fixed body does not move", "false, or no fixed");
  for (const char* key : {"path", "repeat_path"})
    table.refuse(key, "only a kinematic body follows a path", std::string("kinematic = true, or no ") + key);
}

void EffectReader::read_script(text::TableReader& table, Body& body) {
  auto& keys = scene_.effect_data.path_keys;
  const Posed given_from_body = sim::given_from_body(scene_, body.id);
  physics::KinematicScript script{.id = body.id,
                                  .first_key = static_cast<std::uint32_t>(keys.size()),
                                  .keys = 0,
                                  .repeat = table.flag("repeat_path", false),
                                  .key_from_body = given_from_body};
  unsigned number = 0;
  for (const text::TomlNode& node : table.array("path", kMaxPathKeys)) {
    text::TableReader t(&node, table.name_of(fmt::format("path.{}", ++number)), diagnostics_);
    if (!t.there()) continue;
    physics::PathKey key;
    t.require("time_s", "a number");
    key.time_s = t.number("time_s", 0, {"a time", 0, 1e5});
    t.require("position_m", "[x, y, z]");
    key.position_m = t.vector("position_m", {}, {"a place", -1e4, 1e4});
    key.rotation_vector_rad = t.vector("rotation_vector_rad", {}, {"a rotation", -1e4, 1e4});
    if (script.keys == 0 && key.time_s != 0) t.mistake("time_s", "the path begins later than at 0 s", "0");
    if (script.keys > 0 && key.time_s <= keys.back().time_s)
      t.mistake("time_s", fmt::format("{} s is not after {} s", key.time_s, keys.back().time_s), "ascending times");
    keys.push_back(key);
    ++script.keys;
    t.finish();
  }
  if (script.keys > 0) {
    for (const char* key : {"position_m", "rotation_vector_rad", "velocity_m_per_s", "angular_velocity_rad_per_s"})
      table.refuse(key, "the body has a path", "no such key: the path says it");
    const auto& first = keys[script.first_key];
    body.motion.pose = Posed{first.position_m, quat_from_rotation_vector(first.rotation_vector_rad)} * given_from_body;
    body.motion.velocity = {};
  }
  body.gravity_scale = 0;
  scene_.effect_data.scripts.push_back(script);
}

void EffectReader::read_attraction(text::TableReader& root) {
  const auto nodes = root.array("attraction", physics::kMaxAttractionSources);
  if (!nodes.empty()) needs(root, "attraction", &DeclaredEffects::attraction);
  unsigned number = 0;
  for (const text::TomlNode& node : nodes) {
    text::TableReader t(&node, fmt::format("[attraction.{}]", ++number), diagnostics_);
    if (!t.there()) continue;
    physics::AttractionSource source;
    source.body = read_end(t, "body");
    if (source.body != kNoBody) t.refuse("position_m", "the source is a body", "body or position_m");
    source.position_m = t.vector("position_m", {}, {"a place", -1e4, 1e4});
    t.require("strength_Nm2", "a number: newtons at 1 m");
    source.strength_Nm2 = t.number("strength_Nm2", 0, {"a strength", -1e6, 1e6});
    source.softening_m = t.number("softening_m", 0.01, {"a length", 1e-4, 1e3});
    t.finish();
    (void)scene_.effect_data.attraction.try_push(source);
  }
}

void EffectReader::find_drag() {
  if (density_kg_per_m3_ * drag_coefficient_ == 0) return;
  auto& per_m = scene_.effect_data.drag_per_m;
  for (const auto& body : scene_.bodies)
    if (body.kind == BodyKind::kDynamic)
      entry_of(per_m, body.id) =
          density_kg_per_m3_ * drag_coefficient_ * area_across(scene_, body.shape) / (2 * body.mass);
}

void EffectReader::finish(text::TableReader& root) {
  find_drag();
  for (const auto& effect : known_effects())
    if (scene_.effects.*effect.declared && !effect.used(scene_))
      root.warning("effects", fmt::format("\"{}\" is declared and not used: {}", effect.name, effect.unused),
                   "leave it out");
}

}  // namespace tactus::sim
