// A contact of a body of this world with a body of another world, which this world knows only by its motion and by
// the impulse that the other world's solver last found there.
//
// Source: the paper, section 2.2; kCapped and kGhost: the study of borders. Frame: world; normal from the outside body
// to the member. Units: SI. Thread: the owner of the World.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "rt/base/choice.h"
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

// What tells the modes apart: the solver of border contacts and both sides of the exchange ask for these alone.
struct BorderTraits {
  std::string_view name;        // in options, JSON and tables
  bool ghosts{false};           // the outside body is a ghost that answers, with friction as between members; no limit
  bool replays{false};          // the global step's impulse acts, sub-step by sub-step
  bool limited{false};          // a pair's impulse is at most the global step's: impulse_rate x time, over its points
  bool surface_moves{false};    // the outside surface and its friction point move with outside_velocity
  bool has_budget{false};       // what it puts into members is bounded by an energy budget
  double budget_at_start_J{0};  // what of it is there before anything was taken out
  // What the global world does with the impulses that the sub-world found on outside bodies.
  enum class Return : std::uint32_t {
    kNothing,  // none: the global world keeps its own state of what stands at the border
    kImpulse,  // applies them: friction then counts in both worlds (the paper)
    kChange,   // applies their difference to what its own contacts did
  } returns{Return::kNothing};
};

// Of a number that is no mode: without a name.
constexpr BorderTraits traits_of(BorderMode mode) noexcept {
  using enum BorderMode;
  using Return = BorderTraits::Return;
  switch (mode) {
    case kCapped:
      return {.name = "capped", .limited = true, .surface_moves = true, .returns = Return::kChange};
    case kReplay:
      return {.name = "replay", .replays = true, .limited = true, .returns = Return::kImpulse};
    case kFrozen:
      return {.name = "frozen", .returns = Return::kChange};
    case kGhost:
      return {.name = "ghost", .ghosts = true, .has_budget = true, .budget_at_start_J = 0.01};
    case kFiltered:
      return {.name = "filtered", .replays = true, .limited = true, .has_budget = true, .returns = Return::kImpulse};
  }
  return {};
}

// In the order of help texts and tables.
inline constexpr std::array kBorderModes{BorderMode::kGhost, BorderMode::kCapped, BorderMode::kReplay,
                                         BorderMode::kFiltered, BorderMode::kFrozen};
static_assert(lists_every_choice(kBorderModes), "a mode that has traits is not in the list, or twice");

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
