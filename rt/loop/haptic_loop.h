// One tick of the haptic loop: from the device's sample to its command. Pure: no clock, no I/O, no thread.
//
//   guard -> adopt snapshot -> arm -> couple -> step sub-world -> wrench -> passivity -> limit -> command
//
// A tick depends only on its input and the state, and the state can be saved, so a replay of the tape is bit-identical.
// Thread: construction [setup]; tick() [rt]. Frame: device frame at both ends, world inside. Units: SI. Faults that it
// can raise: all of status.h. A fault latches, fades the force to zero and lasts until a re-arm.
#pragma once

#include "rt/base/nonblocking.h"
#include "rt/base/status.h"
#include "rt/haptics/coupling/sub_world.h"
#include "rt/haptics/device_placement.h"
#include "rt/haptics/force_limiter.h"
#include "rt/haptics/force_watch.h"
#include "rt/haptics/input_guard.h"
#include "rt/haptics/passivity.h"
#include "rt/haptics/velocity_estimator.h"
#include "rt/loop/governor.h"
#include "rt/loop/tick_stages.h"

namespace tactus::loop {

struct LoopConfig {
  double period_s{1e-3};
  haptics::SubWorldConfig sub_world;
  haptics::DeviceProperties device;
  haptics::DevicePlacement::Config placement;
  double thinnest_m{0};                   // of all bodies: larger overlaps than a share of it are analysed; 0: none
  std::uint32_t emergency_stop_fault{0};  // the firmware's fault number of its e-stop
};

// Operator requests as bits; each applies to the tick that it is passed to.
enum OperatorBit : std::uint32_t {
  kArm = 1u << 0,     // engage: couple the device at its present pose, force on
  kRearm = 1u << 1,   // clear a latched fault, command the device out of BRAKE, engage; otherwise no effect
  kDisarm = 1u << 2,  // force off
  // The e-stop's status line beside the link is active: Fault kEmergencyStop, and zero force from this tick on, without
  // a fade. The cut itself happens in the firmware or the hardware.
  kEmergencyStopLine = 1u << 3,
  // Reset the scene: the force fades; the global world restarts with the proxy at the device's pose (clutch offsets
  // cleared); the proxy is left to come to rest; then the force returns. Not with the direct coupling.
  kReset = 1u << 4,
  // While set, a reset that is in progress waits with the force off before it resets the scene: the hand has not
  // returned yet.
  kHoldReset = 1u << 5,
  // End the run: the force fades within kEndFade_s, then the device is commanded to IDLE and arming is disabled. A
  // latched fault stays latched. To be set in every tick until the end.
  kEnd = 1u << 6,
};
inline constexpr double kEndFade_s = 0.05;

// Publishes the report H(n). Called after the adoption, before the rest of the tick.
struct ReportSink {
  haptics::SubWorldReport* report{nullptr};
  void (*publish)(void* context, std::uint64_t cycle) noexcept {nullptr};
  void* context{nullptr};
};

struct TickInput {
  haptics::DeviceInput device;
  std::uint32_t operator_bits{0};
  std::uint32_t sub_steps{4};
  const haptics::WorldSnapshot* snapshot{nullptr};  // null: no adoption in this tick
  ReportSink sink;                                  // required with a snapshot
  physics::CutPredicate cut;
  StageObserver stages;
};

// Result of a tick. No padding: tapes compare it byte by byte.
struct TickOutput {
  std::uint64_t tick{0};
  haptics::DeviceCommand command;
  Fault fault{Fault::kNone};  // latched fault
  std::uint32_t status{0};    // StatusBit, of this tick
  std::uint32_t members{0}, border{0}, pairs{0}, contacts{0}, points{0}, capacity_bits{0}, dropped{0};
  std::uint32_t cut_sweep{physics::kNeverCut};
  double deepest_m{0};
  double deepest_share{0};  // overlap / thickness of the thinner body; 0: below a twentieth of the thinnest of all
  Posed target;             // world: target of the coupling
  physics::BodyMotion proxy;
  Wrenchd wanted;             // N, N m, device frame: before passivity and limits
  double device_energy_J{0};  // into the virtual side at the device port, since the start, counted when felt
  double damped_energy_J{0};  // dissipated by the passivity controller, since the start
  double border_work_J{0};    // by border and push-out on members, since the start, with sign
  double corrected_J{0};      // given to members and the device's spring by corrections, since the start, with sign
  double border_tank_J{0};    // energy that the border may still supply
};
static_assert(std::is_trivially_copyable_v<TickOutput>);
static_assert(sizeof(TickOutput) == 8 + sizeof(haptics::DeviceCommand) + 10 * 4 + 2 * 8 + sizeof(Posed) +
                                        sizeof(physics::BodyMotion) + sizeof(Wrenchd) + 5 * 8);

class HapticLoop {
 public:
  HapticLoop(const LoopConfig& config, std::span<const physics::Body> fixed_bodies);

  // [setup] Members before the first tick, for the direct coupling.
  void set_members(std::span<const physics::Body> bodies) noexcept { sub_world_.set_members(bodies); }

  // Overwrites all of `out`. The caller keeps input and output for the tape.
  void tick(const TickInput& in, TickOutput& out) noexcept TACTUS_NONBLOCKING;

  // True if the next tick is to adopt a snapshot; its number is next_cycle().
  bool wants_snapshot() const noexcept;
  std::uint64_t next_cycle() const noexcept { return state_.next_cycle; }
  std::uint64_t ticks() const noexcept { return state_.tick; }  // done so far
  // Counts of the last tick, for the governor.
  WorkCounts counts() const noexcept;

  const haptics::SubWorld& sub_world() const noexcept { return sub_world_; }
  const LoopConfig& config() const noexcept { return config_; }
  std::uint64_t state_hash() const noexcept;

  // Saves and restores everything that the next tick depends on.
  void save(ByteWriter& out) const noexcept;
  [[nodiscard]] bool restore(ByteReader& in) noexcept;
  std::size_t save_size_bound() const noexcept;

 private:
  enum class Reset : std::uint32_t { kNone, kFading, kAsked, kResting };
  struct State {
    std::uint64_t tick{0};
    std::uint64_t next_cycle{0};
    Fault fault{Fault::kNone};
    std::uint32_t armed{0};    // the operator has requested force
    std::uint32_t engaged{0};  // the proxy is coupled to the device
    std::uint32_t rearm{0};    // command the device to leave BRAKE, until it has
    double recovered{1};       // share of the force: the ramp after engaging, a fade or a lost world
    double ramp_s{0.2};        // duration of the ramp from 0 to 1
    Reset reset{Reset::kNone};
    std::uint32_t ending{0};  // 1: kEnd was requested
    double reset_left_s{0};   // remaining time of the fade or the rest
    double ending_left_s{0};  // remaining time of the fade
    double missed_share{1};   // share of the force after missed frames and commands, in the last tick
    Posed last_tool;          // device frame, in the tick before
  };

  void guard(const haptics::DeviceInput& in, TickOutput& out) noexcept;
  void watch_force(const haptics::DeviceInput& in) noexcept;
  void adopt(const TickInput& in) noexcept;
  void arm(std::uint32_t operator_bits, TickOutput& out) noexcept;
  void engage() noexcept;
  void reset_scene(bool hold) noexcept;
  haptics::DeviceTarget couple(TickOutput& out) noexcept;
  void step(const haptics::DeviceTarget& target, const TickInput& in, TickOutput& out) noexcept;
  double recovered_share(double world_scale, bool world_fades) noexcept;
  void shape_force(TickOutput& out) noexcept;
  void command(TickOutput& out) noexcept;
  haptics::StoredEnergy stored_energy(const TickOutput& out) const noexcept;

  LoopConfig config_;
  haptics::SubWorld sub_world_;
  haptics::InputGuard guard_;
  haptics::VelocityEstimator velocity_;
  haptics::DevicePlacement placement_;
  haptics::Passivity passivity_;
  haptics::ForceWatch watch_;
  haptics::ForceLimiter limiter_;

  // Of the tick in progress.
  haptics::GuardedInput input_;
  Twistd tool_step_velocity_;       // device frame: backward difference over the tick, for the energy account
  double force_scale_{1};           // of the fades
  std::uint32_t device_missed_{0};  // commands missed, as reported by the device in this tick

  physics::StepReport report_;  // of the last tick; no tick depends on it, so it is not saved

  State state_;
};

}  // namespace tactus::loop
