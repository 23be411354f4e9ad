#include "sim/exchange/contact_graph.h"

#include <algorithm>

namespace tactus::sim {

ContactEdge contact_edge_of(std::span<const physics::Contact> contacts, std::span<const physics::Body> bodies,
                            std::span<const BodyIndex> awake) noexcept {
  Vec3d weighted, plain;
  double weight = 0, hardest = 0;
  std::uint32_t points = 0;
  const physics::Contact* hardest_contact = &contacts[0];
  for (const physics::Contact& contact : contacts) {
    double here = 0;
    for (std::uint32_t i = 0; i < contact.count; ++i) {
      const auto& point = contact.points[i];
      weighted += point.total_normal_impulse * point.from_a;
      here += point.total_normal_impulse;
      plain += point.from_a;
    }
    points += contact.count;
    weight += here;
    if (here > hardest) hardest_contact = &contact;
    hardest = std::max(hardest, here);
  }
  const Vec3d from_a = weight > 0 ? weighted * (1 / weight) : plain * (1.0 / std::max(1u, points));
  const std::uint32_t a = contacts[0].slot_a;
  return {.a = awake[a],
          .b = awake[contacts[0].slot_b],
          .point = bodies[a].motion.pose.position + from_a,
          .normal = hardest_contact->normal,
          .joined = false};
}

ContactGraph::ContactGraph(std::uint32_t max_bodies, std::uint32_t max_touches)
    : touches_(max_touches),
      links_(2 * std::size_t{max_touches}),
      first_(max_bodies + 1),
      hops_(max_bodies, kNoPath),
      queue_(max_bodies) {}

void ContactGraph::build(std::uint32_t bodies, std::span<const ContactEdge> touches) noexcept {
  TACTUS_CHECK(bodies < first_.size(), bodies, first_.size());
  TACTUS_CHECK(touches.size() <= touches_.size(), touches.size(), touches_.size());
  body_count_ = bodies;
  touch_count_ = static_cast<std::uint32_t>(touches.size());
  std::copy(touches.begin(), touches.end(), touches_.begin());
  std::fill(first_.begin(), first_.begin() + bodies + 1, 0u);
  for (const ContactEdge& touch : touches) {
    ++first_[number_of(touch.a)];
    ++first_[number_of(touch.b)];
  }
  // Ends of the bodies' links; filling backwards turns them into the starts and keeps the order.
  for (std::uint32_t i = 1; i < bodies; ++i) first_[i] += first_[i - 1];
  first_[bodies] = 2 * touch_count_;
  for (std::uint32_t t = touch_count_; t-- > 0;) {
    links_[--first_[number_of(touches_[t].a)]] = {touches_[t].b, t};
    links_[--first_[number_of(touches_[t].b)]] = {touches_[t].a, t};
  }
  hops_.fill(kNoPath);
  visited_count_ = 0;
}

std::span<const ContactGraph::Link> ContactGraph::links(BodyIndex body) const noexcept {
  const std::uint32_t i = number_of(body);
  return {links_.data() + first_[i], first_[i + 1] - first_[i]};
}

std::uint32_t ContactGraph::find_component(BodyIndex from, std::span<const BodyIndex> seeds) noexcept {
  for (const BodyIndex body : visited()) hops_[body] = kNoPath;
  visited_count_ = 0;
  visit(from, 0);
  for (std::uint32_t head = 0; head < visited_count_; ++head) {
    const BodyIndex body = queue_[head];
    for (const Link& link : links(body)) visit(link.body, hops_[body] + 1);
    if (head == 0)
      for (const BodyIndex seed : seeds) visit(seed, 1);
  }
  return visited_count_;
}

void ContactGraph::visit(BodyIndex body, std::uint32_t hops) noexcept {
  if (hops_[body] != kNoPath) return;
  hops_[body] = hops;
  queue_[visited_count_++] = body;
}

}  // namespace tactus::sim
