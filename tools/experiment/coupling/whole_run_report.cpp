#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "sim/model/choice_names.h"
#include "tools/experiment/coupling/whole_run.h"
#include "tools/experiment/csv.h"

namespace tactus::experiment {
namespace {

using nlohmann::ordered_json;

constexpr CsvColumn kWholeColumns[] = {
    {"scene", "scene"},
    {"coupling", "coupling"},
    {"border", "border"},
    {"ratio [1]", "ratio"},
    {"members [1]", "members"},
    {"stiffness [N/m]", "stiffness_N_per_m"},
    {"seconds [s]", "seconds"},
    {"started_apart [m]", "started_apart_m"},
    {"sub_steps_times [1]", "sub_steps_times"},
    {"hand", "hand"},
    {"force_error [1]", "force_error"},
    {"force_error_q1 [1]", "force_error_by_quarter/0"},
    {"force_error_q2 [1]", "force_error_by_quarter/1"},
    {"force_error_q3 [1]", "force_error_by_quarter/2"},
    {"force_error_q4 [1]", "force_error_by_quarter/3"},
    {"force_rms [N]", "force_rms_N"},
    {"pose_off [m]", "pose_off_m"},
    {"pose_off_most [m]", "pose_off_most_m"},
    {"pose_off_share [1]", "pose_off_share_of_size"},
    {"drift [m]", "drift_m"},
    {"deepest [m]", "deepest_m"},
    {"direct_deepest [m]", "direct_deepest_m"},
    {"kinetic [J]", "kinetic_J"},
    {"kinetic_over_work [1]", "kinetic_over_work"},
    {"energy_gain [J]", "energy_gain_J"},
    {"direct_energy_gain [J]", "direct_energy_gain_J"},
    {"energy_rise [J]", "energy_rise_J"},
    {"direct_energy_rise [J]", "direct_energy_rise_J"},
    {"energy_unexplained [J]", "energy_unexplained_J"},
    {"direct_energy_unexplained [J]", "direct_energy_unexplained_J"},
    {"energy_at_play [J]", "energy_at_play_J"},
    {"device_work [J]", "device_work_J"},
    {"border_work [J]", "border_work_J"},
    {"corrected [J]", "corrected_J"},
    {"border_tank [J]", "border_tank_J"},
    {"border_spent_share [1]", "border_spent_share"},
    {"global_border_work [J]", "global_border_work_J"},
    {"imposed [J]", "imposed_J"},
    {"returned [J]", "returned_J"},
    {"fallen [1]", "fallen"},
    {"stands", "stands"},
};

std::string name_of_run(const WholeRunRow& row) {
  if (row.apart_m > 0) return "1 um apart";
  if (row.sub_steps_times > 1) return fmt::format("{}x sub-steps", row.sub_steps_times);
  return std::string(sim::name_of(row.scheme.coupling));
}

}  // namespace

std::string whole_table(std::span<const WholeRunRow> rows) {
  std::string text = fmt::format(
      "{:<16} {:<13} {:<8} {:>5} {:>7} {:>6} {:>6} {:>10} {:>27} {:>9} {:>9} {:>8} {:>9} {:>9} {:>9} {:>9} {:>7} "
      "{:>7}\n",
      "scene", "coupling", "border", "ratio", "members", "K N/m", "hand", "force err%", "by quarter %", "off mm",
      "most mm", "of size%", "drift mm", "deep mm", "Ekin/work", "gain %", "spent %", "stands");
  for (const WholeRunRow& r : rows) {
    std::string quarters;
    for (const double q : r.force_error_quarter) quarters += fmt::format(" {:>6.2f}", 100 * q);
    text += fmt::format(
        "{:<16} {:<13} {:<8} {:>5} {:>7} {:>6.0f} {:>6} {:>10.2f} {:>27} {:>9.3f} {:>9.3f} {:>8.2f} {:>9.4f} {:>9.3f} "
        "{:>9.3f} "
        "{:>9.3f} {:>7.2f} {:>7}\n",
        r.scene, name_of_run(r), name_of_border(r.scheme), r.scheme.ratio, r.members, r.gains.stiffness_N_per_m,
        name_of(r.hand), 100 * r.force_error, quarters, 1e3 * r.pose_off_m, 1e3 * r.pose_off_most_m,
        100 * r.pose_off_share, 1e3 * r.drift_m, 1e3 * r.deepest_m, r.kinetic_over_work,
        r.energy_at_play_J > 0 ? 100 * (r.energy_gain_J - r.direct_energy_gain_J) / r.energy_at_play_J : 0.0,
        100 * r.account.spent_share, r.stands ? "yes" : fmt::format("NO, {}", r.fallen));
  }
  return text;
}

ordered_json run_json(const std::string& scene, const Scheme& scheme, unsigned members,
                      const haptics::CouplingGains& gains) {
  return {{"scene", scene},
          {"coupling", sim::name_of(scheme.coupling)},
          {"border", name_of_border(scheme)},
          {"ratio", scheme.ratio},
          {"members", members},
          {"stiffness_N_per_m", gains.stiffness_N_per_m},
          {"stiffness_Nm_per_rad", gains.stiffness_Nm_per_rad}};
}

ordered_json whole_rows_json(std::span<const WholeRunRow> rows) {
  ordered_json list = ordered_json::array();
  for (const WholeRunRow& row : rows) {
    ordered_json one = run_json(row.scene, row.scheme, row.members, row.gains);
    one["seconds"] = row.seconds;
    one["started_apart_m"] = row.apart_m;
    one["sub_steps_times"] = row.sub_steps_times;
    one["hand"] = name_of(row.hand);
    one["force_error"] = row.force_error;
    one["force_error_by_quarter"] = row.force_error_quarter;
    one["force_rms_N"] = row.force_rms_N;
    one["pose_off_m"] = row.pose_off_m;
    one["pose_off_most_m"] = row.pose_off_most_m;
    one["pose_off_share_of_size"] = row.pose_off_share;
    one["drift_m"] = row.drift_m;
    one["deepest_m"] = row.deepest_m;
    one["direct_deepest_m"] = row.direct_deepest_m;
    one["kinetic_J"] = row.kinetic_J;
    one["kinetic_over_work"] = row.kinetic_over_work;
    one["energy_gain_J"] = row.energy_gain_J;
    one["direct_energy_gain_J"] = row.direct_energy_gain_J;
    one["energy_rise_J"] = row.energy_rise_J;
    one["direct_energy_rise_J"] = row.direct_energy_rise_J;
    one["energy_unexplained_J"] = row.energy_unexplained_J;
    one["direct_energy_unexplained_J"] = row.direct_energy_unexplained_J;
    one["energy_at_play_J"] = row.energy_at_play_J;
    one["device_work_J"] = row.account.device_J;
    one["border_work_J"] = row.account.border_work_J;
    one["corrected_J"] = row.account.corrected_J;
    one["border_tank_J"] = row.account.tank_J;
    one["border_spent_share"] = row.account.spent_share;
    one["global_border_work_J"] = row.account.global_work_J;
    one["imposed_J"] = row.account.imposed_J;
    one["returned_J"] = row.account.returned_J;
    one["fallen"] = row.fallen;
    one["stands"] = row.stands;
    list.push_back(std::move(one));
  }
  return list;
}

std::string whole_csv(std::span<const WholeRunRow> rows) { return csv_of(kWholeColumns, whole_rows_json(rows)); }

}  // namespace tactus::experiment
