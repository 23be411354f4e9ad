// Correction of a member's motion at a synchronisation: the error of the border, which the global world knows.
//
// Over cycle n the sub-world S simulates the members against ghosts (rt/physics/border/border_ghost.h), which only
// approximate the outside bodies. The global world G simulates everything over the same cycle, but knows the hand only
// by extrapolation. So the global world also runs the sub-world itself, with the same ghosts and the extrapolated hand
// (sim/exchange/sub_world_prediction.h): the prediction P. At the synchronisation a member's state x becomes
//   x(n+1) = S(x(n), hand) + G(x(n), extrapolated hand) - P(x(n), extrapolated hand)
// and this state replaces the one in the global world. Read as S + (G - P): G - P is the error of the ghosts over this
// cycle. Read as G + (S - P): S - P is the effect of what the hand did other than extrapolated.
//
// Stability. Linearised about a state of rest, S = A_s x + B u and P = A_s x + B u', with u the hand's motion and u'
// the extrapolated one: the ghosts and the sub-steps of S and P are the same. So x(n+1) = A_g x + B (u - u'). The state
// is multiplied by A_g, the global world's own step, whatever the ghosts are; no error of a ghost is multiplied over
// cycles. What rests in the global world rests in the sub-world. An impulse on the other side of the border, an impact
// for example, reaches the members through G in full. Not covered: the hand's own loop through B (u - u'), which
// rt/haptics/coupling_limits.h bounds; contacts that open or slide within the cycle, where S, P and G differ in A; and
// late cycles.
//
// Momentum. An impulse that members gave a ghost in S beyond that in P was given by the hand, and the outside body has
// not got it. The report contains the impulses on ghosts; the global world adds their difference to the outside bodies
// before its next step, contacts and joints alike. Not where the border's tank is empty after the synchronisation
// (border_tank.h): an empty tank switches what a ghost answers, a small difference of the hand then makes a large one
// between S and P, and a chain of 10 kg flew apart on it (whole_run_test.cpp). Its momentum is then lost.
//
// Accuracy. Where S = P, the sub-world ends each cycle in the global world's state, with the global world's sub-steps.
// Members of an island in which none met an outside body in the cycle are not corrected: there S is the more accurate
// one, and G - P would be the difference of their contacts alone. A late world's correction is added when it arrives:
// what S did in the meantime is kept.
//
// Impulses of contacts are part of the state: static friction is indeterminate, and a solver that starts from the
// impulses of its last step keeps the set that it has. So contacts of corrected members, also with fixed bodies, start
// a cycle with the global world's impulses.
// Thread: [any], pure. Frame: world. Units: SI. Bound: constant time. Source: the parareal iteration (Lions, Maday,
// Turinici 2001), with one correction a cycle; a predicted and a true plant side by side: Smith 1957.
#pragma once

#include "rt/haptics/coupling/snapshot.h"

namespace tactus::haptics {

// Takes `predicted` to `global`. The rotation is that from predicted to global, about the body's centre.
MotionCorrection correction_between(BodyId member, const physics::BodyMotion& predicted,
                                    const physics::BodyMotion& global) noexcept;

// The motion with the correction added; the rotation is normalised.
physics::BodyMotion corrected(const physics::BodyMotion& motion, const MotionCorrection& correction) noexcept;

}  // namespace tactus::haptics
