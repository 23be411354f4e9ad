// A world's state as bytes: save and restore.
#include "rt/physics/state_fields.h"
#include "rt/physics/world.h"

namespace tactus::physics {
namespace {

template <class V>
void write_all(ByteWriter& out, std::span<const V> items) noexcept {
  StateWriter io{out};
  out.put(static_cast<std::uint32_t>(items.size()));
  for (V item : items) each_field(io, item);
}

template <class V>
bool read_all(ByteReader& in, BoundedVector<V>& items) noexcept {
  StateReader io{in};
  std::uint32_t count = 0;
  in.get(count);
  if (!in.ok() || count > items.capacity()) return false;
  items.resize(count);
  for (V& item : items) {
    item = {};
    each_field(io, item);
  }
  return in.ok();
}

}  // namespace

void World::save(ByteWriter& out) const noexcept {
  StateWriter io{out};
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
  fields(io, border_rule.mode, border_rule.available_J, last_sub_step_, refused_bits_, refused_);
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
  bodies_.clear();
  fixed_bodies_.clear();
  frozen_.clear();
  wrenches_.clear();
  bounds_.clear();
  fixed_bounds_.clear();
  frames_.clear();
  fixed_frames_.clear();
  motion_bounds_.clear();
  last_poses_.clear();
  dynamic_pairs_.clear();
  contacts_.clear();
  border_contacts_.clear();
  border_ghosts_.clear();
  fixed_is_indexed_ = false;
  springs_ = {};
  border_rule = {};
  wrench_applied_ = false;
  last_sub_step_ = 0.0;
  refused_bits_ = 0;
  refused_ = 0;
}

// Invariants that a world keeps by itself and that bytes from a damaged tape may violate.
bool World::is_consistent() const noexcept {
  const auto ascending = [this](const BoundedVector<Body>& bodies, BodyKind kind) noexcept {
    for (std::uint32_t i = 0; i < bodies.size(); ++i) {
      const Body& b = bodies[i];
      if (b.id >= kFirstPatchId || b.kind != kind) return false;
      if (!is_known(b.shape, kind == BodyKind::kFixed, shapes_)) return false;
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
    if (spring.enabled && number_of(spring.slot) >= bodies_.size()) return false;
  return !traits_of(border_rule.mode).name.empty();
}

bool World::restore(ByteReader& in) noexcept {
  clear();
  const auto read = [&]() noexcept {
    StateReader io{in};
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
    fields(io, border_rule.mode, border_rule.available_J, last_sub_step_, refused_bits_, refused_);
    return effects_.restore(in) && in.ok() && is_consistent();
  };
  if (!read()) {
    clear();
    return false;
  }
  fixed_bounds_.resize(fixed_bodies_.size());
  fixed_frames_.resize(fixed_bodies_.size());
  for (std::uint32_t i = 0; i < fixed_bodies_.size(); ++i) {
    fixed_bounds_[i] = bounds_of(fixed_bodies_[i].shape, fixed_bodies_[i].motion.pose, 0.0);
    fixed_frames_[i] = BodyFrame::of(fixed_bodies_[i].motion.pose);
  }
  return true;
}

}  // namespace tactus::physics
