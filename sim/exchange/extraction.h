// Chooses the next members of the haptic sub-world: the contact graph, grown from the proxy and cut at the cap.
//
// Order, until the cap: the proxy; bodies in the boundary cube, nearest first; bodies that contacts connect to the
// proxy, by influence (or by hops, as the paper may have meant); former members that qualified until a few cycles ago.
// Hysteresis: a present member's influence counts double (its hops one less), and a member that no longer qualifies
// stays for linger_cycles while the cap allows. Members that no longer qualify and touch each other leave together, so
// that the border does not separate bodies that collide: at the border the force of an impact is the least exact. With
// each chosen body, the bodies that joints connect to it are chosen. Few bodies join per cycle, so that the tick that
// imports them stays short; only bodies in the cube and joined bodies may exceed max_joins. So the sub-world grows over
// several cycles, as in the paper. Thread: the global world's; construction [setup]. Units: SI. Bound: the cap, never
// exceeded; bodies left out are counted. Ties by index, which is by body id. Source: the paper, section 2; influence in
// sim/exchange/influence.h.
#pragma once

#include "rt/haptics/coupling/snapshot.h"
#include "sim/exchange/boundary_cube.h"
#include "sim/exchange/influence.h"

namespace tactus::sim {

enum class CutOrder : std::uint32_t {
  kBestFirst = 0,     // by influence on the proxy
  kBreadthFirst = 1,  // by contacts from the proxy
};

struct ExtractionOptions {
  std::uint32_t cap{64};  // members, the proxy included; at most haptics::kMaxMembers
  CutOrder order{CutOrder::kBestFirst};
  std::uint32_t max_joins{8};      // per cycle; the cube may join more
  std::uint32_t linger_cycles{4};  // cycles that a member stays after it, or a member that it touches, last qualified
  bool all_members{false};         // every dynamic body is a member from the start; at most kMaxMembers bodies
};

struct ExtractionStatistics {
  std::uint32_t component{0};       // bodies that contacts connect to the proxy, the proxy included
  std::uint32_t close{0};           // bodies in the boundary cube
  std::uint32_t close_left_out{0};  // of `close`, left out by the cap: the proxy may touch them before they join
  std::uint32_t dropped{0};         // bodies of cube and component that the cap leaves out
  std::uint32_t waiting{0};         // bodies of cube and component that will join in the next cycles
  std::uint32_t joins{0}, leaves{0};
};

class Extraction {
 public:
  Extraction(const ExtractionOptions& options, const ReachSettings& reach, BodySpan<const physics::Body> bodies,
             BodyIndex proxy, std::uint32_t max_touches);

  // Chooses the next members, ascending. `world_from_proxy`: centre of the cube. `budget` may lower the cap.
  // `free`: 1 for bodies that may be members (empty: all); a member with 0 leaves at once. `awake`: the bodies to test
  // for the cube (empty: all). The first call is not limited by max_joins. Valid until the next call.
  std::span<const BodyIndex> choose(BodySpan<const physics::Body> bodies, ContactGraph& graph,
                                    const Posed& world_from_proxy, std::uint32_t budget,
                                    BodySpan<const std::uint8_t> free = {},
                                    std::span<const BodyIndex> awake = {}) noexcept;
  // The boundary cube: bodies in it are chosen without a contact.
  physics::Aabb region(const physics::Body& proxy, const Posed& world_from_proxy) const noexcept {
    return cube_.region(proxy, world_from_proxy);
  }

  bool is_member(BodyIndex index) const noexcept { return member_[index] != 0; }
  bool was_member(BodyIndex index) const noexcept { return was_member_[index] != 0; }  // before the last choice
  // A member of the last choice that was not a member before it.
  bool is_joiner(BodyIndex index) const noexcept { return member_[index] != 0 && was_member_[index] == 0; }
  std::span<const BodyIndex> members() const noexcept { return chosen_; }
  BodySpan<const std::uint8_t> member_flags() const noexcept { return member_; }  // 1: member
  const ExtractionStatistics& statistics() const noexcept { return statistics_; }

 private:
  // In the order of choice.
  enum class Priority : std::uint32_t { kProxy = 0, kClose = 1, kLinked = 2, kLingering = 3 };
  struct Candidate {
    Priority priority{};
    bool current{false};  // a member before this choice
    double score{0};      // higher is chosen first
    BodyIndex index{};
  };

  bool available(BodyIndex index, BodySpan<const std::uint8_t> free) const noexcept;
  void add(Priority priority, double score, BodyIndex index) noexcept;
  void add_close(std::span<const CloseBody> close, BodySpan<const std::uint8_t> free) noexcept;
  void add_linked(BodySpan<const physics::Body> bodies, ContactGraph& graph, std::uint32_t cap,
                  BodySpan<const std::uint8_t> free) noexcept;
  void add_former(const ContactGraph& graph, BodySpan<const std::uint8_t> free) noexcept;
  void take(std::uint32_t cap, const ContactGraph& graph, BodySpan<const std::uint8_t> free) noexcept;
  void bring_joined(std::uint32_t cap, const ContactGraph& graph, BodySpan<const std::uint8_t> free) noexcept;
  void take_all(std::uint32_t bodies) noexcept;
  void count_left_out(std::uint32_t cap, const ContactGraph& graph) noexcept;

  ExtractionOptions options_;
  BodyIndex proxy_;
  BoundaryCube cube_;
  Influence influence_;
  bool first_{true};
  BodyVector<std::uint8_t> member_, was_member_, listed_;
  BodyVector<std::uint32_t> cycles_out_;  // cycles since it last qualified
  std::vector<Candidate> candidates_;
  std::vector<BodyIndex> chosen_, near_, group_;
  ExtractionStatistics statistics_;
};

}  // namespace tactus::sim
