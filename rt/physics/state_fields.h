// The fields of a world's state, one by one, in the order in which they are saved.
//
// Structs have padding, and the same state must give the same bytes. `io(x)` writes, reads or hashes a number x.
// Thread: [any].
#pragma once

#include <type_traits>

#include "rt/base/bytes.h"
#include "rt/base/hash.h"
#include "rt/physics/body.h"
#include "rt/physics/border/border_contact.h"
#include "rt/physics/contact/contact.h"
#include "rt/physics/contact/contact_reference.h"
#include "rt/physics/contact/warm_start.h"
#include "rt/physics/pose_spring.h"

namespace tactus::physics {

struct StateWriter {
  ByteWriter& out;
  template <class V>
  void operator()(const V& value) noexcept {
    out.put(value);
  }
};
struct StateReader {
  ByteReader& in;
  template <class V>
  void operator()(V& value) noexcept {
    in.get(value);
  }
  void operator()(bool& value) noexcept {  // via a byte: other values than 0 and 1 are no bool
    std::uint8_t byte = 0;
    in.get(byte);
    value = byte != 0;
  }
};
struct StateHash {
  Fnv1a hash;
  template <class V>
  void operator()(const V& value) noexcept {
    hash.add(value);
  }
};

template <class T>
concept Number = std::is_arithmetic_v<T> || std::is_enum_v<T>;

template <class Io, Number N>
void each_field(Io& io, N& number) noexcept {
  io(number);
}
// Visits several fields, in this order.
template <class Io, class... Field>
void fields(Io& io, Field&... field) noexcept {
  (each_field(io, field), ...);
}

template <class Io>
void each_field(Io& io, Vec3d& v) noexcept {
  fields(io, v.x, v.y, v.z);
}
template <class Io>
void each_field(Io& io, Quatd& q) noexcept {
  fields(io, q.w, q.x, q.y, q.z);
}
template <class Io>
void each_field(Io& io, Posed& p) noexcept {
  fields(io, p.position, p.rotation);
}
template <class Io>
void each_field(Io& io, Twistd& t) noexcept {
  fields(io, t.linear, t.angular);
}
template <class Io>
void each_field(Io& io, Wrenchd& w) noexcept {
  fields(io, w.force, w.torque);
}

template <class Io>
void each_field(Io& io, Body& b) noexcept {
  fields(io, b.id, b.kind, b.shape.kind, b.shape.radius, b.shape.half_length, b.shape.half_extents);
  if (traits_of(b.shape.kind).is_listed) fields(io, b.shape.index);
  fields(io, b.mass, b.inertia, b.friction, b.gravity_scale, b.motion.pose, b.motion.velocity);
}

template <class Io>
void each_field(Io& io, AxisCache& c) noexcept {
  fields(io, c.axis);
  if (c.axis >= kFirstHullAxis) fields(io, c.a, c.b);
}

template <class Io>
void each_field(Io& io, Contact& c) noexcept {
  fields(io, c.key.value, c.slot_a, c.slot_b, c.b_fixed, c.axis_cache, c.friction, c.normal, c.count);
  for (std::uint32_t i = 0; i < c.count && i < kMaxManifoldPoints; ++i) {
    ContactPoint& p = c.points[i];
    fields(io, p.from_a, p.from_b, p.separation, p.feature, p.normal_impulse, p.tangent_impulse[0],
           p.tangent_impulse[1], p.total_normal_impulse, p.total_friction);
  }
}

template <class Io>
void each_field(Io& io, ContactReference& r) noexcept {
  fields(io, r.tolerance);
  if (!(r.tolerance > 0.0)) return;
  fields(io, r.moved, r.margin, r.lever_arm);
  for (std::uint32_t i = 0; i < r.kPoints; ++i) {
    for (int k = 0; k < 3; ++k) fields(io, r.on_a[k][i], r.on_b[k][i]);
    fields(io, r.separation[i]);
  }
}

template <class Io>
void each_field(Io& io, WarmStart& w) noexcept {
  fields(io, w.key.value, w.axis_cache, w.count);
  for (std::uint32_t i = 0; i < w.count && i < kMaxManifoldPoints; ++i)
    fields(io, w.features[i], w.normal_force[i], w.friction_force[i]);
}

template <class Io>
void each_field(Io& io, PoseSpring& s) noexcept {
  fields(io, s.enabled, s.slot, s.stiffness_N_per_m, s.damping_Ns_per_m, s.stiffness_Nm_per_rad, s.damping_Nms_per_rad,
         s.target, s.target_velocity, s.step_impulse);
}

template <class Io>
void each_field(Io& io, BorderContact& c) noexcept {
  fields(io, c.member, c.outside, c.feature, c.parts, c.normal, c.member_anchor, c.impulse_rate, c.friction,
         c.outside_velocity, c.ghost, c.outside_inverse_mass, c.member_round, c.ghost_round, c.ghost_centre,
         c.line_point, c.gap, c.friction_free, c.normal_impulse, c.tangent_impulse[0], c.tangent_impulse[1],
         c.step_normal_impulse, c.step_tangent_impulse, c.total_normal_impulse, c.total_tangent_impulse, c.work);
}

template <class Io>
void each_field(Io& io, SymMat3d& m) noexcept {
  fields(io, m.xx, m.yy, m.zz, m.xy, m.xz, m.yz);
}

template <class Io>
void each_field(Io& io, BorderGhost& g) noexcept {
  fields(io, g.outside, g.centre, g.velocity, g.drive, g.admittance.linear, g.admittance.angular);
  for (Vec3d& row : g.admittance.crossed) each_field(io, row);
  fields(io, g.total_impulse);
}

}  // namespace tactus::physics
