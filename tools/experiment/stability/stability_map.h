// Stability limits of the coupling's gains: `tactus experiment stability-map`.
//
// For each loop (rate, delay, jitter, encoder, one factor at a time) and each damping, the stiffness above which the
// oscillation after a tap no longer decays (pressed_device.h), compared with the limit that `tactus run` applies
// (rt/haptics/coupling_limits.h).
// Thread: one. Virtual time: the same request, the same figures; only the wake-up latency of this PC is measured.
#pragma once

#include <string>
#include <vector>

#include "rt/haptics/coupling_limits.h"
#include "tools/experiment/progress.h"
#include "tools/experiment/stability/pressed_device.h"

namespace tactus::experiment {

// Wake-up latency of a thread on this PC.
struct WakeLateness {
  double typical_s{0};  // median
  double late_s{0};     // 99.9 % quantile; used for the suggested gains
  double latest_s{0};
  std::string source;    // for people
  bool degraded{false};  // measured without a real-time privilege
};

// Measures by sleeping to periodic deadlines for `seconds` on a real-time thread, as the loop does. `cpu` -1: any.
WakeLateness measure_wake(double rate_Hz, double seconds, int cpu);

struct MapRequest {
  hal::DeviceDescription description;
  double rate_Hz{1000};  // of the base loop, from which one factor is changed at a time
  WakeLateness wake;
  bool quick{false};
};

struct MapRow {
  std::string factor;  // changed factor: rate, delay, jitter, quantum
  LoopTiming timing;
  double delay_s{0};           // transport
  double damping_Ns_per_m{0};  // the coupling's
  double measured_N_per_m{0};  // stability limit; 0: unstable at the least tried
  double formula_N_per_m{0};   // the limit that `tactus run` uses
  double line_N_per_m{0};      // (b + B) / (T/2 + t_d), for comparison
  double allowed_N_per_m{0};   // what `tactus run` accepts
};

struct MapReport {
  std::string device;
  double rate_Hz{0};
  std::vector<MapRow> rows;
  WakeLateness wake;
  haptics::CouplingGains suggested;  // at rate_Hz, on this PC
  double least_of_formula{0};        // smallest ratio measured / formula; the allowed share is 0.56
  unsigned unsafe{0};                // rows whose measured limit is below the allowed stiffness
};

std::vector<LoopTiming> loops_of(const std::string& factor, const LoopTiming& base, double quantum_m, bool quick);

MapReport run_stability_map(const MapRequest& request, const Progress& progress);

std::string map_table(const MapReport& report);
std::string map_json(const MapReport& report);
std::string map_csv(const MapReport& report);  // units in the header

}  // namespace tactus::experiment
