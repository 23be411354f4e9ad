// The haptic sub-world: the bodies that the hand can feel now, simulated at the device's rate.
//
// Between two synchronisations it is a separate World, with the device on a spring and the border contacts as rows. A
// synchronisation first corrects the members' state by what the snapshot G(n) says of the border's error
// (border_correction.h; ghost border only), then fills the report H(n) with it, then adopts the rest of G(n): the new
// member list, the joiners' state, border impulses. The coupling scheme's traits select which of these steps happen;
// its local model selects what a tick simulates: the members' world, the interpolated proxy, or the proxy on planes.
// Thread: construction and set_members are [setup]; the rest [rt], the haptic thread. Frame: world. Units: SI. Bound:
// kMaxMembers members, kMaxBorderPoints border contacts; entries that do not fit are counted. Source: the paper,
// sections 2 and 3.3.
#pragma once

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
  physics::BorderMode border_mode{physics::kDefaultBorder};
  std::uint32_t ratio{10};  // ticks per cycle
  BodyId proxy{0};
  physics::StepSettings step;  // dt: the tick; sub_steps: the maximum, the governor may choose fewer
  CouplingGains gains;         // world units
  physics::Capacities capacities;
  physics::ShapeLists shapes;     // of the bodies' shapes; must outlive the sub-world
  physics::EffectSetups effects;  // the data they refer to must outlive the sub-world
};

struct SubWorldStep {
  Wrenchd on_device;  // N, N m, world: wrench of the coupling on the device, mean over the tick
  physics::StepReport report;
  std::uint32_t status{0};  // StatusBit: world late, border frozen, world fade, proxy contact, capacity, cut
  double force_scale{1};    // below 1 while the global world is lost; applied by the output path
};

class SubWorld {
 public:
  SubWorld(const SubWorldConfig& config, std::span<const physics::Body> fixed_bodies);

  // [setup] Sets the members before the first tick, without a snapshot (direct coupling: every dynamic body).
  void set_members(std::span<const physics::Body> bodies) noexcept;

  // Synchronises: corrects the members, fills the report H(n) of the cycle that ended, adopts the snapshot G(n).
  void synchronise(const WorldSnapshot& snapshot, SubWorldReport& report) noexcept;

  // Continues from the state that another sub-world with the same members reported: their motion and effects.
  void continue_from(const SubWorldReport& report) noexcept;

  // Requests a scene reset with the proxy at rest at this pose. Every report repeats the request until a snapshot of
  // the new epoch has been adopted.
  void ask_reset(const Posed& world_from_proxy) noexcept;
  std::uint32_t epoch() const noexcept { return state_.epoch; }
  bool awaits_reset() const noexcept { return state_.wanted_epoch > state_.epoch; }

  // Computes one tick. `sub_steps`: the governor's choice.
  SubWorldStep step(const DeviceTarget& target, std::uint32_t sub_steps, const physics::CutPredicate& cut) noexcept;

  const physics::BodyMotion& proxy() const noexcept { return proxy_; }
  std::uint32_t members() const noexcept { return static_cast<std::uint32_t>(world_.bodies().size()); }
  std::uint32_t border_contacts() const noexcept { return world_.border_contacts().size(); }
  std::uint32_t ticks_in_cycle() const noexcept { return state_.ticks_in_cycle; }
  bool exchanges() const noexcept { return coupling_.global_world; }
  double proxy_work_J() const noexcept { return state_.proxy_work_J; }  // by the coupling on the proxy, since the start
  double border_work_J() const noexcept;                                // by the border on members, since the start
  // Work of position correction on all members (rt/physics/push_out.h), while there are ghosts.
  double push_out_J() const noexcept { return state_.push_out_J; }
  // Energy that corrections gave to members and the device's spring, with sign; since the start.
  double corrected_J() const noexcept { return state_.corrected_J; }
  double border_tank_J() const noexcept { return state_.tank.stored_J; }    // energy stored for the border
  double border_owed_J() const noexcept { return state_.tank.owed_J; }      // energy that it supplied beyond that
  double border_credit_J() const noexcept { return state_.tank.credit_J; }  // energy that it may owe in this cycle
  const physics::World& world() const noexcept { return world_; }
  const SubWorldConfig& config() const noexcept { return config_; }
  std::uint64_t state_hash() const noexcept;

  void save(ByteWriter& out) const noexcept;
  [[nodiscard]] bool restore(ByteReader& in) noexcept;
  std::size_t save_size_bound() const noexcept;

 private:
  struct State {  // everything outside of world_ that the next tick depends on
    std::uint32_t ticks_in_cycle{0};
    std::uint32_t last_sub_steps{0};
    std::uint32_t has_snapshot{0};
    std::uint32_t epoch{0}, wanted_epoch{0};
    std::uint32_t padding{0};
    Posed proxy_start;      // world: after the requested reset
    Wrenchd cycle_impulse;  // N s, N m s: by the coupling on the proxy, in this cycle
    DeviceTrack device;
    ProxyInterpolation interpolated;
    double border_work_J{0};
    double corrected_J{0};
    double proxy_work_J{0};
    BorderTank tank;       // used if the border has a tank
    double replayed_J{0};  // J a tick, of a border that replays: border_work_J of the snapshot / ratio
    double push_out_J{0}, cycle_push_out_J{0};  // since the start, in this cycle
    // What members received, less their energy, when the cycle began; what they dissipated and the tank has not got.
    double received_at_start_J{0}, dissipated_J{0};
  };

  // The members that are none in the snapshot, by slot.
  struct Leaving {
    std::array<std::uint8_t, kMaxMembers> slots{};
    bool any{false};
  };
  Leaving find_leaving(const WorldSnapshot& snapshot) const noexcept;

  // sub_world_report.cpp
  void fill_report(const WorldSnapshot& snapshot, const Leaving& leaving, SubWorldReport& report) const noexcept;
  void report_leavers(const Leaving& leaving, SubWorldReport& report) const noexcept;
  void report_border(SubWorldReport& report) const noexcept;

  double members_J() const noexcept;
  // By coupling, border and position correction, since the start.
  double received_J() const noexcept { return state_.proxy_work_J + border_work_J() + state_.push_out_J; }
  void note_dissipation() noexcept;
  void correct_members(const WorldSnapshot& snapshot) noexcept;
  void settle_cycle(const WorldSnapshot& snapshot, double taken_by_corrections_J, bool first) noexcept;
  void forget_world(std::uint32_t epoch) noexcept;
  void change_members(const WorldSnapshot& snapshot, const Leaving& leaving) noexcept;
  void adopt_impulses(const WorldSnapshot& snapshot) noexcept;
  void adopt_border(const WorldSnapshot& snapshot) noexcept;
  void adopt_near_triangles(const WorldSnapshot& snapshot) noexcept;
  void freeze_all_but_proxy() noexcept;

  double last_sub_step_s() const noexcept { return config_.step.dt / state_.last_sub_steps; }
  WorldLateness apply_lateness() noexcept;
  void step_members(const DeviceTarget& target, std::uint32_t sub_steps, const physics::CutPredicate& cut,
                    SubWorldStep& result) noexcept;
  physics::StepReport step_world(const physics::StepSettings& settings, const physics::CutPredicate& cut,
                                 SubWorldStep& result) noexcept;
  void step_interpolated(const DeviceTarget& target, SubWorldStep& result) noexcept;
  void step_on_planes(const DeviceTarget& target, SubWorldStep& result) noexcept;
  void feel_proxy(const DeviceTarget& target, SubWorldStep& result) noexcept;
  Wrenchd mean_device_wrench() const noexcept;  // N, N m, world: on the proxy, over the cycle so far
  void add_cycle_impulse(const Wrenchd& impulse) noexcept;
  bool proxy_touches() const noexcept;

  SubWorldConfig config_;
  CouplingTraits coupling_;
  physics::BorderTraits border_;
  physics::World world_;
  // From the snapshot; empty without meshes. They do not affect results (near_triangles.h), so they are not saved.
  BoundedVector<physics::NearRegion> near_regions_;
  BoundedVector<std::uint32_t> near_triangles_;
  physics::BodyMotion proxy_;
  BorderImport border_import_;
  PlaneCoupling planes_;  // empty unless the local model is kProxyOnPlanes
  State state_;
};

}  // namespace tactus::haptics
