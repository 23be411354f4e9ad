// A contact between a body of this world (the member) and a body of another world (the outside body), of which this
// world has only the motion and the impulse that the other world's solver last found at the contact.
//
// Source: kReplay the paper, section 2.2; kFiltered below; kGhost border_ghost.h. Frame: world; normal from the outside
// body to the member. Units: SI. Thread: the owner of the World.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <string_view>

#include "rt/base/choice.h"
#include "rt/base/ids.h"
#include "rt/base/spatial.h"
#include "rt/physics/border/border_ghost.h"

namespace tactus::physics {

enum class BorderMode : std::uint32_t {
  // Unilateral contact against the outside body's motion. The impulse of a pair, summed over its points, is at most the
  // sum of their impulse_rate x time; the solver distributes it among the points. A cap on each point would leave no
  // torque against a tilt, and a tall stack on such a border falls.
  kCapped = 1,
  kReplay = 2,  // applies the global step's impulse in every sub-step (the paper)
  kFrozen = 3,  // unilateral contact against an outside body at rest, impulse unlimited
  kGhost = 4,   // a contact like an inner one, with friction, against a ghost that reacts to it (border_ghost.h)
  // Replay with a passivity filter. When the border's tank is empty, the impulse of a contact is limited,
  // sub-step by sub-step, to what does no work on its member, and the friction point is no longer pulled back. The
  // paper filters "to avoid energy gain" without giving the method; this one is ours, after the time-domain passivity
  // control of Hannaford and Ryu (2002), with the energy tank as observer.
  kFiltered = 5,
};

// The properties of a mode: the border solver and both sides of the exchange read only these, never the mode.
struct BorderTraits {
  std::string_view name;  // in options, JSON and tables
  bool ghosts{false};   // the outside body is a ghost that reacts, with friction as between members; impulse unlimited
  bool replays{false};  // the global step's impulse is applied in every sub-step
  bool limited{false};  // a pair's impulse is at most the global step's: impulse_rate x time, over its points
  bool surface_moves{false};  // the outside surface and its friction point move with outside_velocity
  bool has_tank{false};       // the energy that the border may put into members is bounded by an energy tank
                              // (rt/haptics/coupling/border_tank.h)
  double tank_at_start_J{0};  // J: in the tank before the border has taken out any energy
  // How the global world uses the impulses that the sub-world applied to outside bodies.
  enum class Return : std::uint32_t {
    kNothing,  // not at all: the global world keeps its own state of the bodies at the border
    kImpulse,  // applies them: friction then acts in both worlds (the paper)
    kChange,   // applies their difference to the impulses of its own contacts
  } returns{Return::kNothing};
};

// A number that is no mode gets an empty name.
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
      // 10 mJ: a hundredth of what a hand gives in a second at 1 N and 1 m/s. With 0 a ghost is a wall until outside
      // bodies' work is known: the crib's force is off by 20 % (tests/border/README.md: 0 to 0.1 J).
      return {.name = "ghost", .ghosts = true, .has_tank = true, .tank_at_start_J = 0.01};
    case kFiltered:
      return {.name = "filtered", .replays = true, .limited = true, .has_tank = true, .returns = Return::kImpulse};
  }
  return {};
}

// Order of help texts and tables.
inline constexpr std::array kBorderModes{BorderMode::kGhost, BorderMode::kCapped, BorderMode::kReplay,
                                         BorderMode::kFiltered, BorderMode::kFrozen};
static_assert(lists_every_choice(kBorderModes), "a mode that has traits is not in the list, or twice");

// The border of every run, experiment and configuration that names no other: of all borders its energy and force are
// off by the least (tools/experiment/RESULTS.md, `energy-loss`).
inline constexpr BorderMode kDefaultBorder = BorderMode::kGhost;

// The mode while the global world is late: its outside bodies are taken as at rest.
inline constexpr BorderMode kLateBorder = BorderMode::kFrozen;

// The mode of a world for which none was set: it has no border contacts. No choice of a border, but part of the world's
// saved state, so tapes depend on it.
inline constexpr BorderMode kUnusedBorder = BorderMode::kCapped;

// How the border acts in a step.
struct BorderRule {
  BorderMode mode{kUnusedBorder};
  double available_J{std::numeric_limits<double>::max()};  // see BorderSolver::prepare; set before each step
};

struct BorderContact {
  BodyId member{kNoBody}, outside{kNoBody};
  std::uint32_t feature{0};  // with `parts`: identifies the contact point within the pair of bodies
  std::uint32_t parts{0};    // PairKey::parts
  Vec3d normal;              // unit, world, from the outside body towards the member
  Vec3d member_anchor;       // m, in the member's body frame: the contact point; of a ball, its centre
  double impulse_rate{};     // N: impulse of the global step / its length
  double friction{};         // coefficient of the pair
  Vec3d outside_velocity;    // m/s, of the outside body's surface at the point, world
  // kGhost: index of the ghost in the world's list (kNoGhost: the contact exerts nothing), and the outside body's own
  // part of the contact's inverse effective mass [1/kg], which determines the contact's softness.
  std::uint32_t ghost{kNoGhost};
  double outside_inverse_mass{};

  // A ball is touched at the point that lies along the normal from its centre, however far it has turned. m:
  // distance of that point from the centre, on the member and on the ghost; 0: the point turns with the body.
  double member_round{}, ghost_round{};
  Vec3d ghost_centre;  // m, world axes: of the ghost's ball or cap from the centre of the ghost

  // The friction point (paper 2.2): the member's point is held on the line through `line_point` along `normal`. With a
  // ghost there is no such constraint: line_point follows the member's point every tick.
  Vec3d line_point;           // m, world; moves with outside_velocity
  double gap{};               // m: signed gap along the normal when the member's point is at line_point
  bool friction_free{false};  // true after the tangential impulse exceeded mu i; refreshed at each synchronisation

  // Results of the solver: warm-start impulses of the last sub-step, and sums since the last clear [N s].
  double normal_impulse{};
  double tangent_impulse[2]{};
  double step_normal_impulse{};   // over the current step: i of the friction limit mu i
  Vec3d step_tangent_impulse{};   // over the current step, on the member
  double total_normal_impulse{};  // over the cycle
  Vec3d total_tangent_impulse{};  // over the cycle, on the member
  double work{};                  // J, done on the member over the cycle

  Vec3d point_on(const Posed& pose) const noexcept { return pose * member_anchor - member_round * normal; }
};

}  // namespace tactus::physics
