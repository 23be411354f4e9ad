// One tick of the haptic loop: from what the device said to what it is told. Pure: no clock, no I/O, no thread.
//
//   guard -> adopt snapshot -> arm -> couple -> step sub-world -> wrench -> passivity -> limit -> command
//
// Everything that a tick depends on is in its input and in the state, and the state can be saved: the tape replays it
// bit by bit. Thread: construction [setup]; tick() [rt]. Frame: device frame at both ends, world inside. Units: SI.
// Faults it can raise: all of status.h; a fault latches, takes the force to zero and waits for a re-arm.
#pragma once

#include "rt/base/nonblocking.h"
#include "rt/base/status.h"
#include "rt/haptics/device_placement.h"
#include "rt/haptics/force_limiter.h"
#include "rt/haptics/force_watch.h"
#include "rt/haptics/input_guard.h"
#include "rt/haptics/passivity.h"
#include "rt/haptics/coupling/sub_world.h"
#include "rt/haptics/velocity_estimator.h"
#include "rt/loop/governor.h"
#include "rt/loop/tick_stages.h"

namespace tactus::loop {

struct LoopConfig {
  double period_s{1e-3};
  haptics::SubWorldConfig sub_world;
  haptics::DeviceProperties device;
  haptics::DevicePlacement::Config placement;
  double thinnest_m{0};                   // of all bodies: what overlaps by a part of it is looked at; 0: nothing is
  std::uint32_t emergency_stop_fault{0};  // the number by which the firmware reports its e-stop
};

// What a person asks for, as bits; each counts for the tick that it is given to.
enum OperatorBit : std::uint32_t {
  kArm = 1u << 0,     // engage: couple the device where it is, force on
  kRearm = 1u << 1,   // clear a latched fault, tell the device to leave BRAKE, engage; without either nothing
  kDisarm = 1u << 2,  // force off
  // The e-stop's status line beside the link is active: Fault kEmergencyStop, and no force from this tick on. The cut
  // itself is in the firmware or the hardware; nothing is left to fade.
  kStopLine = 1u << 3,
  // The scene begins anew: the force fades, the global world starts again with the proxy where the device is (clutched
  // to nothing), and when it has come to rest there the force comes back. Not with the direct coupling.
  kReset = 1u << 4,
  // While it is given, a reset that is under way waits with the force off before it lets the scene begin anew: the hand
  // is not back yet.
  kHoldReset = 1u << 5,
  // The run ends: the force fades within kEndFade_s, then the device is told to go to IDLE and nothing arms any more. A
  // latched fault stays latched. In each tick until the end.
  kEnd = 1u << 6,
};
inline constexpr double kEndFade_s = 0.05;

// Tells the other side that H(n) is written. Called between adoption and the rest of the tick.
struct ReportSink {
  haptics::SubWorldReport* report{nullptr};
  void (*publish)(void* context, std::uint64_t cycle) noexcept {nullptr};
  void* context{nullptr};
};

struct TickInput {
  haptics::DeviceInput device;
  std::uint32_t operator_bits{0};
  std::uint32_t sub_steps{4};
  const haptics::WorldSnapshot* snapshot{nullptr};  // null: none adopted in this tick
  ReportSink sink;                                  // needed where snapshot is given
  physics::CutPredicate cut;
  StageObserver stages;
};

// What a tick says. No padding: tapes compare it byte by byte.
struct TickOutput {
  std::uint64_t tick{0};
  haptics::DeviceCommand command;
  Fault fault{Fault::kNone};  // latched
  std::uint32_t status{0};    // StatusBit, of this tick
  std::uint32_t members{0}, border{0}, pairs{0}, contacts{0}, points{0}, capacity_bits{0}, dropped{0};
  std::uint32_t cut_sweep{physics::kNeverCut};
  double deepest_m{0};
  double deepest_share{0};  // of the thinner body's thickness; 0: less than a twentieth of the thinnest of all
  Posed target;             // world: where the device wants the proxy
  physics::BodyMotion proxy;
  Wrenchd wanted;             // N, N m, device frame, before the output path
  double device_energy_J{0};  // into the virtual side at the device port, so far: what the device felt, when it did
  double damped_energy_J{0};  // taken by the passivity controller, so far
  double border_work_J{0};    // done on members by the border, so far, with sign
  double buffer_gain_J{0};    // kinetic: gained by buffer bodies where they took the global world's state, with sign
  double border_tank_J{0};    // what ghosts may still give
};
static_assert(std::is_trivially_copyable_v<TickOutput>);
static_assert(sizeof(TickOutput) == 8 + sizeof(haptics::DeviceCommand) + 10 * 4 + 2 * 8 + sizeof(Posed) +
                                        sizeof(physics::BodyMotion) + sizeof(Wrenchd) + 5 * 8);

class HapticLoop {
 public:
  HapticLoop(const LoopConfig& config, std::span<const physics::Body> fixed_bodies);

  // [setup] Members before the first tick, for the direct coupling.
  void set_members(std::span<const physics::Body> bodies) noexcept { sub_world_.set_members(bodies); }

  // `out` is written whole. The caller keeps input and output for the tape.
  void tick(const TickInput& in, TickOutput& out) noexcept TACTUS_NONBLOCKING;

  // Does the next tick want a snapshot, and which?
  bool wants_snapshot() const noexcept;
  std::uint64_t next_cycle() const noexcept { return state_.next_cycle; }
  // Counts for the governor, of the last tick.
  WorkCounts counts() const noexcept;

  const haptics::SubWorld& sub_world() const noexcept { return sub_world_; }
  const LoopConfig& config() const noexcept { return config_; }
  std::uint64_t state_hash() const noexcept;

  // Everything that the next tick depends on.
  void save(ByteWriter& out) const noexcept;
  [[nodiscard]] bool restore(ByteReader& in) noexcept;
  std::size_t save_size_bound() const noexcept;

 private:
  enum class Reset : std::uint32_t { kNone, kFading, kAsked, kResting };
  struct State {
    std::uint64_t tick{0};
    std::uint64_t next_cycle{0};
    Fault fault{Fault::kNone};
    std::uint32_t armed{0};    // an operator wants force
    std::uint32_t engaged{0};  // the proxy is coupled to the device
    std::uint32_t rearm{0};    // tell the device to leave BRAKE, until it has
    double recovered{1};       // share of the force, by the ramp after engaging, a fade or a lost world
    double ramp_s{0.2};        // that the ramp takes from nothing to all
    Reset reset{Reset::kNone};
    std::uint32_t ending{0};  // 1: kEnd was asked for
    double reset_left_s{0};   // of the fade or the rest
    double ending_left_s{0};  // of the fade
    double missed_share{1};   // of the force, in the last tick: what missed frames and commands left of it
    Posed last_tool;          // device frame, of the tick before
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

  // Of the tick under way.
  haptics::GuardedInput input_;
  Twistd tool_step_velocity_;       // device frame: backward difference over the tick, what the energy book wants
  double force_scale_{1};           // of the fades
  std::uint32_t device_missed_{0};  // commands, as the device says in this tick

  physics::StepReport report_;  // of the last tick; no tick depends on it

  State state_;
};

}  // namespace tactus::loop
