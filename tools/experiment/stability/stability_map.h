// Which gains of the device-proxy coupling are stable: `tactus experiment stability-map`.
//
// For each loop (rate, delay, jitter, encoder, one factor at a time) and each damping, the stiffness at which a tap no
// longer rings out (pressed_device.h), beside the limit by which `tactus run` refuses (rt/haptics/coupling_limits.h).
// Thread: one. Virtual time: the same request, the same figures; only how late this PC wakes a thread is measured.
#pragma once

#include <string>
#include <vector>

#include "rt/haptics/coupling_limits.h"
#include "tools/experiment/progress.h"
#include "tools/experiment/stability/pressed_device.h"

namespace tactus::experiment {

// How late a thread of this PC wakes.
struct WakeLateness {
  double typical_s{0};  // half of the wake-ups are later
  double late_s{0};     // one in a thousand is later: what gains are suggested for
  double latest_s{0};
  std::string source;    // for people
  bool degraded{false};  // measured without a real-time privilege
};

// Sleeps to `seconds` of deadlines on a real-time thread, as the loop does. `cpu` -1: any.
WakeLateness measure_wake(double rate_Hz, double seconds, int cpu);

struct MapRequest {
  hal::DeviceDescription description;
  double rate_Hz{1000};  // of the loop from which each factor is changed
  WakeLateness wake;
  bool quick{false};
};

struct MapRow {
  std::string factor;  // what is changed in this loop: rate, delay, jitter, quantum
  LoopTiming timing;
  double delay_s{0};           // transport
  double damping_Ns_per_m{0};  // the coupling's
  double measured_N_per_m{
      0};  // where it begins to ring on; 0: it does with a tenth of the line's and a quarter of the formula's
  double formula_N_per_m{0};  // the limit by which `tactus run` goes
  double line_N_per_m{0};     // (b + B) / (T/2 + t_d), the same
  double allowed_N_per_m{0};  // what `tactus run` accepts
};

struct MapReport {
  std::string device;
  double rate_Hz{0};
  std::vector<MapRow> rows;
  WakeLateness wake;
  haptics::CouplingGains suggested;  // at rate_Hz, on this PC
  double least_of_formula{0};        // the smallest measured / formula: 0.56 is allowed
  unsigned unsafe{0};                // rows whose boundary is below what is allowed
};

std::vector<LoopTiming> loops_of(const std::string& factor, const LoopTiming& base, double quantum_m, bool quick);

MapReport run_stability_map(const MapRequest& request, const Progress& progress);

std::string map_table(const MapReport& report);
std::string map_json(const MapReport& report);
std::string map_csv(const MapReport& report);  // units in the header

}  // namespace tactus::experiment
