#include "rt/physics/macro_steps.h"

#include <algorithm>
#include <cmath>

namespace tactus::physics {
namespace {

// Largest motion of a body's surface in a macro step, as a share of its half thickness.
constexpr double kMotionInPass = 0.25;
constexpr double kShortestPass = 1e-3;  // s

// Largest motion of a round body along its contact in a macro step [m]. When the contact point moves by d along the
// surface, the error of its gap is d^2 / (2 r); as long as this is within the slop, the body neither sinks nor is
// pushed out.
double most_along_contact(double radius, const StepSettings& settings) noexcept {
  return std::sqrt(2.0 * settings.slop * radius);
}

bool rolls(const Shape& shape) noexcept { return traits_of(shape.kind).rolls; }

}  // namespace

std::uint32_t macro_steps_of(const World& world, const StepSettings& settings,
                             std::span<const std::uint8_t> left_out) noexcept {
  const double most = std::min(settings.dt / kShortestPass * (1.0 + 1e-6), static_cast<double>(settings.sub_steps));
  if (most < 2.0) return 1;
  double needed = 1.0;
  const auto count = [&](double moved, double allowed) noexcept {  // allowed = 0: the most macro steps
    if (moved > needed * allowed) needed = std::min(moved / allowed, most);
  };
  const auto counts = [&](std::uint32_t slot) noexcept { return left_out.empty() || left_out[slot] == 0; };
  const std::span<const Body> bodies = world.bodies();
  for (std::uint32_t i = 0; i < bodies.size(); ++i) {
    const Twistd& v = bodies[i].motion.velocity;
    const double speed = norm(v.linear) + norm(v.angular) * bounding_radius(bodies[i].shape);
    if (counts(i)) count(settings.dt * speed, kMotionInPass * half_thickness(bodies[i].shape));
  }
  // `part`: the shape of the body that touches.
  const auto roll = [&](std::uint32_t slot, std::uint32_t part) noexcept {
    const Body& body = bodies[slot];
    const Shape& shape = part_shape(body.shape, part, world.shapes().compounds);
    if (!rolls(shape) || !counts(slot)) return;
    const Twistd& v = body.motion.velocity;
    count(settings.dt * std::max(norm(v.linear), norm(v.angular) * shape.radius),
          most_along_contact(shape.radius, settings));
  };
  // A body that slides over a fixed round shape: the contact point moves around that shape by up to the body's motion.
  const auto slide = [&](const Contact& contact) noexcept {
    const Body &body = bodies[contact.slot_a], &fixed = world.fixed_bodies()[contact.slot_b];
    const Shape& shape = part_shape(fixed.shape, contact.key.part_of(fixed.id), world.shapes().compounds);
    if (!rolls(shape) || !counts(contact.slot_a)) return;
    const Twistd& v = body.motion.velocity;
    count(settings.dt * (norm(v.linear) + norm(v.angular) * bounding_radius(body.shape)),
          most_along_contact(shape.radius, settings));
  };
  for (const Contact& contact : world.contacts()) {
    if (!contact.touching()) continue;
    if (contact.b_fixed) slide(contact);
    const std::uint32_t a = contact.slot_a;
    roll(a, contact.key.part_of(bodies[a].id));
    if (!contact.b_fixed) roll(contact.slot_b, contact.key.part_of(bodies[contact.slot_b].id));
  }
  const auto top = static_cast<std::uint32_t>(most);
  std::uint32_t macro_steps = std::min(top, static_cast<std::uint32_t>(std::ceil(needed)));
  while (macro_steps < top && settings.sub_steps % macro_steps != 0) ++macro_steps;
  while (settings.sub_steps % macro_steps != 0) --macro_steps;
  return macro_steps;
}

StepSettings settings_of_macro_step(const StepSettings& settings, std::uint32_t macro_steps) noexcept {
  StepSettings macro_step = settings;
  macro_step.dt = settings.dt / static_cast<double>(macro_steps);
  macro_step.sub_steps = settings.sub_steps / macro_steps;
  return macro_step;
}

}  // namespace tactus::physics
