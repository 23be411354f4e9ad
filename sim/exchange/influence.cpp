#include "sim/exchange/influence.h"

#include <algorithm>
#include <cmath>

namespace tactus::sim {
namespace {

Vec3d inverse_inertia_times(const physics::Body& body, const Vec3d& v) noexcept {
  const Vec3d local = rotate_inverse(body.motion.pose.rotation, v);
  const auto over = [](double x, double inertia) { return inertia > 0 ? x / inertia : 0.0; };
  return rotate(body.motion.pose.rotation,
                Vec3d{over(local.x, body.inertia.x), over(local.y, body.inertia.y), over(local.z, body.inertia.z)});
}

double inverse_mass_of(const physics::Body& body) noexcept { return body.mass > 0 ? 1 / body.mass : 0; }

}  // namespace

Influence::Influence(std::uint32_t max_bodies, std::uint32_t max_touches)
    : sides_(max_touches),
      inverse_mass_(max_touches),
      best_(max_touches),
      prepared_(max_touches, 0),
      found_(max_bodies, 0) {
  heap_.reserve(4 * std::size_t{max_touches});
  result_.reserve(max_bodies);
}

// Order of a max-heap: true if `a` comes after `b`. Ties by index, then by contact.
bool Influence::ByValue::operator()(const Label& a, const Label& b) const noexcept {
  if (a.value != b.value) return a.value < b.value;
  return a.index != b.index ? a.index > b.index : a.touch > b.touch;
}

Influence::Side Influence::side_of(const ContactEdge& touch, const physics::Body& body) noexcept {
  const Vec3d lever_arm = cross(touch.point - body.motion.pose.position, touch.normal);
  return {.inverse_mass = inverse_mass_of(body),
          .normal = touch.normal,
          .lever_arm = lever_arm,
          .inertia_lever = inverse_inertia_times(body, lever_arm)};
}

double Influence::inverse_effective_mass(const Side& a, const Side& b) noexcept {
  return a.inverse_mass + dot(a.lever_arm, a.inertia_lever) + b.inverse_mass + dot(b.lever_arm, b.inertia_lever);
}

void Influence::prepare(std::uint32_t touch, std::span<const ContactEdge> touches,
                        BodySpan<const physics::Body> bodies) noexcept {
  if (prepared_[touch] == search_) return;
  prepared_[touch] = search_;
  sides_[touch] = {side_of(touches[touch], bodies[touches[touch].a]),
                   side_of(touches[touch], bodies[touches[touch].b])};
  inverse_mass_[touch] = inverse_effective_mass(sides_[touch][0], sides_[touch][1]);
  best_[touch] = {-1, -1};
}

void Influence::push(double value, BodyIndex index, std::uint32_t touch, std::uint32_t side) noexcept {
  if (value <= best_[touch][side]) return;
  best_[touch][side] = value;
  heap_.push_back({.value = value, .index = index, .touch = touch});
  std::push_heap(heap_.begin(), heap_.end(), ByValue{});
}

std::span<const Influenced> Influence::find(const ContactGraph& graph, BodySpan<const physics::Body> bodies,
                                            BodyIndex proxy, std::span<const BodyIndex> near,
                                            std::uint32_t enough) noexcept {
  ++search_;
  result_.clear();
  heap_.clear();
  found_[proxy] = search_;
  for (const auto& link : graph.links(proxy)) {
    prepare(link.touch, graph.touches(), bodies);
    push(1.0, link.body, link.touch, graph.touches()[link.touch].b == link.body ? 1 : 0);
  }
  for (const BodyIndex index : near) {
    heap_.push_back({.value = kNearDiscount, .index = index, .touch = kNear});
    std::push_heap(heap_.begin(), heap_.end(), ByValue{});
  }

  double floor = -1;
  while (!heap_.empty()) {
    std::pop_heap(heap_.begin(), heap_.end(), ByValue{});
    const Label label = heap_.back();
    heap_.pop_back();
    if (label.value < floor) break;
    if (found_[label.index] != search_) {
      found_[label.index] = search_;
      result_.push_back({label.index, label.value});
      if (result_.size() == enough) floor = 0.5 * label.value;
    }
    expand(label, graph, bodies, proxy);
  }
  return result_;
}

// Extends a path from a body through its other contacts.
void Influence::expand(const Label& label, const ContactGraph& graph, BodySpan<const physics::Body> bodies,
                       BodyIndex proxy) noexcept {
  const auto touches = graph.touches();
  Side in;
  double in_inverse_mass = 0;
  if (label.touch == kNear) {
    // The expected contact: along the line of centres, so without a moment on either body.
    const Vec3d apart = bodies[label.index].motion.pose.position - bodies[proxy].motion.pose.position;
    in = {.inverse_mass = inverse_mass_of(bodies[label.index]),
          .normal = normalized_or(apart, Vec3d{0, 0, 1}),
          .lever_arm = {},
          .inertia_lever = {}};
    in_inverse_mass = in.inverse_mass + inverse_mass_of(bodies[proxy]);
  } else {
    const std::uint32_t side = touches[label.touch].b == label.index ? 1 : 0;
    if (label.value < best_[label.touch][side]) return;  // a better path was found since
    in = sides_[label.touch][side];
    in_inverse_mass = inverse_mass_[label.touch];
  }
  for (const auto& link : graph.links(label.index)) {
    if (link.touch == label.touch || link.body == proxy) continue;
    prepare(link.touch, touches, bodies);
    const std::uint32_t to = touches[link.touch].b == link.body ? 1 : 0;
    const Side& out = sides_[link.touch][1 - to];
    const double coupled =
        std::abs(in.inverse_mass * dot(in.normal, out.normal) + dot(in.lever_arm, out.inertia_lever));
    const double scale = std::sqrt(in_inverse_mass * inverse_mass_[link.touch]);
    push(label.value * std::clamp(scale > 0 ? coupled / scale : 0.0, kMinTau, 1.0), link.body, link.touch, to);
  }
}

}  // namespace tactus::sim
