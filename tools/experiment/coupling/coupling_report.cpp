#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "sim/model/choice_names.h"
#include "tools/experiment/coupling/coupling_study.h"
#include "tools/experiment/coupling/reference_run.h"
#include "tools/experiment/csv.h"
#include "tools/json_report.h"

namespace tactus::experiment {
namespace {

using nlohmann::ordered_json;

ordered_json to_json(const SeedFigures& one) {
  return {{"force_error_rms", one.force_error},
          {"loss", one.loss},
          {"gain", one.gain},
          {"sync_step_N", one.sync_step_N},
          {"hold_vibration_N", one.hold_vibration_N}};
}

ordered_json to_json(const StudyRow& row) {
  ordered_json by_seed = ordered_json::array();
  for (const SeedFigures& one : row.by_seed) by_seed.push_back(to_json(one));
  ordered_json object = run_json(row.scene, row.scheme, row.members, row.gains);
  object.update({{"stiffness_lowered", row.lowered},
                 {"loss", row.energy.loss},
                 {"gain", row.energy.gain},
                 {"force_error_rms", row.force_error},
                 {"sync_step_N", row.sync_step_N},
                 {"hold_vibration_N", row.hold_vibration_N},
                 {"stable", row.stable},
                 {"loss_worst_instant", row.worst_instant.loss},
                 {"gain_worst_instant", row.worst_instant.gain},
                 {"loss_speed_squared", row.speed_squared.loss},
                 {"gain_speed_squared", row.speed_squared.gain},
                 {"force_error_hold", row.force_error_hold},
                 {"force_error_moving", row.force_error_moving},
                 {"force_error_worst_window", row.force_error_worst},
                 {"hold_vibration_worst_N", row.hold_vibration_worst_N},
                 {"hold_vibration_encoder_N", row.hold_vibration_encoder_N},
                 {"energy_basis", row.at_rest ? "kinetic and spring" : "kinetic"},
                 {"loop_peak_N", row.loop.peak_N},
                 {"loop_shake_N", row.loop.shake_N},
                 {"loop_hold_N", row.loop.hold_N},
                 {"loop_fallen", row.loop.fallen},
                 {"loop_energy_gain", row.loop.energy_gain},
                 {"by_seed", by_seed},
                 {"spectrum_N2", row.spectrum}});
  return object;
}

ordered_json to_json(const StudyScene& scene) {
  return {{"scene", scene.name},
          {"bodies", scene.bodies},
          {"members_cap", scene.members},
          {"component", scene.component},
          {"contact_points", scene.contact_points},
          {"contact_share", scene.contact_share},
          {"force_rms_N", scene.force_rms_N},
          {"apart_1um_force_error", scene.apart_force_error},
          {"apart_1um_loss", scene.apart_energy.loss},
          {"apart_1um_gain", scene.apart_energy.gain},
          {"loop_peak_N", scene.loop.peak_N},
          {"loop_shake_N", scene.loop.shake_N},
          {"loop_hold_N", scene.loop.hold_N}};
}

template <class Row>
ordered_json json_of(const std::vector<Row>& rows) {
  ordered_json list = ordered_json::array();
  for (const Row& row : rows) list.push_back(to_json(row));
  return list;
}

constexpr CsvColumn kStudyColumns[] = {
    {"scene", "scene"},
    {"coupling", "coupling"},
    {"border", "border"},
    {"ratio [1]", "ratio"},
    {"stiffness [N/m]", "stiffness_N_per_m"},
    {"loss [1]", "loss"},
    {"gain [1]", "gain"},
    {"loss_worst_instant [1]", "loss_worst_instant"},
    {"gain_worst_instant [1]", "gain_worst_instant"},
    {"loss_speed_squared [1]", "loss_speed_squared"},
    {"gain_speed_squared [1]", "gain_speed_squared"},
    {"force_error_rms [1]", "force_error_rms"},
    {"force_error_hold [1]", "force_error_hold"},
    {"force_error_moving [1]", "force_error_moving"},
    {"force_error_worst_window [1]", "force_error_worst_window"},
    {"sync_step [N]", "sync_step_N"},
    {"hold_vibration [N]", "hold_vibration_N"},
    {"hold_vibration_worst [N]", "hold_vibration_worst_N"},
    {"hold_vibration_encoder [N]", "hold_vibration_encoder_N"},
    {"energy_basis", "energy_basis"},
    {"loop_peak [N]", "loop_peak_N"},
    {"loop_shake [N]", "loop_shake_N"},
    {"loop_hold [N]", "loop_hold_N"},
    {"loop_fallen [1]", "loop_fallen"},
    {"loop_energy_gain [1]", "loop_energy_gain"},
    {"stable", "stable"},
};

std::string windows_table(const StudyReport& report) {
  std::string text = fmt::format("{:<11} {:>6} {:>9} {:>7} {:>7} {:>8} {:>8} {:>14}\n", "scene", "bodies", "component",
                                 "members", "points", "contact", "force N", "1 um apart");
  for (const StudyScene& s : report.scenes)
    text +=
        fmt::format("{:<11} {:>6} {:>9} {:>7} {:>7} {:>6.0f} % {:>8.2f} {:>12.2f} %\n", s.name, s.bodies, s.component,
                    s.members, s.contact_points, 100 * s.contact_share, s.force_rms_N, 100 * s.apart_force_error);
  text += fmt::format("\n{:<11} {:<13} {:<8} {:>5} {:>7} {:>8} {:>8} {:>10} {:>9} {:>10} {:>10} {:>7}\n", "scene",
                      "coupling", "border", "ratio", "K N/m", "loss %", "gain %", "force err%", "sync N", "hold vib N",
                      "encoder N", "stable");
  for (const StudyRow& r : report.rows)
    text += fmt::format(
        "{:<11} {:<13} {:<8} {:>5} {:>6.0f}{} {:>8.2f} {:>7.2f}{} {:>10.2f} {:>9.4f} {:>10.5f} {:>10.5f} "
        "{:>7}\n",
        r.scene, sim::name_of(r.scheme.coupling), name_of_border(r.scheme), r.scheme.ratio, r.gains.stiffness_N_per_m,
        r.lowered ? "!" : " ", 100 * r.energy.loss, 100 * r.energy.gain, r.at_rest ? "*" : " ", 100 * r.force_error,
        r.sync_step_N, r.hold_vibration_N, r.hold_vibration_encoder_N, r.stable ? "yes" : "NO");
  const bool lowered = std::any_of(report.rows.begin(), report.rows.end(), [](const StudyRow& r) { return r.lowered; });
  if (lowered)
    text +=
        "\n!: the most stiffness that this coupling bears at this ratio; its row is against a direct run with the "
        "same.\n";
  return text +
         fmt::format(
             "\n{} seeds, {} windows of {} cycles each, at least {:g} s, all from the state of a run with direct "
             "coupling.\nloss, gain: by window, of the kinetic energy of all bodies; *: these are at rest, it is "
             "of the kinetic energy and what\nthe coupling's spring holds. sync: 95 % of the steps of F - "
             "F_direct. vibration: std of F - F_direct, 20 to 500 Hz, while\nthe hand holds.\n",
             report.seeds, report.windows, kWindowCycles, report.window_s);
}

}  // namespace

std::string study_table(const StudyReport& report) {
  return fmt::format("{}{}{}", report.seeds > 0 ? windows_table(report) : std::string(),
                     report.seeds > 0 && !report.whole.empty() ? "\n" : "",
                     report.whole.empty() ? std::string() : whole_table(report.whole));
}

std::string study_json(const StudyReport& report) {
  return report_text(ordered_json{{"rows", json_of(report.rows)},
                                  {"scenes", json_of(report.scenes)},
                                  {"whole", whole_rows_json(report.whole)},
                                  {"seeds", report.seeds},
                                  {"windows_per_seed", report.windows},
                                  {"window_cycles", kWindowCycles},
                                  {"window_least_s", report.window_s},
                                  {"spectrum_line_Hz", report.line_Hz}},
                     2);
}

std::string study_csv(const StudyReport& report) { return csv_of(kStudyColumns, json_of(report.rows)); }

}  // namespace tactus::experiment
