// Builds all parts of a run from a scene and the options: the haptic loop with its device, governor and recorder, the
// global world, and the exchange between them. Real time and virtual time use the same parts; they differ only in which
// thread calls them, and when. A session is of one hand. With several there is one for each, on one global world:
// hands.h.
// Thread: built on a normal thread [setup]; afterwards the haptic thread uses the driver, and the global world's thread
// uses the global world.
#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <string>

#include "hal/any_device.h"
#include "hal/gpio/hand_lines.h"
#include "hal/simulated_device.h"
#include "rt/loop/haptic_driver.h"
#include "rt/loop/run_stats.h"
#include "rt/tape/tape_drain.h"
#include "sim/snapshot_server.h"
#include "tools/session/hand_input.h"
#include "tools/session/inject_script.h"
#include "tools/session/open_device.h"
#include "tools/session/run_options.h"
#include "tools/session/summary.h"

namespace tactus::session {

using Driver = loop::HapticDriver<hal::AnyDevice>;

// Ticks per global step: 1 with the direct coupling, otherwise the option's or, if that is 0, the scene's.
unsigned ratio_of(const sim::Scene& scene, const RunOptions& options);

// Configuration of the haptic loop for this scene; a replay uses it too.
loop::LoopConfig loop_config(const sim::Scene& scene, const RunOptions& options,
                             const haptics::DeviceProperties& device);
// Makes a loop with its fixed bodies; with all members too, if there is no exchange to supply them.
std::unique_ptr<loop::HapticLoop> make_loop(const sim::Scene& scene, const RunOptions& options,
                                            const haptics::DeviceProperties& device);

// Options of the global world of this scene.
sim::GlobalOptions global_options(const sim::Scene& scene, const RunOptions& options,
                                  const haptics::DeviceProperties& device);
hal::HandModel make_hand(const sim::Scene& scene);
// For RunSummary::overlapped.
std::string overlapped_of(const sim::Scene& scene, const physics::Overlap& overlap);

// Receiver of a run's records, besides the tape.
struct Shown {
  loop::RecordTap tap{};
  const std::atomic<std::uint32_t>* watchers{nullptr};  // 0: no body states are recorded
  std::shared_ptr<const void> owner{};                  // of both, kept until the drain has ended
};

class Session {
 public:
  // Error, one line: settings that do not fit together, such as gains beyond the device's limit, too many bodies, a bad
  // script; or a scene with several hands. `hardware`: already opened, see open_device.h; if it has no device, the
  // simulated one is made.
  static Result<std::unique_ptr<Session>> create(sim::Scene scene, RunOptions options, Hardware hardware = {});
  // The session of hand `options.hand`, whose scene `scene` is (sim::scene_of_hand), without a global world: for
  // share_world, or for a replay.
  static Result<std::unique_ptr<Session>> create_hand(sim::Scene scene, RunOptions options, Hardware hardware = {});
  // Makes the global world of these sessions, one for each hand of the scene in their order. The scene of the first is
  // the world's, so the first must outlive it. Error: options that the world cannot have.
  static Status share_world(std::span<Session* const> hands);

  // Enables recording, and writing a tape. Call before the first tick.
  Status record(const std::string& tape_path);  // empty: history only
  // After the last tick: closes the tape and enters its size and losses in the summary. A failure to write the tape is
  // recorded there and does not fail the run.
  void close_tape(RunSummary& summary);

  sim::Scene scene;
  RunOptions options;
  unsigned ratio, members;
  std::unique_ptr<loop::HapticLoop> loop;
  std::unique_ptr<hal::AnyDevice> device;
  std::string device_identity;           // of a real device, as text
  std::function<Status()> same_device;   // see Hardware
  std::unique_ptr<hal::HandLines> gpio;  // null without --gpio
  std::unique_ptr<loop::Governor> governor;
  std::unique_ptr<haptics::Exchange> exchange;     // null for the direct coupling, as are `workers` and `global`
  std::shared_ptr<sim::WorkerPool> workers;        // threads that share the global world's steps
  std::shared_ptr<sim::GlobalWorld> global;        // shared with the other hands
  HandInput hand_input;                            // a person's wishes of the simulated hand
  Shown shown;                                     // set before record()
  std::unique_ptr<loop::FlightRecorder> recorder;  // null when nothing is recorded
  std::unique_ptr<loop::TapeDrain> drain;
  std::unique_ptr<Driver> driver;
  std::vector<WorldStall> stalls;
  std::vector<std::uint64_t> resets;  // ticks in which the script resets the scene
  // Resets requested of any of several hands: the others then reset too. Null with one hand.
  std::shared_ptr<std::atomic<std::uint32_t>> resets_of_all;
  loop::RunStats stats;

  // Adds the figures of the driver's last tick to `stats`. The real-time run measures the three stages itself.
  void count_tick() noexcept;
  // OperatorBits for the coming tick: `asked`, arming at the start, clearing a fault (--rearm), and resets by the
  // script. The hand of a simulated device restarts with the scene, so that all trials are equal.
  std::uint32_t operator_bits(std::uint32_t asked = 0) noexcept;

  // The simulated device, with its exact state; null on a real device.
  const hal::SimulatedDevice* simulated() const noexcept { return device->as<hal::SimulatedDevice>(); }

  // The scene's [hand] holds the tool: then it is judged with the scene.
  bool hand_is_scripted() const;

  // [setup] The simulated hand rests where its path begins, until a person takes it. False: the device is a real one.
  bool rest_hand() noexcept;

  // The header of this run's tape: options, device, scene.
  std::string tape_text() const;
  // The figures common to real-time and virtual runs.
  RunSummary summary() const;

  // Progress of the run in its script and in its cycle.
  struct Progress {
    bool hand_returns{false};
    std::optional<std::uint64_t> first_engaged;  // tick, of a run that is armed at its start
    std::size_t next_reset{0};
    std::uint32_t latched_ticks{0};
    std::uint32_t cycle_ticks{0};
    std::uint32_t resets_seen{0};  // of resets_of_all
  };
  const Progress& progress() const noexcept { return progress_; }
  void set_progress(const Progress& progress) noexcept { progress_ = progress; }

 private:
  Session() = default;
  void make_driver();
  std::uint32_t hold_for_hand(std::uint32_t bits) noexcept;
  std::uint32_t share_reset(std::uint32_t bits) noexcept;
  void start_hand(const loop::TickOutput& out) noexcept;

  hal::SimulatedDevice* hand_{nullptr};  // the simulated device, whose hand restarts at a reset; null on a real device
  std::uint64_t arm_tick_{0};            // of a run that is armed at its start
  Progress progress_;
};

}  // namespace tactus::session
