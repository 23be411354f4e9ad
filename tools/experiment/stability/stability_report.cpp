#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "tools/experiment/csv.h"
#include "tools/experiment/stability/stability_map.h"
#include "tools/json_report.h"

namespace tactus::experiment {
namespace {

using nlohmann::ordered_json;

std::string gains_text(const haptics::CouplingGains& gains) {
  return fmt::format(
      "[coupling]\nstiffness_N_per_m = {:.4g}\ndamping_Ns_per_m = {:.3g}\nstiffness_Nm_per_rad = {:.3g}\n"
      "damping_Nms_per_rad = {:.3g}\n",
      gains.stiffness_N_per_m, gains.damping_Ns_per_m, gains.stiffness_Nm_per_rad, gains.damping_Nms_per_rad);
}

ordered_json json_of(const std::vector<MapRow>& rows) {
  ordered_json list = ordered_json::array();
  for (const MapRow& r : rows)
    list.push_back({{"factor", r.factor},
                    {"rate_Hz", r.timing.rate_Hz},
                    {"delay_ticks", r.timing.delay_ticks},
                    {"delay_s", r.delay_s},
                    {"jitter_ticks", r.timing.jitter_ticks},
                    {"quantum_m", r.timing.quantum_m},
                    {"damping_Ns_per_m", r.damping_Ns_per_m},
                    {"measured_N_per_m", r.measured_N_per_m},
                    {"formula_N_per_m", r.formula_N_per_m},
                    {"line_N_per_m", r.line_N_per_m},
                    {"allowed_N_per_m", r.allowed_N_per_m}});
  return list;
}

constexpr CsvColumn kMapColumns[] = {
    {"factor", "factor"},
    {"rate [Hz]", "rate_Hz"},
    {"delay [ticks]", "delay_ticks"},
    {"delay [s]", "delay_s"},
    {"jitter [ticks]", "jitter_ticks"},
    {"quantum [m]", "quantum_m"},
    {"damping [N s/m]", "damping_Ns_per_m"},
    {"measured [N/m]", "measured_N_per_m"},
    {"formula [N/m]", "formula_N_per_m"},
    {"line [N/m]", "line_N_per_m"},
    {"allowed [N/m]", "allowed_N_per_m"},
};

}  // namespace

std::string map_table(const MapReport& report) {
  std::string text, factor;
  for (const MapRow& r : report.rows) {
    if (r.factor != factor) {
      factor = r.factor;
      text += fmt::format("{}{}\n  {:>7} {:>11} {:>12} {:>10} {:>12} {:>13} {:>13} {:>10} {:>9}\n",
                          text.empty() ? "" : "\n", factor, "rate Hz", "delay ticks", "jitter ticks", "quantum um",
                          "damping Ns/m", "measured N/m", "formula N/m", "m / f", "allowed");
    }
    text += fmt::format("  {:>7g} {:>11g} {:>12g} {:>10g} {:>12.3g} {:>13.0f} {:>13.0f} {:>10} {:>9.0f}{}\n",
                        r.timing.rate_Hz, r.timing.delay_ticks, r.timing.jitter_ticks, 1e6 * r.timing.quantum_m,
                        r.damping_Ns_per_m, r.measured_N_per_m, r.formula_N_per_m,
                        r.formula_N_per_m > 0 ? fmt::format("{:.2f}", r.measured_N_per_m / r.formula_N_per_m) : "-",
                        r.allowed_N_per_m, r.measured_N_per_m < r.allowed_N_per_m ? "  NOT STABLE" : "");
  }
  text += fmt::format(
      "\n{}, pressed against a wall with 5 N and tapped; passivity controller off, no dry friction. measured: where "
      "the "
      "tap\nbegins to ring on. formula: rt/haptics/coupling_limits.h; the coupling's own lead, half a tick and half a "
      "sub-step, is not\nin it. allowed: what `tactus run` accepts, {:g} of it. The least measured / formula is "
      "{:.2f}; {} of {} boundaries are below what "
      "is "
      "allowed.\n",
      report.device, haptics::kAllowedStiffnessShare, report.least_of_formula, report.unsafe, report.rows.size());
  const WakeLateness& w = report.wake;
  text += fmt::format(
      "\n{}{}: half later than {:.0f} us, one in a thousand later than {:.0f} us, latest {:.0f} us.\n"
      "For this device at {:g} Hz, ticks late by up to {:.0f} us:\n\n{}",
      w.source, w.degraded ? " (without real-time privileges)" : "", 1e6 * w.typical_s, 1e6 * w.late_s,
      1e6 * w.latest_s, report.rate_Hz, 1e6 * w.late_s, gains_text(report.suggested));
  return text;
}

std::string map_json(const MapReport& report) {
  const auto& g = report.suggested;
  return report_text(ordered_json{{"device", report.device},
                                  {"rate_Hz", report.rate_Hz},
                                  {"rows", json_of(report.rows)},
                                  {"least_measured_over_formula", report.least_of_formula},
                                  {"allowed_share", haptics::kAllowedStiffnessShare},
                                  {"unsafe", report.unsafe},
                                  {"wake",
                                   {{"source", report.wake.source},
                                    {"degraded", report.wake.degraded},
                                    {"p50_us", 1e6 * report.wake.typical_s},
                                    {"p99_9_us", 1e6 * report.wake.late_s},
                                    {"max_us", 1e6 * report.wake.latest_s}}},
                                  {"suggested",
                                   {{"stiffness_N_per_m", g.stiffness_N_per_m},
                                    {"damping_Ns_per_m", g.damping_Ns_per_m},
                                    {"stiffness_Nm_per_rad", g.stiffness_Nm_per_rad},
                                    {"damping_Nms_per_rad", g.damping_Nms_per_rad}}}},
                     2);
}

std::string map_csv(const MapReport& report) { return csv_of(kMapColumns, json_of(report.rows)); }

}  // namespace tactus::experiment
