// The haptic sub-world and the global world of a run, on a virtual clock and in one thread, without device and output
// path, to measure the effect of the coupling alone on the force.
//
// The worlds exchange as in a run (rt/haptics/coupling/exchange.h, sim/snapshot_server.h). A tick that begins a cycle
// synchronises, and the global world answers at once, so it is never late. The worlds start at rest, or from the state
// of a run with direct coupling, contact impulses included. Thread: one. Frame: world. Units: SI. Bound: from another
// run's state at most haptics::kMaxMembers moving bodies.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "rt/haptics/coupling/exchange.h"
#include "rt/haptics/coupling/sub_world.h"
#include "sim/global_world.h"
#include "sim/snapshot_server.h"
#include "tools/experiment/timing.h"
#include "tools/session/run_options.h"

namespace tactus::experiment {

// Complete state of a world at the beginning of a tick.
struct WorldKeyframe {
  std::uint64_t tick{0};
  std::vector<physics::Body> bodies;         // that move, by id
  std::vector<physics::WarmStart> contacts;  // what they hold
  std::vector<std::byte> state;              // of the haptic side, every bit
};

// Energy of all moving bodies at one instant.
struct EnergySample {
  double kinetic_J{0};
  double speed_squared{0};  // m^2/s^2: sum of |v|^2, every body counted with unit mass
};

class CoupledWorlds {
 public:
  // The options must fit the scene (sim::check_global_options).
  CoupledWorlds(const sim::Scene& scene, const session::RunOptions& options, const haptics::DeviceProperties& device);
  CoupledWorlds(const CoupledWorlds&) = delete;  // server_ refers to exchange_
  CoupledWorlds& operator=(const CoupledWorlds&) = delete;

  void start_at_rest();
  // `before` is one cycle earlier than `now`: the global world steps from `before`, so that its contacts are as in a
  // continuing run. `on_proxy`: mean wrench of the coupling over that cycle [N, N m]. For the direct coupling `before`
  // is not used, and `shift` displaces the proxy.
  void start_from(const WorldKeyframe& before, const WorldKeyframe& now, const Wrenchd& on_proxy,
                  const Vec3d& shift = {});

  const haptics::SubWorldStep& tick(const haptics::DeviceTarget& target);

  // The three parts of a tick: synchronisation on the haptic side at the beginning of a cycle; then the global step;
  // then the haptic tick.
  bool synchronise();  // false: no cycle begins
  void serve();
  const haptics::SubWorldStep& step(const haptics::DeviceTarget& target);

  // True if the next tick begins with a synchronisation; then all bodies are at the same time.
  bool at_synchronisation() const noexcept;
  EnergySample motion() const noexcept;                // at a synchronisation
  void bodies(std::vector<physics::Body>& all) const;  // that move, by id; at a synchronisation
  // Energy of the springs of contacts and joints at a synchronisation [J] (sim/energy_balance.h).
  double springs_J() const noexcept;
  // Energy that the border has taken from bodies and not yet returned, at a synchronisation [J]; 0 if it returned more,
  // and for borders without a tank.
  double held_by_border_J() const noexcept;
  WorldKeyframe keyframe(std::uint64_t tick,
                         bool every_bit) const;  // of the direct coupling; without every bit: no `state`

  const haptics::SubWorld& sub_world() const noexcept { return *sub_world_; }
  const sim::GlobalWorld* global() const noexcept { return global_.get(); }
  std::uint32_t component() const noexcept { return component_; }  // of the last snapshot
  const haptics::SubWorldStep& last() const noexcept { return step_; }

 private:
  bool exchanges() const noexcept { return global_ != nullptr; }
  void shift_proxy(const WorldKeyframe& now, const Vec3d& shift);
  haptics::DeviceTarget device_that_holds(const WorldKeyframe& at, const Wrenchd& on_proxy) const;

  bool haptic_side_moves(BodyId member) const noexcept;

  haptics::SubWorldConfig config_;
  haptics::CouplingTraits coupling_;
  std::unique_ptr<haptics::SubWorld> sub_world_;
  std::unique_ptr<sim::GlobalWorld> global_;  // null with the direct coupling
  std::vector<physics::Body> at_rest_;
  haptics::Exchange exchange_;
  std::optional<sim::SnapshotServer> server_;  // none with the direct coupling
  std::uint64_t next_cycle_{0};
  Wrenchd on_proxy_before_;              // mean of the cycle before the start
  haptics::DeviceTarget device_before_;  // target that causes this wrench at the start
  std::uint32_t component_{0};
  haptics::SubWorldStep step_;
};

// CPU time of the haptic side in a tick [us]. `serve` has the global world computed; called after a synchronisation,
// its time does not count.
double timed_tick_us(CoupledWorlds& worlds, const haptics::DeviceTarget& target, const std::function<void()>& serve);

}  // namespace tactus::experiment
