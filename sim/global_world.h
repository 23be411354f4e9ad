// The global world: simulates every body of the scene, one step of r ticks per cycle, beside the haptic sub-worlds.
//
// One cycle: read the report H(n), impose the members' state, apply the returned border impulses, run the prediction of
// the sub-world (ghost border only, sim/exchange/sub_world_prediction.h), step by r T, choose the members of cycle
// n + 1, write the snapshot G(n+1). The sub-world moves the members; a snapshot contains the state of joiners, and
// corrections of the others (rt/haptics/coupling/border_correction.h). The coupling schemes differ in `impose` and
// `fill_snapshot`; the direct coupling has no global world.
//
// Devices: a device is a proxy with its sub-world (GlobalOptions::more_devices). A body is a member of at most one
// sub-world; for the others it is outside. It remains a member while it touches that sub-world's proxy; once it has not
// touched that proxy for ExtractionOptions::linger_cycles and touches another one, it leaves and may join the other:
// sim/global_world_devices.cpp. With several devices a step imposes each report, advances once, and fills each
// snapshot.
//
// Sleeping: with the effect of that name, resting islands are removed from the world: island_manager.h. Proxies,
// members, all bodies connected to them, and all bodies in reach of a proxy are always awake.
//
// Thread: construction [setup]; the rest: one owner, any priority; a step allocates nothing, the first snapshot and a
// reset do. Frame: world. Units: SI. Bound: capacities from the scene's size; overflow by the engine's rules, bits in
// the statistics. Source: the paper, section 2; several displays are its future work.
#pragma once

#include <memory>
#include <string>

#include "rt/base/result.h"
#include "rt/haptics/coupling/coupling_scheme.h"
#include "rt/haptics/coupling_limits.h"
#include "rt/physics/overlap.h"
#include "sim/broad_phase/pair_cache.h"
#include "sim/energy_balance.h"
#include "sim/exchange/approach.h"
#include "sim/exchange/border_exchange.h"
#include "sim/exchange/extraction.h"
#include "sim/exchange/sub_world_prediction.h"
#include "sim/island_manager.h"
#include "sim/model/scene.h"
#include "sim/model/step_settings.h"
#include "sim/worker_pool.h"

namespace tactus::sim {

// A device beside the scene's first.
struct FurtherDevice {
  BodyId proxy{kNoBody};           // a dynamic body of the scene
  haptics::CouplingGains gains{};  // as GlobalOptions::gains
  // m/s, rad/s: as in ReachSettings
  double max_speed_m_per_s{1}, max_angular_speed_rad_per_s{10};
};

struct GlobalOptions {
  haptics::CouplingScheme coupling{haptics::CouplingScheme::kSubWorld};
  physics::BorderMode border_mode{physics::kDefaultBorder};
  ExtractionOptions extraction;
  std::vector<FurtherDevice> more_devices{};
  ReachSettings reach;  // includes the ratio and the tick period
  physics::SweepPrecision precision{physics::SweepPrecision::kSingle};
  haptics::CouplingGains gains;       // of the coupling of device and proxy, world units; equal to the haptic side's
  std::uint32_t haptic_sub_steps{0};  // in a tick, as on the haptic side; 0: the scene's
  double touch_tolerance_m{1e-4};     // before the first step, bodies at most this far apart count as touching
};

// Work of a tick of the predicted sub-worlds, summed over devices; 0 without predictions.
struct PredictionWork {
  std::uint32_t members{0}, pairs{0}, contacts{0}, points{0}, comparisons{0}, border{0};
  std::uint32_t sub_steps{0};
};

// Counts and sums since the start; most_*: maxima.
struct GlobalStatistics {
  std::uint64_t steps{0};
  std::uint32_t bodies{0}, fixed_bodies{0};
  std::uint32_t awake{0}, asleep{0}, most_awake{0};  // of the moving bodies
  std::uint64_t fell_asleep{0}, woke_up{0};          // bodies
  std::uint32_t pairs{0}, contacts{0}, points{0};    // of the last step
  std::uint32_t comparisons{0};                      // box comparisons of the last step's collision detection
  PredictionWork prediction;
  std::uint32_t most_pairs{0}, most_contacts{0}, most_members{0}, most_component{0}, most_border_points{0};
  std::uint32_t most_close_left_out{0};
  std::uint64_t joins{0}, leaves{0};
  std::uint64_t handed_over{0};      // members that left a sub-world because they touch another proxy
  std::uint64_t dropped_entries{0};  // what did not fit: pairs, contacts, triangles of a step, entries of a snapshot
  std::uint64_t rejected_states{0};  // members whose reported state was not finite
  std::uint32_t capacity_bits{0};    // physics::CapacityBit
  // Energy at the border, with sign.
  double border_work_J{0};            // work of outside bodies on members in the steps (with ghosts)
  double imposed_energy_J{0};         // change, kinetic and potential, when members' states are imposed
  double returned_impulse_Ns{0};      // sum of the magnitudes of impulses returned to outside bodies
  double returned_energy_J{0};        // kinetic energy that these gave
  std::uint64_t returned_skipped{0};  // ImpulseReturn::skipped
  double stopped_energy_J{0};         // kinetic energy of bodies when they fell asleep
  double deepest_m{0};                // deepest overlap
  physics::Overlap overlap;           // of all contacts so far, the deepest relative to its bodies' thickness
  EnergyBalance energy;
  std::uint32_t broken_joints{0};  // at present
  std::uint32_t resets{0};         // scene resets
};

// Checks whether the scene can run with these options. An error is one line with the reason.
Status check_global_options(const Scene& scene, const GlobalOptions& options);

class GlobalWorld {
 public:
  // The options must have passed check_global_options. The scene must outlive the world.
  GlobalWorld(const Scene& scene, const GlobalOptions& options);

  // [setup] From now on the pool's threads share the work of the steps; the results stay the same, bit by bit.
  void share_work(WorkerPool& pool);

  // [setup] Imports another world's state: the motion of moving bodies, and their contacts' impulses as warm starts.
  void set_state(std::span<const physics::Body> bodies, std::span<const physics::WarmStart> contacts) noexcept;

  // G(0): members chosen from the initial poses, before the first step.
  void first_snapshot(haptics::WorldSnapshot& first, std::uint32_t device = 0) noexcept;
  // One cycle: from H(n) to G(n+1). If the report requests a new epoch, the scene is reset instead: to its file's
  // state, with the proxy at the pose in the report. A reset allocates, and takes as long as a start.
  void step(const haptics::SubWorldReport& report, haptics::WorldSnapshot& next) noexcept;

  // The same for several devices, by device. Null: no report has come from that device; its proxy is brought to rest,
  // its members move with the world, and no snapshot is written for it. A reset waits until all devices request it.
  void step(std::span<const haptics::SubWorldReport* const> reports,
            std::span<haptics::WorldSnapshot* const> next) noexcept;

  // Everything that the following steps depend on. A copy for restore() of a world with the same scene and options.
  struct Saved;
  // [setup] Both allocate.
  std::shared_ptr<const Saved> save() const;
  void restore(const Saved& saved);

  // The parts of `step`, by device.
  void impose(std::uint32_t device, const haptics::SubWorldReport& report) noexcept;
  void advance() noexcept;
  void fill_snapshot(std::uint32_t device, std::uint64_t cycle, std::uint32_t budget,
                     haptics::WorldSnapshot& next) noexcept;
  std::uint32_t devices() const noexcept { return static_cast<std::uint32_t>(devices_.size()); }
  std::uint32_t epoch() const noexcept { return statistics_.resets; }

  const physics::World& world() const noexcept { return world_; }  // the awake bodies
  // All moving bodies by id, sleeping ones included, as after the last step.
  std::span<const physics::Body> bodies() const noexcept { return islands_.bodies().span(); }
  bool is_asleep(BodyId id) const noexcept;
  const Extraction& extraction(std::uint32_t device = 0) const noexcept { return devices_[device].extraction; }
  // The bodies that contacts connect to the proxy, as of the last snapshot; indices into bodies(), the proxy first.
  std::span<const BodyIndex> component(std::uint32_t device = 0) const noexcept { return devices_[device].component; }
  BodyId proxy_of(std::uint32_t device) const noexcept { return devices_[device].id; }
  // s: the time over which the impulses of world().contacts() are summed; 0 before the first step.
  double impulse_s() const noexcept { return macro_step_s_; }
  const GlobalStatistics& statistics() const noexcept { return statistics_; }
  double time_s() const noexcept { return time_s_; }
  double step_s() const noexcept { return settings_.dt; }
  std::uint32_t sub_steps() const noexcept { return settings_.sub_steps; }  // of a step
  double kinetic_energy_J() const noexcept { return world_.kinetic_energy(); }
  // Of contacts and joints (sim/energy_balance.h).
  double springs_J() const noexcept { return sim::springs_J(world_, settings_.contact_hertz, settings_.slop); }
  double potential_energy_J() const noexcept {
    return world_.potential_energy(settings_.gravity) + islands_.potential_energy(settings_.gravity);
  }
  Wrenchd momentum() const noexcept { return world_.momentum(); }
  std::uint64_t state_hash() const noexcept { return islands_.state_hash(world_.state_hash()); }

 private:
  static constexpr std::uint32_t kLongApart = 1u << 20;

  // Bodies are identified by BodyIndex; slots are the world's.
  struct Device {
    BodyId id;  // of the proxy
    BodyIndex proxy;
    Extraction extraction;
    haptics::CouplingGains gains;  // world units
    ReachSettings reach;
    Posed reported_proxy;          // the proxy's pose at t_n in the sub-world
    Wrenchd device_wrench{};       // N, N m: applied to the proxy over the next step
    Wrenchd last_device_wrench{};  // N, N m: mean device wrench of the last cycle
    ExtrapolatedHand hand{};       // over the next step; target of hold_proxy's spring
    bool has_border{false};        // its last snapshot has outside bodies
    double border_work_J{0};       // of outside bodies on its members, in the last step
    // With several devices: steps since the body, or one jointed to it, last touched the proxy; 0: it does. At most
    // kLongApart.
    BodyVector<std::uint32_t> apart{};
    std::vector<BodyIndex> component{};  // bodies that contacts and joints link to its proxy
  };

  physics::SlotIndex slot_of(const Device& device) const noexcept;
  std::span<const std::uint8_t> member_slots(const Device& device) noexcept;
  std::span<const std::uint8_t> slots_of_all_members() noexcept;
  void add_device(const Scene& scene, const FurtherDevice& device);
  void build_graph() noexcept;
  void leave_out(Device& device) noexcept;
  void note_touched_bodies(Device& device) noexcept;
  void find_free_bodies(const Device& device) noexcept;
  bool must_leave(const Device& device, BodyIndex body) const noexcept;
  // Does a prediction of each sub-world run? With ghosts only: the other borders do not correct members.
  bool predicts() const noexcept { return !predictions_.empty(); }
  PredictionWork prediction_work() const noexcept;
  void choose_members(std::uint32_t device, std::uint64_t cycle, std::uint32_t budget,
                      haptics::WorldSnapshot& next) noexcept;
  void fill_border(const Device& device, haptics::WorldSnapshot& next) noexcept;
  void wake_for(const haptics::SubWorldReport& report) noexcept;
  void wake_near(const Device& device) noexcept;
  void mark_kept_awake() noexcept;
  void sleep() noexcept;
  physics::CoarseRegion coarse_region() noexcept;
  std::uint32_t macro_steps_of_step() noexcept;
  physics::StepReport take_macro_step(std::uint32_t macro_step, std::uint32_t macro_steps) noexcept;
  // Two cycles: what a step finds has reached the sub-world at the end of the next one.
  double approach_horizon_s() const noexcept { return 2 * settings_.dt; }
  double sub_step_s() const noexcept { return settings_.dt / settings_.sub_steps; }
  void sleep_from_start() noexcept;
  void take_hand(Device& device, const haptics::SubWorldReport& report) noexcept;
  void hold_proxy(double elapsed_s, double macro_step_s) noexcept;
  void update_energy_balance(const haptics::SubWorldReport& report) noexcept;
  void look_at_overlaps(double deepest_m) noexcept;
  void note_member_velocities() noexcept;
  void add_border_work() noexcept;
  void impose_motion(Device& device, const haptics::SubWorldReport& report) noexcept;
  void find_touches_at_rest() noexcept;
  double outside_motion_J(const Device& device) noexcept;
  void predict_border(std::uint32_t device, haptics::WorldSnapshot& first) noexcept;
  void find_touches() noexcept;
  void add_joined() noexcept;
  void add_approaching() noexcept;
  void add_approaching(const Device& device) noexcept;
  void fill_joiners(const Device& device, haptics::WorldSnapshot& next) noexcept;
  void fill_warm_starts(const Device& device, const SubWorldPrediction* prediction,
                        haptics::WorldSnapshot& next) noexcept;
  void count(const Device& device, const haptics::WorldSnapshot& next) noexcept;
  void count(const ImpulseReturn& back) noexcept;

  std::vector<std::byte> saved_world() const;                     // allocates
  void restore_world(std::span<const std::byte> bytes) noexcept;  // saved_world() of a world of the same scene

  // References to everything that a step changes, world_ apart: it saves itself.
  template <class Self>
  static auto state_of(Self& self) noexcept;

  void reset(std::span<const haptics::SubWorldReport* const> reports);
  void fill_first(std::uint32_t device, std::uint64_t cycle, std::uint32_t budget,
                  haptics::WorldSnapshot& next) noexcept;

  const Scene* scene_;
  GlobalOptions options_;
  haptics::CouplingTraits coupling_;
  physics::BorderTraits border_;
  GlobalStep global_step_;
  WorkerPool* pool_{nullptr};  // null: the work is not shared
  bool stepped_{false};        // at least one step since the scene's start or reset
  double macro_step_s_{0};     // s: length of the last macro step; the contacts' impulses are over it
  physics::StepSettings settings_, bounds_settings_;  // bounds_settings_: with the sub-steps of the coarse region
  physics::World world_;
  IslandManager islands_;
  PairCache pair_cache_;
  ContactGraph graph_;
  Approach approach_;
  BorderExchange border_exchange_;
  std::vector<Device> devices_;
  std::vector<std::unique_ptr<SubWorldPrediction>> predictions_;  // by device, or empty
  std::vector<ContactEdge> touches_;
  std::vector<physics::Aabb> bounds_;
  BodyVector<std::uint8_t> free_;           // 1 if it may be a member of the sub-world in question
  BodyVector<std::uint8_t> kept_awake_;     // 1 if member of a sub-world or kinematic: stays awake
  std::vector<std::uint8_t> member_slots_;  // by slot: 1 if member of the sub-world in question
  std::vector<BodyIndex> touched_bodies_;   // of note_touched_bodies
  std::vector<Twistd> velocity_before_;     // by slot, of members only: at the start of the macro step
  std::vector<physics::Aabb> regions_;      // by device: region in which nothing falls asleep
  double thinnest_m_{0};                    // thickness of the thinnest body
  double asleep_J_{0};                      // cached potential energy of the sleeping bodies
  std::uint64_t asleep_of_{0};              // asleep_J_ is valid for this sum of fell_asleep and woke_up
  double time_s_{0};
  GlobalStatistics statistics_;
};

}  // namespace tactus::sim
