// Summary of a run: one struct of figures, printed as text and as JSON with units in the keys.
// Thread: normal, after the run.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "hal/device_on_link.h"
#include "rt/calibration/calibration.h"
#include "rt/loop/run_stats.h"
#include "rt/thread/realtime_setup.h"
#include "rt/thread/timing.h"
#include "sim/global_world.h"
#include "tools/session/run_options.h"
#include "tools/session/scheme_gains.h"
#include "tools/session/verdict.h"

namespace tactus::session {

struct RunSummary {
  RunOptions options;
  std::string scene_name, scene_title;
  std::string scene_hash;                   // of its text and of the content of its files
  std::vector<std::string> scene_problems;  // of `tactus scene check`, for this device and rate
  unsigned ratio{0}, members_cap{0}, sub_steps{0};
  SchemeGains gains;
  std::uint32_t bodies{0};
  double wall_s{0};  // of the loop; 0 in virtual time
  loop::RunStats stats;

  // Real time only.
  bool real_time{false};
  loop::SetupReport setup;
  loop::TimingHealth timing;
  Histogram compute, device;  // of the tick without the device; of reading and writing the device alone
  std::uint64_t overruns_late_wake{0}, overruns_own_work{0}, overruns_interrupted{0};
  std::optional<double> stolen_share;  // of the haptic core, by the host; empty if not reported
  int haptic_cpu{-1};                  // -1: not pinned
  loop::Calibration calibration;
  loop::CostPredictionStats cost_prediction;

  // With a global world.
  bool has_global{false};
  sim::GlobalStatistics global;
  Histogram global_step;   // wall clock; empty in virtual time
  std::string overlapped;  // names of the two bodies of global.overlap; empty: no overlap

  std::string device_identity;            // of a real device
  std::vector<std::string> arm_refusals;  // why arming was refused; the first few, each once
  std::optional<hal::LinkReport> link;    // of a device on a link

  // Energy, J: work of the simulated hand and of the simulated motors; 0 on a real device.
  double hand_work_J{0}, motor_work_J{0};
  std::uint64_t state_hash{0};
  std::string tape;  // path, empty if none
  std::uint64_t tape_bytes{0}, tape_dropped{0};
  std::string tape_fault;            // why it is incomplete; empty: complete
  std::uint64_t tape_lost_ticks{0};  // ticks missing from the tape for that reason
  std::string fault_tape;            // flight recorder dump, empty if none
  std::string fault_tape_error;      // why there is no dump

  // verdict.h: 0 good or degraded, 1 bad.
  int exit_code() const { return judge(*this).exit_code(); }
  bool fault_latched() const noexcept;  // at the end
  // True: a line of the real-time set-up reports FAIL.
  bool degraded() const noexcept { return real_time && setup.failed(); }
  double dilation_ms() const noexcept;  // lag of the global clock behind the haptic clock
  bool simulated() const noexcept { return options.device == "sim"; }
};

std::string to_text(const RunSummary& summary);
nlohmann::json to_json(const RunSummary& summary);

}  // namespace tactus::session
