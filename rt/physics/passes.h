// In how many passes a long step is taken.
//
// Contacts are found once in a pass and their points stay with the bodies; between, gaps follow from the motion. A
// body that goes far in a pass leaves its points behind: a ball rolls off its own, a tip slides past an edge, what is
// fast is not seen coming (max_margin). A haptic tick is short enough and always one pass; a global step of many ticks
// is taken in as many passes as its fastest body needs, each with its own begin_step and finish_step of the pass's
// settings. Sub-steps stay as long as they are, so warm starts go on as within one step, and a world at rest, or slow,
// has one pass and pays nothing. Not for a world with border contacts: those are given for a whole step. A spring's
// target is given anew for each pass.
// Thread: the owner of the World. Units: SI. Bound: linear in bodies and contacts; as many passes as milliseconds or
// sub-steps.
#pragma once

#include <algorithm>
#include <cmath>

#include "rt/physics/world.h"

namespace tactus::physics {

// In a pass a body's surface moves by no more than this part of its half thickness.
inline constexpr double kMotionInPass = 0.25;
inline constexpr double kShortestPass = 1e-3;  // s

inline double half_thickness(const Shape& shape) noexcept {
  const Vec3d& half = shape.half_extents;
  const bool round = shape.kind == ShapeKind::kSphere || shape.kind == ShapeKind::kCapsule;
  return round ? shape.radius : std::min({half.x, half.y, half.z});
}

// What is round and touches goes on by no more than this [m]: its point, carried along by d, is off by d^2 / 2 r, and
// within the overlap that contacts leave alone that neither lets it sink nor pushes it out.
inline double most_along_contact(double radius, const StepSettings& settings) noexcept {
  return std::sqrt(2.0 * settings.slop * radius);
}

// At least 1, a divisor of the sub-steps. `left_out`, by slot: 1 where another world knows better how the body moves.
inline std::uint32_t passes_of(const World& world, const StepSettings& settings,
                               std::span<const std::uint8_t> left_out = {}) noexcept {
  const double most = std::min(settings.dt / kShortestPass * (1.0 + 1e-6), static_cast<double>(settings.sub_steps));
  if (most < 2.0) return 1;
  double needed = 1.0;
  const auto count = [&](double moved, double allowed) noexcept {  // nothing allowed: the most
    if (moved > needed * allowed) needed = std::min(moved / allowed, most);
  };
  const auto counts = [&](std::uint32_t slot) noexcept { return left_out.empty() || left_out[slot] == 0; };
  const std::span<const Body> bodies = world.bodies();
  for (std::uint32_t i = 0; i < bodies.size(); ++i) {
    const Twistd& v = bodies[i].motion.velocity;
    const double speed = norm(v.linear) + norm(v.angular) * bounding_radius(bodies[i].shape);
    if (counts(i)) count(settings.dt * speed, kMotionInPass * half_thickness(bodies[i].shape));
  }
  const auto roll = [&](std::uint32_t slot) noexcept {
    const Body& body = bodies[slot];
    const bool round = body.shape.kind == ShapeKind::kSphere || body.shape.kind == ShapeKind::kCapsule;
    if (!round || !counts(slot)) return;
    const Twistd& v = body.motion.velocity;
    count(settings.dt * std::max(norm(v.linear), norm(v.angular) * body.shape.radius),
          most_along_contact(body.shape.radius, settings));
  };
  for (const Contact& contact : world.contacts()) {
    if (!contact.touching()) continue;
    roll(contact.slot_a);
    if (!contact.b_fixed) roll(contact.slot_b);
  }
  const auto top = static_cast<std::uint32_t>(most);
  std::uint32_t passes = std::min(top, static_cast<std::uint32_t>(std::ceil(needed)));
  while (passes < top && settings.sub_steps % passes != 0) ++passes;
  while (settings.sub_steps % passes != 0) --passes;
  return passes;
}

inline StepSettings settings_of_pass(const StepSettings& settings, std::uint32_t passes) noexcept {
  StepSettings pass = settings;
  pass.dt = settings.dt / static_cast<double>(passes), pass.sub_steps = settings.sub_steps / passes;
  return pass;
}

}  // namespace tactus::physics
