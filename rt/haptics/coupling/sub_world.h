// The haptic sub-world: the bodies that the hand can feel now, simulated at the device's rate.
//
// Between two synchronisations it is a World of its own, with the device on a spring and the border contacts as rows.
// At a synchronisation it first reports (H(n): its members as they are) and then adopts (G(n): who is a member now,
// joiners' state, border impulses). Members are never overwritten from outside, but for the buffer of a ghost border
// (border_buffer.h). The coupling scheme's traits decide which part of that happens, and its local model what a tick
// is: members in their world, the interpolated proxy, or the proxy on planes. Thread: construction and set_members are
// [setup]; the rest [rt], the haptic thread. Frame: world. Units: SI. Bound: kMaxMembers members, kMaxBorderPoints
// border contacts; what does not fit is counted. Source: the paper, sections 2 and 3.3.
#pragma once

#include "rt/haptics/coupling/border_buffer.h"
#include "rt/haptics/coupling/border_import.h"
#include "rt/haptics/coupling/border_tank.h"
#include "rt/haptics/coupling/coupling_gains.h"
#include "rt/haptics/coupling/coupling_scheme.h"
#include "rt/haptics/coupling/device_track.h"
#include "rt/haptics/coupling/plane_coupling.h"
#include "rt/haptics/coupling/proxy_interpolation.h"
#include "rt/physics/world.h"

namespace tactus::haptics {

struct SubWorldConfig {
  CouplingScheme scheme{CouplingScheme::kSubWorld};
  physics::BorderMode border_mode{physics::BorderMode::kCapped};
  std::uint32_t ratio{10};  // ticks per cycle
  BodyId proxy{0};
  physics::StepSettings step;  // dt is the tick; sub_steps is what the governor may lower
  CouplingGains gains;         // world units
  physics::Capacities capacities;
  physics::Hulls hulls;           // of the bodies' shapes; they must outlive the sub-world
  physics::Meshes meshes;         // same
  physics::EffectSetups effects;  // same, what they look into
};

struct SubWorldStep {
  Wrenchd on_device;  // N, N m, world: the mean over the tick of what the coupling does to the device
  physics::StepReport report;
  std::uint32_t status{0};  // StatusBit: world late, border frozen, world fade, proxy contact, capacity, cut
  double force_scale{1};    // below 1 while the world is lost: the output path applies it
};

class SubWorld {
 public:
  SubWorld(const SubWorldConfig& config, std::span<const physics::Body> fixed_bodies);

  // [setup] The members before the first tick, without a snapshot (direct coupling: every dynamic body).
  void set_members(std::span<const physics::Body> bodies) noexcept;

  // A synchronisation: fills H(n) with what was, then takes over G(n).
  void synchronise(const WorldSnapshot& snapshot, SubWorldReport& report) noexcept;

  // The scene shall begin anew, with the proxy there, at rest: the next reports say so. It has when a snapshot of that
  // epoch is taken over, of which everything is new.
  void ask_reset(const Posed& world_from_proxy) noexcept;
  std::uint32_t epoch() const noexcept { return state_.epoch; }
  bool awaits_reset() const noexcept { return state_.wanted_epoch > state_.epoch; }

  // One tick. `sub_steps` as the governor chose.
  SubWorldStep step(const DeviceTarget& target, std::uint32_t sub_steps, const physics::CutPredicate& cut) noexcept;

  const physics::BodyMotion& proxy() const noexcept { return proxy_; }
  std::uint32_t members() const noexcept { return static_cast<std::uint32_t>(world_.bodies().size()); }
  std::uint32_t border_contacts() const noexcept { return world_.border_contacts().size(); }
  std::uint32_t buffer_bodies() const noexcept { return buffer_.size(); }
  std::uint32_t ticks_in_cycle() const noexcept { return state_.ticks_in_cycle; }
  bool exchanges() const noexcept { return coupling_.global_world; }
  double proxy_work_J() const noexcept { return state_.proxy_work_J; }  // done on the proxy by the coupling, so far
  double border_work_J() const noexcept;                                // done on members by the border, so far
  // Kinetic energy that the members gained when the buffer took the global world's state, so far; with sign.
  double buffer_gain_J() const noexcept { return state_.buffer_gain_J; }
  double border_tank_J() const noexcept { return state_.tank.stored_J; }  // what the border may still put in
  double border_owed_J() const noexcept { return state_.tank.owed_J; }    // what it put in beyond that
  const physics::World& world() const noexcept { return world_; }
  const SubWorldConfig& config() const noexcept { return config_; }
  std::uint64_t state_hash() const noexcept;

  void save(ByteWriter& out) const noexcept;
  [[nodiscard]] bool restore(ByteReader& in) noexcept;
  std::size_t save_size_bound() const noexcept;

 private:
  struct State {  // everything that is not in world_ and that the next tick depends on
    std::uint32_t ticks_in_cycle{0};
    std::uint32_t last_sub_steps{0};
    std::uint32_t has_snapshot{0};
    std::uint32_t epoch{0}, wanted_epoch{0};
    std::uint32_t padding{0};
    Posed proxy_start;      // of the epoch wanted
    Wrenchd cycle_impulse;  // N s, N m s: on the proxy by the coupling, this cycle
    DeviceTrack device;
    ProxyInterpolation interpolated;
    double border_work_J{0};
    double buffer_gain_J{0};
    double proxy_work_J{0};
    BorderTank tank;  // where the border has a budget
  };

  // sub_world_report.cpp
  void fill_report(const WorldSnapshot& snapshot, SubWorldReport& report) const noexcept;
  void report_leavers(const WorldSnapshot& snapshot, SubWorldReport& report) const noexcept;
  void report_border(SubWorldReport& report) const noexcept;

  void forget_world(std::uint32_t epoch) noexcept;
  void change_members(const WorldSnapshot& snapshot) noexcept;
  void adopt_border(const WorldSnapshot& snapshot) noexcept;
  void adopt_buffer(const WorldSnapshot& snapshot, const Vec3d& coupling_force_N) noexcept;
  void adopt_near_triangles(const WorldSnapshot& snapshot) noexcept;
  void freeze_all_but_proxy() noexcept;

  WorldLateness apply_lateness() noexcept;
  double tank_credit_J() const noexcept;
  void step_members(const DeviceTarget& target, std::uint32_t sub_steps, const physics::CutPredicate& cut,
                    SubWorldStep& result) noexcept;
  physics::StepReport step_world(const physics::StepSettings& settings, const physics::CutPredicate& cut,
                                 SubWorldStep& result) noexcept;
  void step_interpolated(const DeviceTarget& target, SubWorldStep& result) noexcept;
  void step_on_planes(const DeviceTarget& target, SubWorldStep& result) noexcept;
  void feel_proxy(const DeviceTarget& target, SubWorldStep& result) noexcept;
  void add_cycle_impulse(const Wrenchd& impulse) noexcept;
  bool proxy_touches() const noexcept;

  SubWorldConfig config_;
  CouplingTraits coupling_;
  physics::BorderTraits border_;
  physics::World world_;
  // As adopted; none without meshes. They never show in a result (near_triangles.h), so they are no part of the state.
  BoundedVector<physics::NearRegion> near_regions_;
  BoundedVector<std::uint32_t> near_triangles_;
  physics::BodyMotion proxy_;
  BorderImport border_import_;
  BorderBuffer buffer_;   // empty but with the ghost border
  PlaneCoupling planes_;  // empty but with the couplings that feel planes
  State state_;
};

}  // namespace tactus::haptics
