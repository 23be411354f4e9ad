// Chooses the buffer of a sub-world (rt/haptics/coupling/border_buffer.h): members that touch an outside body or are
// joined to one, and all members of a group at the border whose masses are uneven. A group is a set of members that
// contacts and joints connect, without the proxy.
//
// Reason for the rule on masses: a light body between a heavy one and a ghost is constrained from both sides. A
// Gauss-Seidel sweep reduces an error of the impulse through it by the product of w / (w + W) over both sides, w: its
// inverse mass, W: the neighbour's. With a heavy ghost the factor is R / (1 + R), R: the heavy body's mass over the
// light one's. A synchronisation displaces the light body, which is in the buffer; the biased sweep then pushes the
// heavy body, and the relax sweeps leave (R / (1 + R))^sweeps of that push, as momentum that no contact transmitted. If
// the heavy body is an inner member, this momentum is imposed on the global world, returns with the next snapshot and
// accumulates: a light stack below sways and falls. As a buffer body it imposes nothing. The rule does not change the
// choice of members.
//
// A member with one link in its group is at an end of the group. There the product is known: w of either body at the
// contact point along the normal; W of the ghost; W = 0 for static geometry and joints. If the product is at most
// R / (1 + R) for the largest R allowed, the member's mass does not count. Examples: a table's leg, 0.3 kg at the
// corner of a top of 2 kg (which is 0.43 kg there), and cubes on the top that carry outside cubes. A body that rests on
// another and touches nothing else is not constrained from both sides. Within a group light bodies may be in series,
// which converge as slowly as the lightest with the heaviest: their masses count. tests/border/table.toml, six members,
// ratios 2, 8, 16, 10 s: 1.9, 1.4, 1.4 % off; with all masses counted 2.6, 2.6, 2.9 %. With contacts twice as stiff
// (1000 Hz) 2.2, 2.1, 2.3 % instead of 2.6, 2.8, 2.8 %. The limit on the product may be from 0.6, below which the leg
// counts, to below 0.75, where the stack of R = 3 that is measured below would stay in the sub-world.
//
// The proxy is always imposed, since the device holds it. Measured range of kMaxUneven (stack of five cubes at
// 1000 Hz, 0.25 / sub-step, the uppermost R times as heavy, 3 to 5 members, ratios 2, 8 and 16, 8 s; force error
// without the rule, with it): R = 1: 0.1 %, not needed; 3: 3.8 %, 0.6 %; 10: 15 %, 10 mm off, 1.2 %; 30: 15 %, 1.4 %;
// 100: 42 %, 2.2 %; 300: falls, 7 %; 1000: falls, 44 %. The last two equal those of a sub-world with the proxy alone (7
// and 44 %): there the global step itself comes to rest 0.1 to 0.3 mm from the direct run. With a limit of 0 every
// group is in the buffer: then a fast push loses energy (the pile of `experiment energy-loss` at ratio 8: 1.7 % instead
// of 0.2 %).
//
// Thread: the global world's; construction [setup]; allocates nothing. Work: linear in bodies and touches; where a
// group is uneven, in contacts too.
#pragma once

#include <vector>

#include "rt/physics/islands.h"
#include "sim/exchange/extraction.h"

namespace tactus::sim {

class BufferChoice {
 public:
  static constexpr double kMaxUneven = 2;  // max heaviest over lightest mass of a group whose members may be imposed

  // Constraints on members from outside their group, of the last step; all empty before the first one.
  struct Surroundings {
    std::span<const physics::Contact> contacts;     // of the world, with static geometry included
    std::span<const BodyIndex> awake;               // by slot
    std::span<const haptics::OutsideBody> outside;  // ghosts of the next cycle, ascending ids
  };

  explicit BufferChoice(std::uint32_t max_bodies)
      : parent_(max_bodies),
        lightest_(max_bodies),
        heaviest_(max_bodies),
        at_border_(max_bodies),
        shares_(max_bodies) {}

  // Marks the buffer bodies among the chosen members; never the proxy. Returns how many of them are in the
  // buffer only because their group is uneven.
  std::uint32_t choose(BodySpan<const physics::Body> bodies, const Extraction& extraction, const ContactGraph& graph,
                       BodyIndex proxy, const Surroundings& around, BodySpan<std::uint8_t> in_buffer) noexcept;

 private:
  // Error factors of a sweep for a member, w / (w + W): `linked` against the last member linked to it, `other` the
  // largest against anything that is not a member.
  struct Shares {
    static constexpr double kMaxLeft = kMaxUneven / (1 + kMaxUneven);
    double linked{0}, other{0};
    std::uint32_t links{0};  // to members other than the proxy
    bool at_end() const noexcept { return links == 1 && linked * other <= kMaxLeft; }
  };

  // Finds the lightest and heaviest mass of every group; a member at_end does not count for the lightest. True if a
  // group at the border is uneven.
  bool weigh(BodySpan<const physics::Body> bodies, const Extraction& extraction, BodySpan<const std::uint8_t> in_buffer,
             physics::Islands& groups) noexcept;
  void find_shares(BodySpan<const physics::Body> bodies, const Extraction& extraction, const ContactGraph& graph,
                   BodyIndex proxy, const Surroundings& around) noexcept;
  bool is_uneven(BodyIndex group) const noexcept {
    return at_border_[group] != 0 && heaviest_[group] > kMaxUneven * lightest_[group];
  }

  std::vector<std::uint32_t> parent_;       // by number_of(body): union-find parents of the groups
  BodyVector<double> lightest_, heaviest_;  // kg, of a group, at its lowest body
  BodyVector<std::uint8_t> at_border_;      // same: 1 if a member touches an outside body
  BodyVector<Shares> shares_;
};

}  // namespace tactus::sim
