/// \file
/// State of all bodies, their role in the simulation, and the contacts: the element types of Session's views.
///
/// Plain values of a fixed layout, so that NumPy or a graphics card can use an array of them directly. Thread: any.
/// Frame: world. Units: SI, in the names.
#pragma once

#include <type_traits>

#include "tactus/types.h"

namespace tactus {

/// Pose and velocity of a body. Its frame is the one that the scene places (BodyInfo).
struct BodyState {
  Vector3 position_m{};                  ///< of the frame's origin
  Quaternion rotation{};                 ///< world from body
  Vector3 velocity_m_per_s{};            ///< of the centre of mass
  Vector3 angular_velocity_rad_per_s{};  ///< about the world's axes
};
static_assert(std::is_trivially_copyable_v<BodyState> && sizeof(BodyState) == 13 * sizeof(double));

/// Where a body is currently simulated.
enum class Role : std::uint8_t {
  kFixed = 0,    ///< not simulated: it never moves
  kAsleep = 1,   ///< not simulated: it rests until another body comes near
  kGlobal = 2,   ///< the global world alone
  kOutside = 3,  ///< the global world; it touches members
  kMember = 4,   ///< the sub-world, at the haptic rate
  kBorder = 5,   ///< the sub-world; it touches an outside body
};

/// A contact point between two bodies of the sub-world, in the last tick.
struct Contact {
  BodyNumber a{0};         ///< never fixed
  BodyNumber b{0};         ///< the other one
  Vector3 position_m{};    ///< of the point on A, at the beginning of the tick
  Vector3 normal{};        ///< unit, from A to B
  double force_N{0};       ///< along the normal on B, mean over the tick
  Vector3 friction_N{};    ///< on B, mean over the tick
  double separation_m{0};  ///< at the beginning of the tick; negative: overlap
};
static_assert(std::is_trivially_copyable_v<Contact> && sizeof(Contact) == 12 * sizeof(double));

/// A contact point between a member and an outside body, in the last tick.
struct BorderContact {
  BodyNumber member{0};   ///< of the sub-world
  BodyNumber outside{0};  ///< of the global world
  Vector3 position_m{};   ///< of the point on the member
  Vector3 normal{};       ///< unit, from the outside body to the member
  double force_N{0};      ///< along the normal on the member, mean over the tick
  Vector3 friction_N{};   ///< on the member, mean over the tick
};
static_assert(std::is_trivially_copyable_v<BorderContact> && sizeof(BorderContact) == 11 * sizeof(double));

}  // namespace tactus
