// Which members are the buffer of a sub-world (rt/haptics/coupling/border_buffer.h): those that touch an outside body or are
// joined to one; and the whole of a group of members at the border whose masses are uneven. A group is members that
// contacts and joints link, the proxy left out.
//
// Why no inner member of an uneven group is imposed. A light body between a heavy one and a ghost is held from both
// sides. Of an error of the impulse through it a Gauss-Seidel sweep leaves the product of w / (w + W) of both sides,
// w its inverse mass, W its neighbour's: with a heavy ghost R / (1 + R), R the heavy body's mass over the light one's.
// At a synchronisation the light body, in the buffer, is put elsewhere, and the biased sweep pushes the heavy body back
// by it; of that push the relax sweeps leave (R / (1 + R))^sweeps, as momentum that no contact gave. An inner body
// takes it to the global world, so it comes back and adds up: a light stack below sways and falls. In the buffer,
// nothing of it is imposed. The cut stays where the cap has it, but what it would harm is the global world's to move.
//
// A member with one link in its group is at an end of it, and there that product is known: w of either body at the
// touch along its normal, W of the ghost, 0 of static geometry and joints. Where it is at most R / (1 + R) of the most
// uneven R that is allowed, its mass does not count: a table's leg, 0.3 kg at the corner of a top of 2 kg (which is
// 0.43 kg there), and the cubes that lie on the top with cubes outside on them. What lies on a body with nothing else
// that holds it is not held from both sides. Within a group light bodies may be in series, which converge as slowly as
// the lightest with the heaviest: their masses count. tests/border/table.toml, six members, ratios 2, 8, 16, 10 s: 1.9,
// 1.4, 1.4 % off; with all masses counted 2.6, 2.6, 2.9 %. With contacts twice as firm (1000 Hz) 2.2, 2.1, 2.3 %
// instead of 2.6, 2.8, 2.8 %. The limit may go from 0.6, below which the leg counts, to below 0.75, where the stack of
// R = 3 that is measured below stays in the sub-world.
//
// The proxy is always imposed: it hangs on the device. Measured range of kMostUneven (stack of five cubes at 1000 Hz,
// 0.25 / sub-step, the uppermost R times as heavy, 3 to 5 members, ratios 2, 8 and 16, 8 s; force error without the
// rule, with it): R = 1: 0.1 %, not needed; 3: 3.8 %, 0.6 %; 10: 15 %, 10 mm off, 1.2 %; 30: 15 %, 1.4 %; 100: 42
// %, 2.2 %; 300: falls, 7 %; 1000: falls, 44 %. The last are those of a sub-world with the proxy alone (7 and 44 %):
// there the global step itself comes to rest 0.1 to 0.3 mm from where the direct run does. With a limit of 0 every
// group is the buffer: then what is pushed fast loses (the pile of `experiment energy-loss` at ratio 8: 1.7 % instead
// of 0.2 %). Thread: the global world's; construction [setup]; allocates nothing. Work: linear in bodies and touches,
// where a group is uneven in contacts, too.
#pragma once

#include <vector>

#include "rt/physics/islands.h"
#include "sim/exchange/extraction.h"

namespace tactus::sim {

class BufferChoice {
 public:
  static constexpr double kMostUneven = 2;  // heaviest over lightest of a group of which members may be imposed

  // What holds members from outside their group, of the last step; all empty before the first one.
  struct Surroundings {
    std::span<const physics::Contact> contacts;     // of the world, those with static geometry among them
    std::span<const std::uint32_t> places;          // by the world's slots: slots of `bodies`
    std::span<const haptics::OutsideBody> outside;  // ghosts of the cycle to come, ascending ids
  };

  explicit BufferChoice(std::uint32_t max_bodies)
      : parent_(max_bodies),
        lightest_(max_bodies),
        heaviest_(max_bodies),
        at_border_(max_bodies),
        shares_(max_bodies) {}

  // Marks the buffer bodies, by slot, among the chosen members; never the proxy. Returns how many of them are there for
  // their uneven group alone.
  std::uint32_t choose(std::span<const physics::Body> bodies, const Extraction& extraction, const ContactGraph& graph,
                       std::uint32_t proxy, const Surroundings& around, std::span<std::uint8_t> in_buffer) noexcept;

 private:
  // What a sweep leaves of an error of a member, w / (w + W), against the last member that is linked to it, and the
  // most against anything that is no member.
  struct Shares {
    static constexpr double kMostLeft = kMostUneven / (1 + kMostUneven);
    double linked{0}, other{0};
    std::uint32_t links{0};  // to members but the proxy
    bool at_end() const noexcept { return links == 1 && linked * other <= kMostLeft; }
  };

  // The extremes of every group, without those at_end. Is one at the border uneven?
  bool weigh(std::span<const physics::Body> bodies, const Extraction& extraction,
             std::span<const std::uint8_t> in_buffer, physics::Islands& groups) noexcept;
  void find_shares(std::span<const physics::Body> bodies, const Extraction& extraction, const ContactGraph& graph,
                   std::uint32_t proxy, const Surroundings& around) noexcept;
  bool is_uneven(std::uint32_t group) const noexcept {
    return at_border_[group] != 0 && heaviest_[group] > kMostUneven * lightest_[group];
  }

  std::vector<std::uint32_t> parent_;        // by slot: of the groups
  std::vector<double> lightest_, heaviest_;  // kg, by a group's lowest slot
  std::vector<std::uint8_t> at_border_;      // same: has a body that touches an outside one
  std::vector<Shares> shares_;               // by slot
};

}  // namespace tactus::sim
