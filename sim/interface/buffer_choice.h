// Which members are the buffer of a sub-world (rt/haptics/border_buffer.h): those that touch an outside body or are
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
// The proxy is always imposed: it hangs on the device. Measured range of kMostUneven (stack of five cubes at 1000 Hz,
// 0.25 / sub-step, the uppermost R times as heavy, 3 to 5 members, ratios 2, 8 and 16, 8 s; force error without the
// rule, with it): R = 1: 0.1 %, not needed; 3: 3.8 %, 0.6 %; 10: 15 %, 10 mm off, 1.2 %; 30: 15 %, 1.4 %; 100: 42
// %, 2.2 %; 300: falls, 7 %; 1000: falls, 44 %. The last are those of a sub-world with the proxy alone (7 and 44 %):
// there the global step itself comes to rest 0.1 to 0.3 mm from where the direct run does. With a limit of 0 every
// group is the buffer: then what is pushed fast loses (the pile of `experiment energy-loss` at ratio 8: 1.7 % instead
// of 0.2 %). Thread: the global world's; construction [setup]; allocates nothing. Work: linear in bodies and touches.
#pragma once

#include <vector>

#include "sim/interface/extraction.h"

namespace tactus::sim {

class BufferChoice {
 public:
  static constexpr double kMostUneven = 2;  // heaviest over lightest of a group of which members may be imposed

  explicit BufferChoice(std::uint32_t max_bodies)
      : parent_(max_bodies), lightest_(max_bodies), heaviest_(max_bodies), at_border_(max_bodies) {}

  // Marks the buffer bodies, by slot, among the chosen members; never the proxy. Returns how many of them are there for
  // their uneven group alone.
  std::uint32_t choose(std::span<const physics::Body> bodies, const Extraction& extraction, const ContactGraph& graph,
                       std::uint32_t proxy, std::span<std::uint8_t> in_buffer) noexcept;

 private:
  std::vector<std::uint32_t> parent_;        // by slot: of the groups
  std::vector<double> lightest_, heaviest_;  // kg, by a group's lowest slot
  std::vector<std::uint8_t> at_border_;      // same: has a body that touches an outside one
};

}  // namespace tactus::sim
