#include "sim/exchange/extraction.h"

namespace tactus::sim {

Extraction::Extraction(const ExtractionOptions& options, const ReachSettings& reach,
                       std::span<const physics::Body> bodies, std::uint32_t proxy, std::uint32_t max_touches)
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
}

std::span<const std::uint32_t> Extraction::choose(std::span<const physics::Body> bodies, ContactGraph& graph,
                                                  const Posed& world_from_proxy, std::uint32_t budget,
                                                  std::span<const std::uint8_t> free,
                                                  std::span<const std::uint32_t> awake) noexcept {
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
    std::fill(listed_.begin(), listed_.end(), std::uint8_t{0});
    add(Priority::kProxy, 0, proxy_);
    add_close(close, free);
    add_linked(bodies, graph, cap, free);
    add_former();
    take(cap, graph, free);
    graph.find_component(proxy_);  // again: breadth first has searched from the close bodies too
    count_left_out(cap, graph);
  }
  first_ = false;
  return chosen_;
}

bool Extraction::available(std::uint32_t slot, std::span<const std::uint8_t> free) const noexcept {
  return listed_[slot] == 0 && (free.empty() || free[slot] != 0);
}

void Extraction::add(Priority priority, double score, std::uint32_t slot) noexcept {
  listed_[slot] = 1;
  if (priority <= Priority::kLinked) cycles_out_[slot] = 0;
  candidates_.push_back({priority, was_member_[slot] != 0, score, slot});
}

void Extraction::add_close(std::span<const CloseBody> close, std::span<const std::uint8_t> free) noexcept {
  near_.clear();
  for (const CloseBody& body : close) {
    near_.push_back(body.slot);
    if (available(body.slot, free)) add(Priority::kClose, -body.gap_m, body.slot);
  }
}

void Extraction::add_linked(std::span<const physics::Body> bodies, ContactGraph& graph, std::uint32_t cap,
                            std::span<const std::uint8_t> free) noexcept {
  if (options_.order == CutOrder::kBestFirst) {
    for (const Influenced& body : influence_.find(graph, bodies, proxy_, near_, cap))
      if (available(body.slot, free))
        add(Priority::kLinked, (was_member_[body.slot] != 0 ? 2 : 1) * body.influence, body.slot);
    return;
  }
  graph.find_component(proxy_, near_);
  std::uint32_t last_hop = ContactGraph::kUnreached;
  for (const std::uint32_t slot : graph.visited()) {
    const std::uint32_t hops = graph.hops(slot);
    if (hops > last_hop) break;  // beyond any that the cap could admit
    if (available(slot, free))
      add(Priority::kLinked, -static_cast<double>(hops - (was_member_[slot] != 0 ? 1 : 0)), slot);
    if (last_hop == ContactGraph::kUnreached && candidates_.size() >= cap) last_hop = hops + 1;
  }
}

// Adds members that no longer qualify; they stay for linger_cycles while the cap allows.
void Extraction::add_former() noexcept {
  for (const std::uint32_t slot : chosen_) {
    if (listed_[slot] != 0) continue;
    const std::uint32_t out = ++cycles_out_[slot];
    add(out <= options_.linger_cycles ? Priority::kLingering : Priority::kLeaving, -static_cast<double>(out), slot);
  }
}

void Extraction::take(std::uint32_t cap, const ContactGraph& graph, std::span<const std::uint8_t> free) noexcept {
  std::sort(candidates_.begin(), candidates_.end(), [](const Candidate& a, const Candidate& b) {
    if (a.priority != b.priority) return a.priority < b.priority;
    if (a.score != b.score) return a.score > b.score;
    return a.current != b.current ? a.current : a.slot < b.slot;
  });
  const auto before = static_cast<std::uint32_t>(chosen_.size());
  chosen_.clear();
  std::fill(member_.begin(), member_.end(), std::uint8_t{0});
  std::uint32_t stay = 0;
  for (const Candidate& candidate : candidates_) {
    if (chosen_.size() == cap) break;
    if (member_[candidate.slot] != 0) continue;  // brought along by a joint
    if (!candidate.current) {
      const bool may_join = first_ || candidate.priority <= Priority::kClose || statistics_.joins < options_.max_joins;
      if (!may_join) continue;
    } else {
      // Members past linger_cycles stay only if more than max_leaves would leave at once.
      if (candidate.priority == Priority::kLeaving && before - stay <= options_.max_leaves) break;
    }
    const auto first = chosen_.size();
    member_[candidate.slot] = 1;
    chosen_.push_back(candidate.slot);
    bring_joined(cap, graph, free);
    for (auto i = first; i < chosen_.size(); ++i) ++(was_member_[chosen_[i]] != 0 ? stay : statistics_.joins);
  }
  statistics_.leaves = before - stay;
  std::sort(chosen_.begin(), chosen_.end());
}

// Adds all bodies that joints connect to the last one chosen, directly or not, breadth first.
void Extraction::bring_joined(std::uint32_t cap, const ContactGraph& graph,
                              std::span<const std::uint8_t> free) noexcept {
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
  for (std::uint32_t slot = 0; slot < bodies; ++slot) chosen_.push_back(slot);
  std::fill(member_.begin(), member_.end(), std::uint8_t{1});
}

void Extraction::count_left_out(std::uint32_t cap, const ContactGraph& graph) noexcept {
  std::uint32_t wanted = statistics_.component, inside = 0;
  const auto in_component = [&](std::uint32_t slot) { return graph.hops(slot) != ContactGraph::kUnreached; };
  for (const std::uint32_t slot : near_) {
    if (!in_component(slot)) ++wanted;
    if (member_[slot] == 0) ++statistics_.close_left_out;
    if (member_[slot] != 0 && !in_component(slot)) ++inside;
  }
  for (const std::uint32_t slot : chosen_)
    if (in_component(slot)) ++inside;
  statistics_.dropped = wanted > cap ? wanted - cap : 0;
  const std::uint32_t left_out = wanted - inside;
  statistics_.waiting = left_out > statistics_.dropped ? left_out - statistics_.dropped : 0;
}

}  // namespace tactus::sim
