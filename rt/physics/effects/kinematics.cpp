#include "rt/physics/effects/kinematics.h"

#include <algorithm>

#include "rt/physics/body_search.h"

namespace tactus::physics {
template <class T>
Kinematics<T>::Kinematics(const Setup& setup, const Capacities&)
    : setup_(setup),
      time_(static_cast<std::uint32_t>(setup.scripts.size())),
      followers_(static_cast<std::uint32_t>(setup.scripts.size())) {
  time_.resize(time_.capacity());
}

template <class T>
void Kinematics<T>::enter(StageTable<T>& table) noexcept {
  table.template add<&Kinematics::take_hold>(Phase::kPrepare, *this);
  table.template add<&Kinematics::aim>(Phase::kBeginSubStep, *this);
  table.template add<&Kinematics::place>(Phase::kMoved, *this);
  table.template add<&Kinematics::finish>(Phase::kFinish, *this);
}

template <class T>
Pose<T> Kinematics<T>::pose_at(const KinematicScript& script, T time_s) const noexcept {
  const auto keys = setup_.keys.subspan(script.first_key, script.keys);
  const T end = keys.back().time_s;
  T time = time_s;
  if (script.repeat && end > T(0)) time -= std::floor(time / end) * end;
  const auto next =
      std::upper_bound(keys.begin(), keys.end(), time, [](T t, const PathKey<T>& k) { return t < k.time_s; });
  const PathKey<T>& to = next == keys.end() ? keys.back() : *next;
  const PathKey<T>& from = next == keys.begin() ? keys.front() : *(next - 1);
  const T length = to.time_s - from.time_s;
  const T u = length > T(0) ? std::clamp((time - from.time_s) / length, T(0), T(1)) : T(1);
  const T s = u * u * u * (T(10) - T(15) * u + T(6) * u * u);
  return {
      from.position_m + s * (to.position_m - from.position_m),
      quat_from_rotation_vector(from.rotation_vector_rad + s * (to.rotation_vector_rad - from.rotation_vector_rad))};
}

template <class T>
Pose<T> Kinematics<T>::pose_in_step(const Follower& follower, const Twist<T>& steady, T elapsed) const noexcept {
  const KinematicScript& script = setup_.scripts[follower.script];
  if (script.keys > 0) return pose_at(script, time_[follower.script] + elapsed);
  return {follower.start.position + elapsed * steady.linear,
          normalized(quat_from_rotation_vector(elapsed * steady.angular) * follower.start.rotation)};
}

template <class T>
void Kinematics<T>::take_hold(StageContext<T>& c) noexcept {
  followers_.clear();
  for (std::uint32_t k = 0; k < setup_.scripts.size(); ++k) {
    const std::uint32_t slot = find_slot<T>(c.bodies, setup_.scripts[k].id);
    if (slot == kNoSlot || c.held[slot] != 0) continue;
    c.motion[slot].inverse_mass = c.motion[slot].gyroscopic = T(0);
    c.inverse_inertia[slot] = {};
    const Pose<T>& pose = c.bodies[slot].motion.pose;
    (void)followers_.try_push({k, slot, pose, pose});
  }
}

// The velocity that takes each to where it will be at the end of the sub-step.
template <class T>
void Kinematics<T>::aim(StageContext<T>& c) noexcept {
  const T elapsed = static_cast<T>(c.sub_step + 1) * c.h, rate = T(1) / c.h;
  for (Follower& f : followers_) {
    const Twist<T>& steady = c.bodies[f.slot].motion.velocity;
    const Pose<T> next = pose_in_step(f, steady, elapsed);
    SolverBody<T>& body = c.motion[f.slot];
    if (setup_.scripts[f.script].keys > 0) {
      body.v = rate * (next.position - f.now.position);
      body.w = rate * small_rotation_vector(next.rotation * conjugate(f.now.rotation));
    } else {
      body.v = steady.linear, body.w = steady.angular;
    }
    f.now = next;
  }
}

template <class T>
void Kinematics<T>::place(StageContext<T>& c) noexcept {
  for (const Follower& f : followers_) {
    c.motion[f.slot].delta_position = f.now.position - f.start.position;
    c.motion[f.slot].delta_rotation = f.now.rotation * conjugate(f.start.rotation);
  }
}

template <class T>
void Kinematics<T>::finish(StageContext<T>& c) noexcept {
  for (const Follower& f : followers_) {
    c.bodies[f.slot].motion = {f.now, {c.motion[f.slot].v, c.motion[f.slot].w}};
    time_[f.script] += c.settings.dt;
  }
}

template <class T>
void Kinematics<T>::save(ByteWriter& out) const noexcept {
  out.put_all(time_.span());
}

template <class T>
bool Kinematics<T>::restore(ByteReader& in) noexcept {
  in.get_all(time_.span());
  bool good = in.ok();
  for (T& time : time_)
    if (!std::isfinite(time)) time = T(0), good = false;
  return good;
}

// Count, then for each body here: the script's number and its time.
template <class T>
void Kinematics<T>::hand_over(ByteWriter& out, std::span<const Body<T>> bodies,
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
  each([&](std::uint32_t k) noexcept { out.put(k), out.put(time_[k]); });
}

template <class T>
bool Kinematics<T>::take_over(ByteReader& in, std::span<const Body<T>> bodies, bool known_too) noexcept {
  std::uint32_t count = 0;
  in.get(count);
  for (std::uint32_t i = 0; i < count && in.ok(); ++i) {
    std::uint32_t k = 0;
    T time{};
    in.get(k), in.get(time);
    if (!in.ok() || k >= time_.size() || !std::isfinite(time)) return false;
    if (known_too || find_slot(bodies, setup_.scripts[k].id) == kNoSlot) time_[k] = time;
  }
  return in.ok();
}

template class Kinematics<double>;
template class Kinematics<float>;

}  // namespace tactus::physics
