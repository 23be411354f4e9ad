#include "sim/interface/buffer_choice.h"

#include <algorithm>

#include "rt/physics/islands.h"

namespace tactus::sim {

std::uint32_t BufferChoice::choose(std::span<const physics::Body> bodies, const Extraction& extraction,
                                   const ContactGraph& graph, std::uint32_t proxy,
                                   std::span<std::uint8_t> in_buffer) noexcept {
  std::fill(in_buffer.begin(), in_buffer.end(), std::uint8_t{0});
  physics::Islands groups(std::span<std::uint32_t>(parent_).first(bodies.size()));
  for (const Touch& touch : graph.touches()) {
    const bool a = extraction.is_member(touch.a), b = extraction.is_member(touch.b);
    if (a != b) in_buffer[a ? touch.a : touch.b] = 1;
    if (a && b && touch.a != proxy && touch.b != proxy) groups.link(touch.a, touch.b);
  }
  in_buffer[proxy] = 0;
  for (const std::uint32_t member : extraction.members()) {
    const std::uint32_t group = groups.of(member);
    if (group == member) lightest_[group] = heaviest_[group] = bodies[member].mass, at_border_[group] = 0;
    lightest_[group] = std::min(lightest_[group], bodies[member].mass);
    heaviest_[group] = std::max(heaviest_[group], bodies[member].mass);
    if (in_buffer[member] != 0) at_border_[group] = 1;
  }
  std::uint32_t added = 0;
  for (const std::uint32_t member : extraction.members()) {
    const std::uint32_t group = groups.of(member);
    if (member == proxy || in_buffer[member] != 0 || at_border_[group] == 0) continue;
    if (!(heaviest_[group] > kMostUneven * lightest_[group])) continue;
    in_buffer[member] = 1;
    ++added;
  }
  return added;
}

}  // namespace tactus::sim
