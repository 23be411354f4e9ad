// The buffer of a sub-world: the members that touch outside bodies, and groups of uneven masses. Both worlds simulate
// them, the global world keeps their state. The other members, the inner ones, are the sub-world's own, as the proxy.
//
// A sub-world knows what rests on its outermost members only by ghosts (border_ghost.h). If it owned those members,
// each error of a ghost would be imposed on the global world, come back with the next snapshot, and add up: a stack
// whose foot is a member falls. So the two subdomains overlap. Over a cycle the sub-world moves its buffer with its
// inner members and against the ghosts; at the synchronisation the buffer takes the state that the global world found,
// and only the inner members are imposed there.
//
// Why that is stable, on one coordinate: an inner member m and a buffer body M that move together, stopped or pushed by
// anything. Both worlds step them from the same state (v_I, v_B); the sub-world ends with v_s, the global world with
// v_g; the next state is (v_s, v_g), and both end at (m v_s + M v_g) / (m + M) plus what acts. The difference v_s - v_g
// is of the last cycle's errors alone (the ghosts', and the device's motion foreseen): it has no memory, its root is 0.
// A ghost's error reaches the global world through inner members only, at M / (m + M) of its size, and no path leads
// back from there to the ghost but the true contacts of the global world. The ghost alone, with the impulses returned,
// has the root E = G - 1 + R Gamma (tests/border/README.md), beyond 1 in networks.
// What is given up: the impulse between inner members and buffer is of each world's own; their difference, of second
// order in the cycle, is not returned. Returning it, at once or by shares of 0.2 to 1, was tried and makes towers fall:
// a returned impulse arrives a cycle late, in a network that has answered by then.
//
// Friction has no memory but where the bodies are. Where the proxy holds on to a buffer body by friction, and the body
// comes to lie elsewhere at the synchronisation, they have slid on each other without sliding: the sum of it lets the
// proxy creep, off a plank that it presses in within 20 s. So the proxy goes with the body's point that it holds,
// along the surface. In whole runs of 20 s (tests/border/README.md) the force in the crib at ratio 16 is then off by
// 2.8 % instead of 7.5 %.
// Thread: construction is [setup]; the rest [rt], the haptic thread. Frame: world. Units: SI. Bound: kMaxMembers
// bodies. Source: restricted additive Schwarz with overlap (Cai, Sarkis 1999).
#pragma once

#include "rt/haptics/coupling/snapshot.h"

namespace tactus::haptics {

class BorderBuffer {
 public:
  BorderBuffer() : bodies_(kMaxMembers) {}

  std::uint32_t size() const noexcept { return bodies_.size(); }
  bool holds(BodyId id) const noexcept { return std::binary_search(bodies_.begin(), bodies_.end(), id); }
  void clear() noexcept { bodies_.clear(); }

  // What a synchronisation did to the sub-world.
  struct Adopted {
    double gained_J{0};   // kinetic energy of the buffer bodies, with sign
    Vec3d proxy_carried;  // m, world: by the buffer bodies that the proxy holds on to, the mean
  };
  // At a synchronisation, after the members have changed: those that were in the buffer get the global world's state,
  // and the snapshot says who is in it now. The proxy stays where it is: the caller carries it.
  Adopted adopt(const WorldSnapshot& snapshot, BodyId proxy, physics::World& world) noexcept;

  void save(ByteWriter& out) const noexcept;
  [[nodiscard]] bool restore(ByteReader& in, const physics::World& world) noexcept;
  static constexpr std::size_t kMostBytes = sizeof(std::uint32_t) + kMaxMembers * sizeof(BodyId);

 private:
  BoundedVector<BodyId> bodies_;  // ascending
};

}  // namespace tactus::haptics
