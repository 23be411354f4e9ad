// Everything that a run consists of, built from a scene and the options: the haptic loop with its device, governor and
// recorder on one side, the global world on the other, the exchange between them. Real time and virtual time run the
// same parts; only who calls them, and when, differs.
// Thread: built on a normal thread ([setup]); then the driver belongs to the haptic thread, the global world to its
// own.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "hal/any_device.h"
#include "hal/gpio/gpio_lines.h"
#include "hal/simulated_device.h"
#include "rt/loop/haptic_driver.h"
#include "rt/loop/run_stats.h"
#include "rt/tape/tape_drain.h"
#include "sim/snapshot_server.h"
#include "tools/session/inject_script.h"
#include "tools/session/open_device.h"
#include "tools/session/run_options.h"
#include "tools/session/summary.h"

namespace tactus::session {

using Driver = loop::HapticDriver<hal::AnyDevice>;

// Ticks per global step: 1 with the direct coupling, else the option's, or the scene's.
unsigned ratio_of(const sim::Scene& scene, const RunOptions& options);

// What the haptic thread of this scene is made of. Also what a replay builds its loop from.
loop::LoopConfig loop_config(const sim::Scene& scene, const RunOptions& options,
                             const haptics::DeviceProperties& device);
// A loop with its fixed bodies, and with all members where no exchange brings them.
std::unique_ptr<loop::HapticLoop> make_loop(const sim::Scene& scene, const RunOptions& options,
                                            const haptics::DeviceProperties& device);

// What the global world of this scene is told; its hand, for a simulated device.
sim::GlobalOptions global_options(const sim::Scene& scene, const RunOptions& options,
                                  const haptics::DeviceProperties& device);
hal::HandModel make_hand(const sim::Scene& scene);

class Session {
 public:
  // One line on everything that does not go together: gains the device cannot hold, too many bodies, a bad script.
  // `hardware`: opened before, see open_device.h; without a device in it, the simulated one is made.
  static Result<std::unique_ptr<Session>> create(sim::Scene scene, RunOptions options, Hardware hardware = {});

  // Whether to keep records, and to write a tape. Before the first tick.
  Status record(const std::string& tape_path);  // empty: history only
  // After the last tick: ends the tape, and says in the summary what is on it. A tape that could not be written is its
  // own fault, and not the run's.
  void close_tape(RunSummary& summary);

  sim::Scene scene;
  RunOptions options;
  unsigned ratio, members;
  std::unique_ptr<loop::HapticLoop> loop;
  std::unique_ptr<hal::AnyDevice> device;
  std::string device_identity;           // of a real one, for people
  std::function<Status()> same_device;   // see Hardware
  std::unique_ptr<hal::GpioLines> gpio;  // null without --gpio
  std::unique_ptr<loop::Governor> governor;
  std::unique_ptr<haptics::Exchange> exchange;  // null for the direct coupling, as the next
  std::unique_ptr<sim::WorkerPool> workers;     // that share the global world's steps
  std::unique_ptr<sim::GlobalWorld> global;
  std::unique_ptr<loop::FlightRecorder> recorder;  // null when nothing is recorded
  std::unique_ptr<loop::TapeDrain> drain;
  std::unique_ptr<Driver> driver;
  std::vector<WorldStall> stalls;
  std::vector<std::uint64_t> resets;  // ticks in which the operator's script has the scene begin anew
  loop::RunStats stats;

  // One tick of the driver, its figures into `stats`. Real time measures around the three stages itself.
  void count_tick() noexcept;
  // What the operator asks in the coming tick: `asked`, and to arm at the start, to take a fault back (--rearm), to
  // begin anew by the script. A simulated device's hand begins anew with the scene, so that trials are equal.
  std::uint32_t operator_bits(std::uint32_t asked = 0) noexcept;

  // The truth behind the simulated device's frames; null on a real device.
  const hal::SimulatedDevice* simulated() const noexcept { return device->as<hal::SimulatedDevice>(); }

  // The figures that both kinds of run have.
  RunSummary summary() const;

 private:
  Session() = default;
  std::uint32_t hold_for_hand(std::uint32_t bits) noexcept;
  void start_hand(const loop::TickOutput& out) noexcept;

  hal::SimulatedDevice* hand_{nullptr};  // the device whose hand begins anew; null on a real one
  bool hand_returns_{false};
  std::uint64_t arm_tick_{0};                   // of a run that is armed at its start
  std::optional<std::uint64_t> first_engaged_;  // tick, of a run that is armed at its start
  std::size_t next_reset_{0};
  std::uint32_t latched_ticks_{0};
  std::uint32_t cycle_ticks_{0};
};

}  // namespace tactus::session
