// Reads the keys of [[joint]].
#include <fmt/format.h>

#include <algorithm>
#include <numbers>

#include "rt/text/nearest_word.h"
#include "sim/loader/scene_load_effects.h"
#include "sim/model/given_pose.h"

namespace tactus::sim {
namespace {

using physics::BodyKind;
using physics::Joint;
using physics::JointKind;

constexpr text::Range kPlace{"a place", -1e4, 1e4};
constexpr text::Range kEffort{"a force or torque", 0, 1e9};
constexpr text::Range kAngle{"an angle within half a turn", -std::numbers::pi, std::numbers::pi};
constexpr text::Range kJointLength{"a length", 0, 1e3};
constexpr text::Range kShift{"a distance along the axis", -1e3, 1e3};

// A rotation that takes z to `axis`, a unit vector.
Quatd rotation_to(const Vec3d& axis) {
  const Vec3d z{0, 0, 1};
  if (dot(z, axis) < -1 + 1e-9) return {0, 1, 0, 0};
  const Vec3d turn = cross(z, axis);
  return normalized(Quatd{1 + dot(z, axis), turn.x, turn.y, turn.z});
}

}  // namespace

void EffectReader::read_joints(text::TableReader& root) {
  const auto nodes = root.array("joint", kMaxSceneJoints);
  if (!nodes.empty()) needs(root, "joint", &DeclaredEffects::joints);
  unsigned number = 0;
  for (const text::TomlNode& node : nodes) {
    text::TableReader t(&node, fmt::format("[joint.{}]", ++number), diagnostics_);
    if (t.there()) read_joint(t);
  }
}

// The body named by the key; kNoBody if the key is absent or the name is unknown.
BodyId EffectReader::read_end(text::TableReader& table, const char* key) {
  const std::string name = table.text(key, "", 100);
  if (name.empty()) return kNoBody;
  const auto found = ids_.find(name);
  if (found != ids_.end()) return found->second;
  std::vector<std::string_view> names;
  for (const auto& [known, id] : ids_) names.push_back(known);
  const auto nearest = text::nearest_word(name, names);
  table.mistake(key,
                fmt::format("no body is called \"{}\"{}", name,
                            nearest.empty() ? "" : fmt::format(", did you mean {}?", nearest)),
                "the name of a body, or \"proxy\"");
  return kNoBody;
}

void EffectReader::read_joint(text::TableReader& t) {
  const std::string kind = t.required_word("kind", kJointKinds);
  if (kind.empty()) return;
  Joint joint;
  joint.kind = static_cast<JointKind>(std::ranges::find(kJointKinds, kind) - kJointKinds.begin());

  const std::size_t mistakes = diagnostics_.mistakes.size();
  joint.a = read_end(t, "a");
  t.require("b", "the name of a moving body");
  joint.b = read_end(t, "b");
  if (diagnostics_.mistakes.size() == mistakes && scene_.bodies[joint.b].kind == BodyKind::kFixed)
    t.mistake("b", "is a fixed body", "a moving body; a fixed one is a, or leave a out");
  if (joint.b != kNoBody && joint.a == joint.b) t.mistake("b", "is the same body as a", "another body");
  const bool known = diagnostics_.mistakes.size() == mistakes;
  const Posed world_from_a = known && joint.a != kNoBody ? scene_.bodies[joint.a].motion.pose : Posed{};
  const Posed world_from_b = known ? scene_.bodies[joint.b].motion.pose : Posed{};

  const auto place_of = [&](BodyId body, const Posed& pose) { return given_pose(scene_, body, pose).position; };
  Posed at_a, at_b;  // world_from_joint, of A's and of B's side
  if (joint.kind == JointKind::kDistance) {
    at_a.position = t.vector("position_a_m", place_of(joint.a, world_from_a), kPlace);
    at_b.position = t.vector("position_b_m", place_of(joint.b, world_from_b), kPlace);
  } else {
    at_a.position = t.vector("position_m", place_of(joint.b, world_from_b), kPlace);
    if (joint.kind == JointKind::kHinge || joint.kind == JointKind::kSlider) {
      t.require("axis", "[x, y, z]: its direction in the world");
      const Vec3d axis = t.vector("axis", {0, 0, 1}, {"a direction", -1e6, 1e6});
      if (norm(axis) < 1e-6) t.mistake("axis", "has no direction", "[x, y, z], not all zero");
      at_a.rotation = rotation_to(normalized_or(axis, Vec3d{0, 0, 1}));
    }
    at_b = at_a;
  }
  joint.a_from_joint = inverse(world_from_a) * at_a;
  joint.b_from_joint = inverse(world_from_b) * at_b;
  joint.bodies_collide = t.flag("bodies_collide", false);
  read_limits(t, joint, norm(at_b.position - at_a.position));
  read_motor(t, joint);
  if (t.has("break_force_N")) joint.break_force_N = t.number("break_force_N", 0, kEffort);
  if (t.has("break_torque_Nm")) joint.break_torque_Nm = t.number("break_torque_Nm", 0, kEffort);
  t.finish();
  if (known) scene_.effect_data.joints.push_back(joint);
}

void EffectReader::read_limits(text::TableReader& t, Joint& joint, double at_start) {
  const auto between = [&](const char* low, const char* high, const text::Range& range) {
    joint.limited = t.has(low) || t.has(high);
    joint.low = t.number(low, range.low, range);
    joint.high = t.number(high, range.high, range);
    if (joint.low > joint.high)
      t.mistake(high, fmt::format("{} is below {}", joint.high, joint.low), fmt::format("at least {}", low));
  };
  if (joint.kind == JointKind::kHinge) between("low_rad", "high_rad", kAngle);
  if (joint.kind == JointKind::kSlider) between("low_m", "high_m", kShift);
  if (joint.kind != JointKind::kDistance) return;
  between("low_m", "high_m", kJointLength);
  const double length = t.number("length_m", at_start, kJointLength);
  if (joint.limited && t.has("length_m"))
    t.mistake("length_m", "there are limits already", "length_m, or low_m and high_m");
  if (!joint.limited) joint.low = joint.high = length;
  joint.limited = true;
}

void EffectReader::read_motor(text::TableReader& t, Joint& joint) {
  const bool turns = joint.kind == JointKind::kHinge;
  if (!turns && joint.kind != JointKind::kSlider) return;
  const char* speed = turns ? "motor_speed_rad_per_s" : "motor_speed_m_per_s";
  const char* effort = turns ? "motor_torque_Nm" : "motor_force_N";
  joint.driven = t.has(effort);
  joint.motor_speed = t.number(speed, 0, {"a speed", -1e3, 1e3});
  joint.motor_effort = t.number(effort, 0, kEffort);
  if (t.has(speed) && !joint.driven) t.mistake(speed, "there is no motor", fmt::format("{} as well", effort));
}

}  // namespace tactus::sim
