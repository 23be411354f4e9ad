// Effect kinematic: bodies that follow a script regardless of contacts; to other bodies they are infinitely heavy.
//
// Without way points a body keeps its velocity. With way points its pose follows its path at its own time, which is
// transferred with it between the worlds, so that a late world causes no jump. Between way points the motion is a
// smooth step (C2); rotation vectors are interpolated component by component, so a path may make several turns about
// one axis.
// Frame: world. Units: SI. Thread: construction [setup]; the rest [rt], the owner of the World. Bound: scripts x log
// bodies, x way points.
#pragma once

#include "rt/physics/effects/stage.h"

namespace tactus::physics {

struct PathKey {
  double time_s{};
  Vec3d position_m, rotation_vector_rad;  // of the frame that follows the path, in world axes
};

struct KinematicScript {
  BodyId id{kNoBody};
  std::uint32_t first_key{0}, keys{0};  // range of its way points, times ascending from 0; none: constant velocity
  bool repeat{false};                   // restarts at its end; otherwise stays there
  Posed key_from_body{};                // of the body's frame in the one that follows the path
};

class ScriptedMotion {
 public:
  struct Setup {  // by id; must outlive the world
    std::span<const KinematicScript> scripts{};
    std::span<const PathKey> keys{};
    bool used() const noexcept { return !scripts.empty(); }
  };
  ScriptedMotion(const Setup& setup, const Capacities& capacities);
  void register_stages(StageTable& table) noexcept;

  std::span<const KinematicScript> scripts() const noexcept { return setup_.scripts; }
  // Time on each script's path [s].
  std::span<const double> times() const noexcept { return time_.span(); }

  void reset() noexcept { std::fill(time_.begin(), time_.end(), 0.0); }
  void save(ByteWriter& out) const noexcept;
  bool restore(ByteReader& in) noexcept;
  std::size_t save_size_bound() const noexcept { return time_.capacity() * sizeof(double); }
  void export_state(ByteWriter& out, std::span<const Body> bodies, std::span<const std::uint8_t> inside) const noexcept;
  bool import_state(ByteReader& in, std::span<const Body> bodies, bool known_too) noexcept;

 private:
  struct Follower {
    std::uint32_t script{0}, slot{0};
    Posed start, now;  // at the start of the step; after the sub-steps so far
  };

  Posed pose_at(const KinematicScript& script, double time_s) const noexcept;
  Posed pose_in_step(const Follower& follower, const Twistd& steady, double elapsed) const noexcept;
  void take_hold(StageContext& c) noexcept;  // of the bodies in this world
  void aim(StageContext& c) noexcept;
  void place(StageContext& c) noexcept;
  void finish(StageContext& c) noexcept;

  Setup setup_;
  BoundedVector<double> time_;
  BoundedVector<Follower> followers_;
};

}  // namespace tactus::physics
