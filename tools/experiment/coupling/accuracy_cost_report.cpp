#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "sim/model/choice_names.h"
#include "tools/experiment/coupling/accuracy_cost.h"
#include "tools/experiment/csv.h"
#include "tools/json_report.h"

namespace tactus::experiment {
namespace {

using nlohmann::ordered_json;

// One line for a step of one factor: change of the force error, of the tick's time, of the global world's time.
std::string sentence_of(const ChangeCost& change) {
  const auto word = [](double more_by, const char* more) { return more_by <= 0 ? "saves" : more; };
  const double error = 100 * (change.error_after - change.error_before);
  const double time_us = change.tick_us_after - change.tick_us_before;
  const double global_us = change.global_us_after - change.global_us_before;
  return fmt::format(
      "{} {} -> {}: {} {:.2f} % of error, {} {:.0f} us a tick and {} {:.0f} us of the global world's time",
      change.factor, change.from, change.to, word(error, "adds"), std::abs(error), word(time_us, "costs"),
      std::abs(time_us), word(global_us, "costs"), std::abs(global_us));
}

ordered_json json_of(const std::vector<CostPoint>& points) {
  ordered_json list = ordered_json::array();
  for (const CostPoint& p : points)
    list.push_back({{"scene", p.scene},
                    {"sub_steps", p.setting.sub_steps},
                    {"relax_sweeps", p.setting.relax_sweeps},
                    {"friction_sweeps", sim::name_of(p.setting.friction)},
                    {"contact_Hz", p.setting.contact_Hz},
                    {"members", p.setting.members},
                    {"ratio", p.setting.scheme.ratio},
                    {"border", name_of_border(p.setting.scheme)},
                    {"extraction", sim::name_of(p.setting.order)},
                    {"world_precision", sim::name_of(p.setting.precision)},
                    {"force_error_rms", p.force_error},
                    {"force_error_by_seed", p.force_error_by_seed},
                    {"tick_us_p50_by_seed", p.tick_us_by_seed},
                    {"hold_vibration_N", p.hold_vibration_N},
                    {"sync_step_N", p.sync_step_N},
                    {"loss", p.loss},
                    {"gain", p.gain},
                    {"tick_us_p50", p.tick_us_p50},
                    {"tick_us_p99", p.tick_us_p99},
                    {"tick_us_max", p.tick_us_max},
                    {"global_us_per_tick", p.global_us_per_tick},
                    {"instructions", p.instructions > 0 ? ordered_json(p.instructions) : ordered_json(nullptr)},
                    {"on_front", p.on_front},
                    {"is_default", p.is_default}});
  return list;
}

constexpr CsvColumn kCostColumns[] = {
    {"scene", "scene"},
    {"sub_steps [1]", "sub_steps"},
    {"relax_sweeps [1]", "relax_sweeps"},
    {"friction_sweeps", "friction_sweeps"},
    {"contact_frequency [Hz]", "contact_Hz"},
    {"members [1]", "members"},
    {"ratio [1]", "ratio"},
    {"border", "border"},
    {"extraction", "extraction"},
    {"world_precision", "world_precision"},
    {"force_error_rms [1]", "force_error_rms"},
    {"hold_vibration [N]", "hold_vibration_N"},
    {"sync_step [N]", "sync_step_N"},
    {"loss [1]", "loss"},
    {"gain [1]", "gain"},
    {"tick_p50 [us]", "tick_us_p50"},
    {"tick_p99 [us]", "tick_us_p99"},
    {"tick_max [us]", "tick_us_max"},
    {"global_per_tick [us]", "global_us_per_tick"},
    {"instructions [1]", "instructions", CsvColumn::Cell::kWhole},
    {"on_front", "on_front"},
    {"is_default", "is_default"},
};

}  // namespace

std::string cost_table(const CostReport& report) {
  std::string text;
  std::string scene;
  for (const CostPoint& p : report.points) {
    if (p.scene != scene) {
      scene = p.scene;
      text += fmt::format(
          "{}{}\n  {:>9} {:>5} {:<8} {:>8} {:>7} {:>5} {:<7} {:<13} {:<9} {:>10} {:>10} {:>9} {:>9} {:>8}\n",
          text.empty() ? "" : "\n", scene, "sub-steps", "relax", "friction", "contact", "members", "ratio", "border",
          "extraction", "precision", "error %", "vibr. N", "p50 us", "p99 us", "");
    }
    // Only the front and the default; --csv and --json contain all points.
    if (!p.on_front && !p.is_default) continue;
    const CostSetting& s = p.setting;
    text += fmt::format(
        "  {:>9} {:>5} {:<8} {:>5g} Hz {:>7} {:>5} {:<7} {:<13} {:<9} {:>10.3f} {:>10.5f} {:>9.1f} {:>9.1f} {:>8}\n",
        s.sub_steps, s.relax_sweeps, sim::name_of(s.friction), s.contact_Hz, s.members, s.scheme.ratio,
        name_of_border(s.scheme), sim::name_of(s.order), sim::name_of(s.precision), 100 * p.force_error,
        p.hold_vibration_N, p.tick_us_p50, p.tick_us_p99, p.is_default ? "default" : "");
  }
  text += "\nFrom the default, one change at a time:\n";
  for (const ChangeCost& change : report.changes)
    text += fmt::format("  {:<11} {}\n", change.scene, sentence_of(change));
  return text + fmt::format(
                    "\n{} seeds. error: RMS(F - F_ref) / RMS(F_ref), the reference being all bodies at 1 kHz with 16 "
                    "sub-steps and two\nrelax sweeps. us: CPU time of a tick on the haptic side, of {} of them on this "
                    "machine. Shown: the front of error and\nmedian tick, and the default.\n",
                    report.seeds, report.timed_seeds);
}

std::string cost_json(const CostReport& report) {
  ordered_json changes = ordered_json::array();
  for (const ChangeCost& n : report.changes)
    changes.push_back({{"scene", n.scene},
                       {"factor", n.factor},
                       {"from", n.from},
                       {"to", n.to},
                       {"error_before", n.error_before},
                       {"error_after", n.error_after},
                       {"tick_us_before", n.tick_us_before},
                       {"tick_us_after", n.tick_us_after},
                       {"global_us_before", n.global_us_before},
                       {"global_us_after", n.global_us_after},
                       {"sentence", sentence_of(n)}});
  return report_text(ordered_json{{"points", json_of(report.points)},
                                  {"notches", changes},
                                  {"seeds", report.seeds},
                                  {"timed_seeds", report.timed_seeds},
                                  {"period_us", report.period_us},
                                  {"budget_us", report.budget_us}},
                     2);
}

std::string cost_csv(const CostReport& report) { return csv_of(kCostColumns, json_of(report.points)); }

}  // namespace tactus::experiment
