// What the two worlds tell each other once a cycle: WorldSnapshot G(n) down to the haptic thread, SubWorldReport H(n)
// up to the global world. Values only; written in place in a double buffer, so their size costs nothing when unused.
//
// Frame: world. Units: SI. Source: the paper, section 2; the cycle in which they are exchanged is in the README.
// Bound: the capacities below; the writer keeps the most important entries (its order) and counts the rest.
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

// What the rooms of effects hold of bodies that both worlds have (rt/physics/effects/effects.h).
using EffectBytes = FixedVector<std::byte, kMaxEffectBytes>;

// A contact point between a member and an outside body, as the global step left it.
struct BorderPoint {
  BodyId member{kNoBody}, outside{kNoBody};
  std::uint32_t feature{0};
  std::uint32_t padding{0};
  Vec3d normal;              // unit, from the outside body towards the member
  Vec3d member_anchor;       // m, in the member's body frame
  double impulse_rate_N{0};  // non-penetration impulse of the step / its time
  double friction{0};
  Vec3d outside_point;             // m, world: the outside body's surface at the point, at the end of the step
  double separation_m{0};          // signed gap along the normal when the member's point is at outside_point
  Vec3d outside_velocity;          // m/s, of the outside body's surface at the point: its mean over the step
  Vec3d friction_N;                // on the member: friction impulse of the step / its time
  double outside_inverse_mass{0};  // 1/kg: the outside body's own share of the inverse effective mass along the normal
};

// An outside body that members touch or are jointed to, as the global step left it: what the ghost border needs.
struct OutsideBody {
  BodyId id{kNoBody};
  std::uint32_t padding{0};
  Vec3d centre;                    // m, world
  Twistd velocity;                 // of the centre, at the end of the step
  Twistd drive;                    // m/s^2, rad/s^2: of the centre, by all that acts on it but the members
  physics::Admittance admittance;  // of the centre, with all that moves with it
};

struct MemberMotion {
  BodyId id{kNoBody};
  std::uint32_t in_buffer{0};  // of a report, 1: the global world keeps its own state of it
  physics::BodyMotion motion;
};

struct WorldSnapshot {
  std::uint64_t cycle{0};                    // n; G(0) is there before the first tick
  double global_time_s{0};                   // time of the state below, on the global clock
  std::uint32_t dropped{0};                  // entries that did not fit
  std::uint32_t component{0};                // bodies that the contact graph links to the proxy, capped or not
  std::uint32_t epoch{0};                    // how often the scene has begun anew: with a new one, all comes anew
  double border_work_J{0};                   // of outside bodies on members in the global step, with sign; with ghosts
  FixedVector<BodyId, kMaxMembers> members;  // of cycle n, ascending; the proxy always
  FixedVector<physics::Body, kMaxMembers> joiners;              // members that were none in cycle n - 1
  FixedVector<physics::WarmStart, kMaxWarmStarts> warm_starts;  // of the joiners' contacts with members, fixed
  FixedVector<BodyId, kMaxMembers> buffer;         // members of cycle n that touch outside bodies, ascending
  FixedVector<MemberMotion, kMaxMembers> renewed;  // members in the buffer of cycle n - 1, as the global step left them
  FixedVector<BorderPoint, kMaxBorderPoints> border;
  FixedVector<OutsideBody, kMaxOutsideBodies> outside;  // at border points and joints, ascending; with ghosts
  physics::BodyMotion proxy;                            // the proxy in the global world (interpolation coupling)
  // The triangles of meshes near members, by index: the meshes themselves are both worlds' from the start.
  FixedVector<physics::NearRegion, kMaxNearRegions> near_regions;  // by member, then by mesh
  FixedVector<std::uint32_t, kMaxNearTriangles> near_triangles;    // of the regions, one after the other
  EffectBytes effects;                                             // of the members
};

// Where the device wants the proxy to be. Not engaged: the proxy is not held and comes to rest where it is.
struct DeviceTarget {
  bool engaged{false};
  Posed pose;       // world
  Twistd velocity;  // world
};

// What the sub-world did to a border contact over the cycle.
struct BorderReturn {
  BodyId member{kNoBody}, outside{kNoBody};
  std::uint32_t feature{0};
  std::uint32_t padding{0};
  Vec3d point;            // m, world, now
  Vec3d normal;           // unit, from the outside body towards the member
  Vec3d tangent_impulse;  // N s, on the member: the outside body gets the opposite
  double normal_impulse_Ns{0};
};

struct SubWorldReport {
  std::uint64_t cycle{0};                          // n: the cycle that begins; what follows is of time t_n
  std::uint32_t ticks{0};                          // executed in the cycle that ended
  std::uint32_t member_budget{kMaxMembers};        // the governor's wish for cycle n + 1
  std::uint32_t epoch{0};                          // of the world that what follows is of
  std::uint32_t wanted_epoch{0};                   // later than that: the scene is to begin anew,
  Posed proxy_start;                               // with the proxy there, at rest; world
  FixedVector<MemberMotion, kMaxMembers> members;  // of the cycle that ended, those that just left included
  FixedVector<BorderReturn, kMaxBorderPoints> border;
  FixedVector<physics::WarmStart, kMaxWarmStarts> warm_starts;  // contacts of the bodies that just left
  Wrenchd mean_device_wrench;                                   // N, N m, on the proxy, over the cycle that ended
  DeviceTarget device;     // at t_n; interpolation: with its mean velocity over the cycle that ended
  EffectBytes effects;     // of the members of the cycle that ended
  double proxy_work_J{0};  // done on the proxy by the coupling, since the start
};

static_assert(std::is_trivially_copyable_v<WorldSnapshot> && std::is_trivially_copyable_v<SubWorldReport>);

}  // namespace tactus::haptics
