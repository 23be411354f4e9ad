// Diagnostics of a world (energy, momentum, hash), and its state as bytes.
#include "rt/physics/world.h"

namespace tactus::physics {
namespace {

// Visits every field separately, for writing and for reading: structs have padding, and the same state must give the
// same bytes. `io(x)` writes or reads x.
template <class Io>
void each_field(Io& io, Vec3d& v) noexcept {
  io(v.x), io(v.y), io(v.z);
}
template <class Io>
void each_field(Io& io, Quatd& q) noexcept {
  io(q.w), io(q.x), io(q.y), io(q.z);
}
template <class Io>
void each_field(Io& io, Posed& p) noexcept {
  each_field(io, p.position), each_field(io, p.rotation);
}
template <class Io>
void each_field(Io& io, Twistd& t) noexcept {
  each_field(io, t.linear), each_field(io, t.angular);
}
template <class Io>
void each_field(Io& io, Wrenchd& w) noexcept {
  each_field(io, w.force), each_field(io, w.torque);
}

template <class Io>
void each_field(Io& io, Body& b) noexcept {
  io(b.id), io(b.kind);
  io(b.shape.kind), io(b.shape.radius), io(b.shape.half_length), each_field(io, b.shape.half_extents);
  if (b.shape.kind == ShapeKind::kHull || b.shape.kind == ShapeKind::kMesh) io(b.shape.index);
  io(b.mass), each_field(io, b.inertia), io(b.friction), io(b.gravity_scale);
  each_field(io, b.motion.pose), each_field(io, b.motion.velocity);
}

template <class Io>
void each_field(Io& io, AxisCache& c) noexcept {
  io(c.axis);
  if (c.axis >= kFirstHullAxis) io(c.a), io(c.b);
}

template <class Io>
void each_field(Io& io, Contact& c) noexcept {
  io(c.key.value), io(c.slot_a), io(c.slot_b), io(c.b_fixed), each_field(io, c.axis_cache), io(c.friction);
  each_field(io, c.normal);
  io(c.count);
  for (std::uint32_t i = 0; i < c.count && i < kMaxManifoldPoints; ++i) {
    ContactPoint& p = c.points[i];
    each_field(io, p.from_a), each_field(io, p.from_b);
    io(p.separation), io(p.feature), io(p.normal_impulse), io(p.tangent_impulse[0]), io(p.tangent_impulse[1]);
    io(p.total_normal_impulse), each_field(io, p.total_friction);
  }
}

template <class Io>
void each_field(Io& io, ContactReference& r) noexcept {
  io(r.tolerance);
  if (!(r.tolerance > 0.0)) return;
  io(r.moved), io(r.margin), io(r.lever_arm);
  for (std::uint32_t i = 0; i < r.kPoints; ++i) {
    for (int k = 0; k < 3; ++k) io(r.on_a[k][i]), io(r.on_b[k][i]);
    io(r.separation[i]);
  }
}

template <class Io>
void each_field(Io& io, WarmStart& w) noexcept {
  io(w.key.value), each_field(io, w.axis_cache), io(w.count);
  for (std::uint32_t i = 0; i < w.count && i < kMaxManifoldPoints; ++i)
    io(w.features[i]), io(w.normal_force[i]), each_field(io, w.friction_force[i]);
}

template <class Io>
void each_field(Io& io, PoseSpring& s) noexcept {
  io(s.enabled), io(s.slot);
  io(s.stiffness_N_per_m), io(s.damping_Ns_per_m), io(s.stiffness_Nm_per_rad), io(s.damping_Nms_per_rad);
  each_field(io, s.target), each_field(io, s.target_velocity);
  each_field(io, s.step_impulse);
}

template <class Io>
void each_field(Io& io, BorderContact& c) noexcept {
  io(c.member), io(c.outside), io(c.feature);
  each_field(io, c.normal), each_field(io, c.member_anchor);
  io(c.impulse_rate), io(c.friction);
  each_field(io, c.outside_velocity), io(c.ghost), io(c.outside_inverse_mass);
  each_field(io, c.line_point), io(c.gap);
  io(c.friction_free), io(c.normal_impulse), io(c.tangent_impulse[0]), io(c.tangent_impulse[1]);
  io(c.step_normal_impulse), each_field(io, c.step_tangent_impulse);
  io(c.total_normal_impulse), each_field(io, c.total_tangent_impulse), io(c.work);
}

template <class Io>
void each_field(Io& io, SymMat3d& m) noexcept {
  io(m.xx), io(m.yy), io(m.zz), io(m.xy), io(m.xz), io(m.yz);
}

template <class Io>
void each_field(Io& io, BorderGhost& g) noexcept {
  io(g.outside), each_field(io, g.centre), each_field(io, g.velocity), each_field(io, g.drive);
  each_field(io, g.admittance.linear), each_field(io, g.admittance.angular);
  for (Vec3d& row : g.admittance.crossed) each_field(io, row);
  each_field(io, g.total_impulse);
}

struct Writing {
  ByteWriter& out;
  template <class V>
  void operator()(const V& value) noexcept {
    out.put(value);
  }
};
struct Reading {
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

template <class V>
void write_all(ByteWriter& out, std::span<const V> items) noexcept {
  Writing io{out};
  out.put(static_cast<std::uint32_t>(items.size()));
  for (V item : items) each_field(io, item);
}

template <class V>
bool read_all(ByteReader& in, BoundedVector<V>& items) noexcept {
  Reading io{in};
  std::uint32_t count = 0;
  in.get(count);
  if (!in.ok() || count > items.capacity()) return false;
  items.resize(count);
  for (V& item : items) item = {}, each_field(io, item);
  return in.ok();
}

class Fnv1a {
 public:
  template <class V>
  void operator()(const V& value) noexcept {
    unsigned char bytes[sizeof(V)];
    std::memcpy(bytes, &value, sizeof(V));
    for (const unsigned char byte : bytes) hash_ = (hash_ ^ byte) * 0x100000001b3ull;
  }
  std::uint64_t value() const noexcept { return hash_; }

 private:
  std::uint64_t hash_{0xcbf29ce484222325ull};
};

}  // namespace

double World::kinetic_energy() const noexcept {
  double sum = 0.0;
  for (const Body& body : bodies_) sum += physics::kinetic_energy(body);
  return sum;
}

double World::potential_energy(const Vec3d& gravity) const noexcept {
  double sum = 0.0;
  for (const Body& body : bodies_) sum -= body.mass * body.gravity_scale * dot(gravity, body.motion.pose.position);
  return sum;
}

Wrenchd World::momentum() const noexcept {
  Wrenchd sum;
  for (const Body& body : bodies_) {
    const Quatd& q = body.motion.pose.rotation;
    const Vec3d linear = body.mass * body.motion.velocity.linear;
    const Vec3d spin = rotate(q, scale(body.inertia, rotate_inverse(q, body.motion.velocity.angular)));
    sum.force += linear;
    sum.torque += cross(body.motion.pose.position, linear) + spin;
  }
  return sum;
}

std::uint64_t World::state_hash() const noexcept {
  Fnv1a hash;
  for (Body body : bodies_) {
    hash(body.id);
    each_field(hash, body.motion.pose), each_field(hash, body.motion.velocity);
  }
  return hash.value();
}

void World::save(ByteWriter& out) const noexcept {
  Writing io{out};
  write_all(out, bodies_.span());
  write_all(out, fixed_bodies_.span());
  out.put_all(frozen_.span());
  io(wrench_applied_);
  if (wrench_applied_)
    for (Wrenchd wrench : wrenches_) each_field(io, wrench);
  for (Posed pose : last_poses_) each_field(io, pose);
  write_all(out, contacts_.contacts());
  write_all(out, contacts_.references());
  write_all(out, contacts_.warm_starts());
  for (PoseSpring spring : springs_) each_field(io, spring);
  write_all(out, border_contacts_.span());
  write_all(out, border_ghosts_.span());
  io(static_cast<std::uint32_t>(border_mode)), io(border_budget_J);
  io(last_sub_step_), io(refused_bits_), io(refused_);
  effects_.save(out);
}

std::size_t World::save_size_bound() const noexcept {
  const Capacities& c = capacities_;
  return c.bodies * (sizeof(Body) + sizeof(Wrenchd) + sizeof(Posed) + 1) + c.fixed_bodies * sizeof(Body) +
         c.contacts * (sizeof(Contact) + sizeof(ContactReference) + sizeof(WarmStart)) +
         c.border_contacts * (sizeof(BorderContact) + sizeof(BorderGhost)) + sizeof(springs_) +
         effects_.save_size_bound() + 64;  // 64: counts and the last line of save
}

void World::clear() noexcept {
  bodies_.clear(), fixed_bodies_.clear(), frozen_.clear(), wrenches_.clear();
  bounds_.clear(), fixed_bounds_.clear(), frames_.clear(), fixed_frames_.clear();
  motion_bounds_.clear(), last_poses_.clear(), dynamic_pairs_.clear();
  contacts_.clear();
  border_contacts_.clear(), border_ghosts_.clear();
  fixed_is_indexed_ = false;
  springs_ = {};
  border_mode = BorderMode::kCapped, border_budget_J = std::numeric_limits<double>::max();
  wrench_applied_ = false;
  last_sub_step_ = 0.0;
  refused_bits_ = 0, refused_ = 0;
}

// Invariants that a world keeps by itself and that bytes from a damaged tape may violate.
bool World::is_consistent() const noexcept {
  const std::size_t hulls = hulls_.size(), meshes = meshes_.size();
  const auto ascending = [hulls, meshes](const BoundedVector<Body>& bodies, BodyKind kind) noexcept {
    for (std::uint32_t i = 0; i < bodies.size(); ++i) {
      const Body& b = bodies[i];
      if (b.id >= kFirstPatchId || b.kind != kind || b.shape.kind > ShapeKind::kMesh) return false;
      if (b.shape.kind == ShapeKind::kHull && b.shape.index >= hulls) return false;
      if (b.shape.kind == ShapeKind::kMesh && (kind != BodyKind::kFixed || b.shape.index >= meshes)) return false;
      if (i > 0 && bodies[i - 1].id >= b.id) return false;
      if (!is_finite(b.motion.pose) || !is_finite(b.motion.velocity)) return false;
      if (kind == BodyKind::kDynamic && !(b.mass > 0.0 && b.inertia.x > 0.0 && b.inertia.y > 0.0 && b.inertia.z > 0.0))
        return false;
    }
    return true;
  };
  if (!ascending(bodies_, BodyKind::kDynamic) || !ascending(fixed_bodies_, BodyKind::kFixed)) return false;
  if (contacts_.references().size() != contacts_.contacts().size()) return false;
  for (const Contact& c : contacts_.contacts())
    if (c.count > kMaxManifoldPoints || c.slot_a >= bodies_.size() ||
        c.slot_b >= (c.b_fixed ? fixed_bodies_.size() : bodies_.size()))
      return false;
  for (const WarmStart& w : contacts_.warm_starts())
    if (w.count > kMaxManifoldPoints) return false;
  for (const auto& spring : springs_)
    if (spring.enabled && spring.slot >= bodies_.size()) return false;
  return !traits_of(border_mode).name.empty();
}

bool World::restore(ByteReader& in) noexcept {
  clear();
  const auto read = [&]() noexcept {
    Reading io{in};
    if (!read_all(in, bodies_) || !read_all(in, fixed_bodies_)) return false;
    frozen_.resize(bodies_.size());
    in.get_all(frozen_.span());
    wrenches_.resize(bodies_.size());
    io(wrench_applied_);
    for (Wrenchd& wrench : wrenches_) {
      wrench = {};
      if (wrench_applied_) each_field(io, wrench);
    }
    last_poses_.resize(bodies_.size());
    for (Posed& pose : last_poses_) each_field(io, pose);
    if (!read_all(in, contacts_.stored_contacts()) || !read_all(in, contacts_.stored_references())) return false;
    if (!read_all(in, contacts_.stored_warm_starts())) return false;
    for (auto& spring : springs_) each_field(io, spring);
    if (!read_all(in, border_contacts_) || !read_all(in, border_ghosts_)) return false;
    std::uint32_t mode = 0;
    io(mode), io(border_budget_J), io(last_sub_step_), io(refused_bits_), io(refused_);
    border_mode = static_cast<BorderMode>(mode);
    return effects_.restore(in) && in.ok() && is_consistent();
  };
  if (!read()) {
    clear();
    return false;
  }
  fixed_bounds_.resize(fixed_bodies_.size()), fixed_frames_.resize(fixed_bodies_.size());
  for (std::uint32_t i = 0; i < fixed_bodies_.size(); ++i) {
    fixed_bounds_[i] = bounds_of(fixed_bodies_[i].shape, fixed_bodies_[i].motion.pose, 0.0);
    fixed_frames_[i] = BodyFrame::of(fixed_bodies_[i].motion.pose);
  }
  return true;
}

}  // namespace tactus::physics
