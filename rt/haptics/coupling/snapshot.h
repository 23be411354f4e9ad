// The messages that the two worlds exchange once a cycle: WorldSnapshot G(n) from the global world to the haptic
// thread, SubWorldReport H(n) back. Values only, written in place in a double buffer, so unused capacity costs nothing.
//
// Thread: values; the global world's writes a snapshot and the haptic one [rt] reads it, a report goes the other way
// (exchange.h). Frame: world, unless a field says otherwise. Units: SI. Source: the paper, section 2; rt/loop/README.md
// shows the cycle in which they are exchanged. Bound: the capacities below; the writer keeps the most important entries
// (its order) and counts the rest.
#pragma once

#include <cstddef>

#include "rt/base/bounded_vector.h"
#include "rt/physics/body.h"
#include "rt/physics/world.h"

namespace tactus::haptics {

inline constexpr std::uint32_t kMaxMembers = 256;
inline constexpr std::uint32_t kMaxBorderPoints = 1024;
inline constexpr std::uint32_t kMaxOutsideBodies = 256;
inline constexpr std::uint32_t kMaxWarmStarts = 1024;
inline constexpr std::uint32_t kMaxNearRegions = 512;
inline constexpr std::uint32_t kMaxNearTriangles = 8192;
inline constexpr std::uint32_t kMaxEffectBytes = 1u << 16;

// State of effects for bodies that both worlds have (rt/physics/effects/effects.h).
using EffectBytes = FixedVector<std::byte, kMaxEffectBytes>;

// A contact point between a member and an outside body, at the end of the global step.
struct BorderPoint {
  BodyId member{kNoBody}, outside{kNoBody};
  std::uint32_t feature{0};
  std::uint32_t parts{0};    // PairKey::parts: which parts of the two bodies touch
  Vec3d normal;              // unit, from the outside body towards the member
  Vec3d member_anchor;       // m, in the member's body frame: the point; of a ball, its centre
  double impulse_rate_N{0};  // normal impulse of the step / its duration
  double friction{0};
  Vec3d outside_point;             // m, world: point on the outside body's surface, at the end of the step
  double separation_m{0};          // gap along the normal, with sign, when the member's point is at outside_point
  Vec3d outside_velocity;          // m/s: of the outside body's surface at the point, mean over the step
  Vec3d friction_N;                // on the member: friction impulse of the step / its duration
  double outside_inverse_mass{0};  // 1/kg: share of the outside body in the inverse effective mass along the normal
  // m: distance of the point from the centre of the ball that touches there, along the normal; 0: it does
  // not roll on the body, but turns with it.
  double member_round_m{0}, outside_round_m{0};
};

// An outside body that members touch or are jointed to, at the end of the global step. For the ghost border.
struct OutsideBody {
  BodyId id{kNoBody};
  std::uint32_t padding{0};
  Vec3d centre;                    // m, world
  Twistd velocity;                 // of the centre, at the end of the step
  Twistd drive;                    // m/s^2, rad/s^2: acceleration of the centre by all loads except those of members
  physics::Admittance admittance;  // of the centre, with everything that moves with the body
};

struct MemberMotion {
  BodyId id{kNoBody};
  std::uint32_t padding{0};
  physics::BodyMotion motion;
};

// To be added to a member's motion at a synchronisation (border_correction.h).
struct MotionCorrection {
  BodyId id{kNoBody};
  std::uint32_t padding{0};
  Vec3d displacement_m;  // world, of the centre
  Quatd rotation;        // world, applied after the member's own
  Twistd velocity;       // m/s, rad/s, world
};

struct WorldSnapshot {
  std::uint64_t cycle{0};      // n; G(0) is published before the first tick
  double global_time_s{0};     // global clock, time of the state below
  std::uint32_t dropped{0};    // entries that did not fit
  std::uint32_t component{0};  // bodies that the contact graph links to the proxy, capped or not
  std::uint32_t epoch{0};      // number of scene resets so far; a new value invalidates all earlier state
  double border_work_J{0};     // by outside bodies on members in the global step, with sign; ghost border only
  double outside_motion_J{0};  // kinetic energy of the bodies that contacts and joints link to members
  FixedVector<BodyId, kMaxMembers> members;         // of cycle n, ascending; always contains the proxy
  FixedVector<physics::Body, kMaxMembers> joiners;  // members of cycle n that were not members of cycle n - 1
  // Impulses of contacts among members and with fixed bodies: of joiners and of corrected members.
  FixedVector<physics::WarmStart, kMaxWarmStarts> warm_starts;
  // Of members of cycle n - 1, ascending; ghost border only, and only those whose island met an outside body.
  FixedVector<MotionCorrection, kMaxMembers> corrections;
  FixedVector<BorderPoint, kMaxBorderPoints> border;
  FixedVector<OutsideBody, kMaxOutsideBodies> outside;  // at border points and joints, ascending; ghost border only
  physics::BodyMotion proxy;                            // motion in the global world (interpolation coupling)
  // Mesh triangles near members, by index; both worlds have the meshes from the start.
  FixedVector<physics::NearRegion, kMaxNearRegions> near_regions;  // sorted by member, then by mesh
  FixedVector<std::uint32_t, kMaxNearTriangles> near_triangles;    // of the regions, concatenated
  EffectBytes effects;                                             // of the members

  // Did members meet outside bodies in the global step?
  bool has_border() const noexcept { return !border.empty() || !outside.empty(); }
};

// The target of the coupling. Not engaged: no spring, the proxy is damped to rest where it is.
struct DeviceTarget {
  bool engaged{false};
  Posed pose;       // world
  Twistd velocity;  // world
};

// Impulses on a border contact over the cycle, to be returned to the outside body.
struct BorderReturn {
  BodyId member{kNoBody}, outside{kNoBody};
  std::uint32_t feature{0};
  std::uint32_t parts{0};  // PairKey::parts: which parts of the two bodies touch
  Vec3d point;             // m, world: at the end of the cycle
  Vec3d normal;            // unit, from the outside body towards the member
  Vec3d tangent_impulse;   // N s, on the member: the outside body gets the opposite
  double normal_impulse_Ns{0};
};

// The impulse that members gave to an outside body over the cycle, by contacts and joints.
struct OutsideImpulse {
  BodyId id{kNoBody};
  std::uint32_t padding{0};
  Wrenchd impulse;  // N s, N m s, world, about its centre
};

struct SubWorldReport {
  std::uint64_t cycle{0};                    // n: the cycle that begins; the fields below are at its start t_n
  std::uint32_t ticks{0};                    // length of the cycle that ended
  std::uint32_t member_budget{kMaxMembers};  // number of members that the governor allows in cycle n + 1
  std::uint32_t epoch{0};                    // of the state below
  std::uint32_t wanted_epoch{0};             // above `epoch`: requests a scene reset
  Posed proxy_start;                         // world: pose of the proxy, at rest, after the requested reset
  // Of the cycle that ended, leavers included, corrected by the snapshot G(n).
  FixedVector<MemberMotion, kMaxMembers> members;
  FixedVector<BorderReturn, kMaxBorderPoints> border;           // only of borders that return them (BorderTraits)
  FixedVector<OutsideImpulse, kMaxOutsideBodies> outside;       // on ghosts, ascending; ghost border only
  FixedVector<physics::WarmStart, kMaxWarmStarts> warm_starts;  // of the leavers' contacts
  Wrenchd mean_device_wrench;                                   // N, N m: on the proxy, mean over the cycle that ended
  DeviceTarget device;      // at t_n; interpolation coupling: velocity is the mean over the cycle that ended
  EffectBytes effects;      // of the members of the cycle that ended
  double proxy_work_J{0};   // by the coupling on the proxy, since the start
  double border_tank_J{0};  // stored less owed (border_tank.h), at t_n; the prediction starts from it
};

static_assert(std::is_trivially_copyable_v<WorldSnapshot> && std::is_trivially_copyable_v<SubWorldReport>);

}  // namespace tactus::haptics
