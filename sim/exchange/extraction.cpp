#include "sim/exchange/extraction.h"

namespace tactus::sim {

Extraction::Extraction(const ExtractionOptions& options, const ReachSettings& reach,
                       BodySpan<const physics::Body> bodies, BodyIndex proxy, std::uint32_t max_touches)
    : options_(options),
      proxy_(proxy),
      cube_(reach, bodies, proxy),
      influence_(static_cast<std::uint32_t>(bodies.size()), max_touches),
      member_(bodies.size(), 0),
      was_member_(bodies.size(), 0),
      listed_(bodies.size(), 0),
      cycles_out_(bodies.size(), 0) {
  TACTUS_CHECK(!options.all_members || bodies.size() <= haptics::kMaxMembers, bodies.size(), haptics::kMaxMembers);
  candidates_.reserve(bodies.size() + 1);
  chosen_.reserve(bodies.size());
  near_.reserve(bodies.size());
  group_.reserve(bodies.size());
}

std::span<const BodyIndex> Extraction::choose(BodySpan<const physics::Body> bodies, ContactGraph& graph,
                                              const Posed& world_from_proxy, std::uint32_t budget,
                                              BodySpan<const std::uint8_t> free,
                                              std::span<const BodyIndex> awake) noexcept {
  const std::uint32_t cap = std::max(1u, std::min({options_.cap, budget, haptics::kMaxMembers}));
  was_member_ = member_;
  statistics_ = {};
  statistics_.component = graph.find_component(proxy_);
  const auto close = cube_.find(bodies, world_from_proxy, awake);
  statistics_.close = static_cast<std::uint32_t>(close.size());
  if (options_.all_members) {
    take_all(static_cast<std::uint32_t>(bodies.size()));
  } else {
    candidates_.clear();
    listed_.fill(0);
    add(Priority::kProxy, 0, proxy_);
    add_close(close, free);
    add_linked(bodies, graph, cap, free);
    add_former(graph, free);
    take(cap, graph, free);
    graph.find_component(proxy_);  // again: breadth first has searched from the close bodies too
    count_left_out(cap, graph);
  }
  first_ = false;
  return chosen_;
}

bool Extraction::available(BodyIndex index, BodySpan<const std::uint8_t> free) const noexcept {
  return listed_[index] == 0 && (free.empty() || free[index] != 0);
}

void Extraction::add(Priority priority, double score, BodyIndex index) noexcept {
  listed_[index] = 1;
  if (priority <= Priority::kLinked) cycles_out_[index] = 0;
  candidates_.push_back({.priority = priority, .current = was_member_[index] != 0, .score = score, .index = index});
}

void Extraction::add_close(std::span<const CloseBody> close, BodySpan<const std::uint8_t> free) noexcept {
  near_.clear();
  for (const CloseBody& body : close) {
    near_.push_back(body.index);
    if (available(body.index, free)) add(Priority::kClose, -body.gap_m, body.index);
  }
}

void Extraction::add_linked(BodySpan<const physics::Body> bodies, ContactGraph& graph, std::uint32_t cap,
                            BodySpan<const std::uint8_t> free) noexcept {
  if (options_.order == CutOrder::kBestFirst) {
    for (const Influenced& body : influence_.find(graph, bodies, proxy_, near_, cap))
      if (available(body.index, free))
        add(Priority::kLinked, (was_member_[body.index] != 0 ? 2 : 1) * body.influence, body.index);
    return;
  }
  graph.find_component(proxy_, near_);
  std::uint32_t last_hop = ContactGraph::kNoPath;
  for (const BodyIndex index : graph.visited()) {
    const std::uint32_t hops = graph.hops(index);
    if (hops > last_hop) break;  // beyond any that the cap could admit
    if (available(index, free))
      add(Priority::kLinked, -static_cast<double>(hops - (was_member_[index] != 0 ? 1 : 0)), index);
    if (last_hop == ContactGraph::kNoPath && candidates_.size() >= cap) last_hop = hops + 1;
  }
}

// Adds members that no longer qualify, group by group of those that contacts connect: a group stays until its last body
// has not qualified for linger_cycles, while the cap allows.
void Extraction::add_former(const ContactGraph& graph, BodySpan<const std::uint8_t> free) noexcept {
  for (const BodyIndex first : chosen_) {
    if (!available(first, free)) continue;
    group_.clear();
    const auto visit = [&](BodyIndex index) noexcept {
      listed_[index] = 1;
      ++cycles_out_[index];
      group_.push_back(index);
    };
    visit(first);
    std::uint32_t out = cycles_out_[first];
    for (std::size_t head = 0; head < group_.size(); ++head) {
      out = std::min(out, cycles_out_[group_[head]]);
      for (const ContactGraph::Link& link : graph.links(group_[head]))
        if (was_member_[link.body] != 0 && available(link.body, free)) visit(link.body);
    }
    if (out > options_.linger_cycles) continue;
    for (const BodyIndex index : group_) add(Priority::kLingering, -static_cast<double>(out), index);
  }
}

void Extraction::take(std::uint32_t cap, const ContactGraph& graph, BodySpan<const std::uint8_t> free) noexcept {
  std::sort(candidates_.begin(), candidates_.end(), [](const Candidate& a, const Candidate& b) {
    if (a.priority != b.priority) return a.priority < b.priority;
    if (a.score != b.score) return a.score > b.score;
    return a.current != b.current ? a.current : a.index < b.index;
  });
  const auto before = static_cast<std::uint32_t>(chosen_.size());
  chosen_.clear();
  member_.fill(0);
  std::uint32_t stay = 0;
  for (const Candidate& candidate : candidates_) {
    if (chosen_.size() == cap) break;
    if (member_[candidate.index] != 0) continue;  // already chosen because of a joint
    if (!candidate.current) {
      const bool may_join = first_ || candidate.priority <= Priority::kClose || statistics_.joins < options_.max_joins;
      if (!may_join) continue;
    }
    const auto first = chosen_.size();
    member_[candidate.index] = 1;
    chosen_.push_back(candidate.index);
    bring_joined(cap, graph, free);
    for (auto i = first; i < chosen_.size(); ++i) ++(was_member_[chosen_[i]] != 0 ? stay : statistics_.joins);
  }
  statistics_.leaves = before - stay;
  std::sort(chosen_.begin(), chosen_.end());
}

// Adds all bodies that joints connect to the last one chosen, directly or not, breadth first.
void Extraction::bring_joined(std::uint32_t cap, const ContactGraph& graph,
                              BodySpan<const std::uint8_t> free) noexcept {
  for (std::size_t head = chosen_.size() - 1; head < chosen_.size(); ++head)
    for (const auto& link : graph.links(chosen_[head])) {
      if (!graph.touches()[link.touch].joined || member_[link.body] != 0 || chosen_.size() >= cap) continue;
      if (!free.empty() && free[link.body] == 0) continue;
      member_[link.body] = 1;
      chosen_.push_back(link.body);
    }
}

void Extraction::take_all(std::uint32_t bodies) noexcept {
  statistics_.joins = bodies - static_cast<std::uint32_t>(chosen_.size());
  chosen_.clear();
  for (const BodyIndex index : BodyIndices(bodies)) chosen_.push_back(index);
  member_.fill(1);
}

void Extraction::count_left_out(std::uint32_t cap, const ContactGraph& graph) noexcept {
  std::uint32_t wanted = statistics_.component, inside = 0;
  const auto in_component = [&](BodyIndex index) { return graph.hops(index) != ContactGraph::kNoPath; };
  for (const BodyIndex index : near_) {
    if (!in_component(index)) ++wanted;
    if (member_[index] == 0) ++statistics_.close_left_out;
    if (member_[index] != 0 && !in_component(index)) ++inside;
  }
  for (const BodyIndex index : chosen_)
    if (in_component(index)) ++inside;
  statistics_.dropped = wanted > cap ? wanted - cap : 0;
  const std::uint32_t left_out = wanted - inside;
  statistics_.waiting = left_out > statistics_.dropped ? left_out - statistics_.dropped : 0;
}

}  // namespace tactus::sim
