// A contact of a body of this world with a body of another world, which this world knows only by its motion and by
// the impulse that the other world's solver last found there.
//
// Source: the paper, section 2.2; kCapped and kGhost: the study of borders. Frame: world; normal from the outside body
// to the member. Units: SI. Thread: the owner of the World.
#pragma once

#include "rt/base/ids.h"
#include "rt/base/spatial.h"
#include "rt/physics/border/border_ghost.h"

namespace tactus::physics {

enum class BorderMode : std::uint32_t {
  // Unilateral contact against the neighbour's motion; the impulse of a pair, over all its points, is at most the sum
  // of their impulse_rate x time. Which point carries it is the solver's to find: a cap on each point would leave no
  // torque against a tilt, and a tall stack on such a border falls.
  kCapped = 1,
  kReplay = 2,  // the impulse itself, every sub-step (the paper)
  kFrozen = 3,  // unilateral contact against a neighbour at rest, impulse unlimited
  kGhost = 4,   // a contact like an inner one, friction included, against a ghost that answers to it (border_ghost.h)
  // Replay behind a passivity filter: while the border has put into the members what its budget holds, the impulse of a
  // contact is limited, sub-step by sub-step, to what does no work on its member, and the friction point pulls nothing
  // back. The paper filters "to avoid energy gain" and does not say how: this is our filling-in,
  // after the time-domain passivity control of Hannaford and Ryu (2002), with the tank for its energy observer.
  kFiltered = 5,
};

constexpr bool replays(BorderMode mode) noexcept {
  return mode == BorderMode::kReplay || mode == BorderMode::kFiltered;
}
// What it puts into members is bounded by an energy budget.
constexpr bool has_budget(BorderMode mode) noexcept {
  return mode == BorderMode::kGhost || mode == BorderMode::kFiltered;
}

struct BorderContact {
  BodyId member{kNoBody}, outside{kNoBody};
  std::uint32_t feature{0};  // names the contact point among those of the pair
  Vec3d normal;              // unit, world, from the outside body towards the member
  Vec3d member_anchor;       // m, the contact point in the member's body frame
  double impulse_rate{};     // N: what the global step found: its impulse / its time
  double friction{};         // coefficient of the pair
  Vec3d outside_velocity;    // m/s, of the outside body's surface at the point, world
  // kGhost: the ghost, by index among the world's (kNoGhost: the contact exerts nothing), and the outside body's own
  // share of the contact's inverse effective mass [1/kg], from which comes its softness.
  std::uint32_t ghost{kNoGhost};
  double outside_inverse_mass{};

  // The friction point (paper 2.2): the member's point stays on the line through `line_point` along `normal`. A ghost
  // has none: there the point is where the member's is, tick by tick.
  Vec3d line_point;           // m, world; moves with outside_velocity
  double gap{};               // m: signed gap along the normal when the member's point is at line_point
  bool friction_free{false};  // true once the tangential impulse exceeded mu i; refreshed at each synchronisation

  // What the solver did. Warm-start impulses of the last sub-step, sums since the last clear [N s].
  double normal_impulse{};
  double tangent_impulse[2]{};
  double step_normal_impulse{};   // over the current step: the i of mu i
  Vec3d step_tangent_impulse{};   // over the current step, on the member
  double total_normal_impulse{};  // over the cycle
  Vec3d total_tangent_impulse{};  // over the cycle, on the member
  double work{};                  // J, done on the member over the cycle
};

}  // namespace tactus::physics
