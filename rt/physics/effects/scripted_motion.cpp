#include "rt/physics/effects/scripted_motion.h"

#include <algorithm>

#include "rt/physics/body_search.h"

namespace tactus::physics {
ScriptedMotion::ScriptedMotion(const Setup& setup, const Capacities&)
    : setup_(setup),
      time_(static_cast<std::uint32_t>(setup.scripts.size())),
      followers_(static_cast<std::uint32_t>(setup.scripts.size())) {
  time_.resize(time_.capacity());
}

void ScriptedMotion::register_stages(StageTable& table) noexcept {
  table.add<&ScriptedMotion::take_hold>(Phase::kPrepare, *this);
  table.add<&ScriptedMotion::aim>(Phase::kBeginSubStep, *this);
  table.add<&ScriptedMotion::place>(Phase::kMoved, *this);
  table.add<&ScriptedMotion::finish>(Phase::kFinish, *this);
}

Posed ScriptedMotion::pose_at(const KinematicScript& script, double time_s) const noexcept {
  const auto keys = setup_.keys.subspan(script.first_key, script.keys);
  const double end = keys.back().time_s;
  double time = time_s;
  if (script.repeat && end > 0.0) time -= std::floor(time / end) * end;
  const auto next =
      std::upper_bound(keys.begin(), keys.end(), time, [](double t, const PathKey& k) { return t < k.time_s; });
  const PathKey& to = next == keys.end() ? keys.back() : *next;
  const PathKey& from = next == keys.begin() ? keys.front() : *(next - 1);
  const double length = to.time_s - from.time_s;
  const double u = length > 0.0 ? std::clamp((time - from.time_s) / length, 0.0, 1.0) : 1.0;
  const double s = u * u * u * (10.0 - 15.0 * u + 6.0 * u * u);
  const Vec3d turned = from.rotation_vector_rad + s * (to.rotation_vector_rad - from.rotation_vector_rad);
  return Posed{from.position_m + s * (to.position_m - from.position_m), quat_from_rotation_vector(turned)} *
         script.key_from_body;
}

Posed ScriptedMotion::pose_in_step(const Follower& follower, const Twistd& steady, double elapsed) const noexcept {
  const KinematicScript& script = setup_.scripts[follower.script];
  if (script.keys > 0) return pose_at(script, time_[follower.script] + elapsed);
  return {follower.start.position + elapsed * steady.linear,
          normalized(quat_from_rotation_vector(elapsed * steady.angular) * follower.start.rotation)};
}

void ScriptedMotion::take_hold(StageContext& c) noexcept {
  followers_.clear();
  for (std::uint32_t k = 0; k < setup_.scripts.size(); ++k) {
    const std::uint32_t slot = find_slot(c.bodies, setup_.scripts[k].id);
    if (slot == kNoSlot || c.frozen[slot] != 0) continue;
    c.motion[slot].inverse_mass = c.motion[slot].gyroscopic = 0.0;
    c.inverse_inertia[slot] = {};
    const Posed& pose = c.bodies[slot].motion.pose;
    (void)followers_.try_push({.script = k, .slot = slot, .start = pose, .now = pose});
  }
}

// Sets the velocities with which the bodies reach their poses at the end of the sub-step.
void ScriptedMotion::aim(StageContext& c) noexcept {
  const double elapsed = static_cast<double>(c.sub_step + 1) * c.h, rate = 1.0 / c.h;
  for (Follower& f : followers_) {
    const Twistd& steady = c.bodies[f.slot].motion.velocity;
    const Posed next = pose_in_step(f, steady, elapsed);
    SolverBody<double>& body = c.motion[f.slot];
    if (setup_.scripts[f.script].keys > 0) {
      body.v = rate * (next.position - f.now.position);
      body.w = rate * small_rotation_vector(next.rotation * conjugate(f.now.rotation));
    } else {
      body.v = steady.linear;
      body.w = steady.angular;
    }
    f.now = next;
  }
}

void ScriptedMotion::place(StageContext& c) noexcept {
  for (const Follower& f : followers_) {
    c.motion[f.slot].delta_position = f.now.position - f.start.position;
    c.motion[f.slot].delta_rotation = f.now.rotation * conjugate(f.start.rotation);
  }
}

void ScriptedMotion::finish(StageContext& c) noexcept {
  for (const Follower& f : followers_) {
    c.bodies[f.slot].motion = {f.now, {c.motion[f.slot].v, c.motion[f.slot].w}};
    time_[f.script] += c.settings.dt;
  }
}

void ScriptedMotion::save(ByteWriter& out) const noexcept { out.put_all(time_.span()); }

bool ScriptedMotion::restore(ByteReader& in) noexcept {
  in.get_all(time_.span());
  bool good = in.ok();
  for (double& time : time_)
    if (!std::isfinite(time)) {
      time = 0.0;
      good = false;
    }
  return good;
}

// Format: count, then for each body inside the index of its script and its time.
void ScriptedMotion::export_state(ByteWriter& out, std::span<const Body> bodies,
                                  std::span<const std::uint8_t> inside) const noexcept {
  const auto each = [&](auto&& f) noexcept {
    for (std::uint32_t k = 0; k < time_.size(); ++k) {
      const std::uint32_t slot = find_slot(bodies, setup_.scripts[k].id);
      if (slot != kNoSlot && (inside.empty() || inside[slot] != 0)) f(k);
    }
  };
  std::uint32_t count = 0;
  each([&](std::uint32_t) noexcept { ++count; });
  out.put(count);
  each([&](std::uint32_t k) noexcept {
    out.put(k);
    out.put(time_[k]);
  });
}

bool ScriptedMotion::import_state(ByteReader& in, std::span<const Body> bodies, bool known_too) noexcept {
  std::uint32_t count = 0;
  in.get(count);
  for (std::uint32_t i = 0; i < count && in.ok(); ++i) {
    std::uint32_t k = 0;
    double time{};
    in.get(k);
    in.get(time);
    if (!in.ok() || k >= time_.size() || !std::isfinite(time)) return false;
    if (known_too || find_slot(bodies, setup_.scripts[k].id) == kNoSlot) time_[k] = time;
  }
  return in.ok();
}

}  // namespace tactus::physics
