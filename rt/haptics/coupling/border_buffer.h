// The buffer of a sub-world: the members that touch outside bodies, and groups of uneven masses. Both worlds simulate
// the buffer bodies; the global world keeps their state. The sub-world keeps the state of the other members, the inner
// ones, and of the proxy.
//
// The ghosts (border_ghost.h) are the sub-world's only model of what rests on its outermost members. If it kept the
// state of those members, each error of a ghost would be imposed on the global world, return with the next snapshot,
// and accumulate: a stack whose foot is a member falls. So the two subdomains overlap. Over a cycle the sub-world
// simulates the buffer with the inner members and against the ghosts. At the synchronisation the buffer bodies get the
// state that the global world computed, and only the inner members are imposed there.
//
// Stability, on one coordinate: an inner member m and a buffer body M move together, blocked or pushed by anything.
// Both worlds step them from the same state (v_I, v_B). The sub-world ends with v_s, the global world with v_g. The
// next state is (v_s, v_g), and both end at (m v_s + M v_g) / (m + M) plus the effect of external forces. The
// difference v_s - v_g contains only the errors of the last cycle (of the ghosts and of the extrapolated device
// motion): it has no memory, its root is 0. The error of a ghost reaches the global world only through inner members,
// scaled by M / (m + M), and returns to the ghost only through the true contacts of the global world. A ghost border
// without a buffer that returns the impulses has the root E = G - 1 + R Gamma (tests/border/README.md), beyond 1 in
// networks.
// Price: each world computes its own impulse between inner members and buffer. Their difference, of second order in the
// cycle, is not returned. Returning it, at once or by shares of 0.2 to 1, was tried and makes towers fall: a returned
// impulse arrives a cycle late, when the network has already reacted.
//
// An impact is over within a sub-step, so there the difference is of first order: if one world has the impact before
// the synchronisation and the other has it after, a momentum is counted twice or not at all. So if an inner member's
// velocities in the two worlds differ by more than g T / 8 (g: standard gravity, T: duration of the cycle), all members
// take the state of the global world, in which every impulse has its opposite. The proxy's is corrected by the
// difference of the hand's impulses, since the global step extrapolates the hand's motion:
//   v = v_g + (H_s - H_g) / m     H: impulse of the device's spring over the cycle, in the sub-world and the global one
// Lasting loads differ by less. Measured (tests/border/README.md): the limit may be g T / 8 to g T / 2.
//
// The impulses of contacts are part of a body's state. Static friction is indeterminate: a body at rest can be held by
// many sets of friction impulses, and a solver that starts from the impulses of the last step keeps the set that it
// has. With a set of its own, each world comes to rest elsewhere; each synchronisation moves the buffer bodies from one
// place of rest to the other, and what they hold creeps. So the contacts of buffer bodies with each other, with fixed
// bodies and with outside bodies begin the cycle with the global world's impulses. A contact between a buffer body and
// an inner member, whose state the sub-world keeps, moves towards the global world's impulses by the share s =
// kMixedShare a cycle. With s = 0 the load on the buffer body does not balance, and a column under 30 kg creeps; with
// s = 1 the load on the inner member does not. Measured (tests/border/README.md): s from 1/16 to 1/4 holds both.
//
// Friction has a second memory, the positions of the bodies. Where friction holds the proxy on a buffer body and the
// synchronisation moves that body, their relative position changes without sliding. Accumulated, this lets the proxy
// creep: off a plank that it presses on, within 20 s. So the proxy is moved along the surface with the body's point
// that friction holds. In whole runs of 20 s (tests/border/README.md) this reduces the force error in the crib at ratio
// 16 from 7.5 % to 2.8 %.
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
  // Share of the global world's impulses with which a contact of members begins the cycle: 1 of a buffer body with
  // another or with a fixed body, kMixedShare of a buffer body with an inner member.
  double impulse_share(PairKey key) const noexcept;

  // The cycle that ends.
  struct Cycle {
    BodyId proxy;
    double duration_s;     // 0: not to be compared with a global step, since the world is late or has been reset
    Wrenchd hand_impulse;  // N s, N m s: of the device's spring on the proxy
  };
  // The effect of a synchronisation on the sub-world.
  struct Adopted {
    double gained_J{0};       // change of the kinetic energy of the bodies that took the global state, with sign
    Vec3d proxy_carried;      // m, world: displacement that the proxy still needs, tangential, where friction holds it
    bool all_members{false};  // all took the global state, after an impact
  };
  // Call at a synchronisation, after the members have changed. Bodies of the old buffer get the state of the global
  // world, after an impact all members; then the buffer is replaced by that of the snapshot. The caller moves the proxy
  // by `proxy_carried`.
  Adopted adopt(const WorldSnapshot& snapshot, const Cycle& cycle, physics::World& world) noexcept;

  void save(ByteWriter& out) const noexcept;
  [[nodiscard]] bool restore(ByteReader& in, const physics::World& world) noexcept;
  static constexpr std::size_t kMaxBytes = sizeof(std::uint32_t) + kMaxMembers * sizeof(BodyId);

 private:
  bool is_impact(const WorldSnapshot& snapshot, const Cycle& cycle, const physics::World& world) const noexcept;
  void adopt_all(const WorldSnapshot& snapshot, const Cycle& cycle, physics::World& world,
                 Adopted& adopted) const noexcept;
  void adopt_buffer(const WorldSnapshot& snapshot, BodyId proxy, physics::World& world,
                    Adopted& adopted) const noexcept;

  BoundedVector<BodyId> bodies_;  // ascending
};

}  // namespace tactus::haptics
