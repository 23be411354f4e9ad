#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "tools/experiment/allocation_count.h"
#include "tools/experiment/csv.h"
#include "tools/experiment/peers.h"
#include "tools/json_report.h"

namespace tactus::experiment {
namespace {

using nlohmann::ordered_json;

std::string ratio_or_dash(double ratio) { return ratio > 0 ? fmt::format("{:.3f}", ratio) : "-"; }

ordered_json json_of(const std::vector<PeersRow>& rows) {
  const auto or_null = [](double value, bool known) { return known ? ordered_json(value) : ordered_json(nullptr); };
  ordered_json list = ordered_json::array();
  for (const PeersRow& row : rows) {
    const Quality& q = row.quality;
    list.push_back({{"scene", row.scene},
                    {"engine", row.engine},
                    {"median_us", row.median_us},
                    {"p99_us", row.p99_us},
                    {"worst_over_median", row.worst_over_median},
                    {"contacts", row.contacts},
                    {"touching_pairs", row.touching_pairs},
                    {"residual_speed_rms_m_per_s", row.residual_speed_rms_m_per_s},
                    {"penetration_mean_m", q.overlap_mean_m},
                    {"penetration_mean_share", q.overlap_mean_share},
                    {"penetration_max_m", q.overlap_max_m},
                    {"penetration_max_share", q.overlap_max_share},
                    {"travel_m", q.travel_m},
                    {"rod_travel_m", q.rod_travel_m},
                    {"escaped", q.escaped},
                    {"slide_error", or_null(row.slide ? row.slide->share : 0, row.slide.has_value())},
                    {"allocations_per_step", or_null(row.allocations_per_step, allocations_are_counted())},
                    {"ratio_to_bullet", or_null(row.ratio_to_bullet, row.ratio_to_bullet > 0)},
                    {"ratio_to_best_peer", or_null(row.ratio_to_best_peer, row.ratio_to_best_peer > 0)},
                    {"is_compared", row.is_compared()},
                    {"settings", row.settings},
                    {"missed_gate", row.missed_gate},
                    {"failure", row.failure}});
  }
  return list;
}

constexpr CsvColumn kPeersColumns[] = {
    {"scene", "scene"},
    {"engine", "engine"},
    {"median [us]", "median_us"},
    {"p99 [us]", "p99_us"},
    {"worst_over_median [1]", "worst_over_median"},
    {"contacts [1]", "contacts"},
    {"touching_pairs [1]", "touching_pairs"},
    {"residual_speed [m/s]", "residual_speed_rms_m_per_s"},
    {"overlap_mean [m]", "penetration_mean_m"},
    {"overlap_mean_share [1]", "penetration_mean_share"},
    {"overlap_max [m]", "penetration_max_m"},
    {"overlap_max_share [1]", "penetration_max_share"},
    {"travel [m]", "travel_m"},
    {"rod_travel [m]", "rod_travel_m"},
    {"escaped [1]", "escaped"},
    {"slide_error [1]", "slide_error"},
    {"allocations_per_step [1]", "allocations_per_step"},
    {"ratio_to_bullet [1]", "ratio_to_bullet"},
    {"ratio_to_best_peer [1]", "ratio_to_best_peer"},
    {"is_compared [1]", "is_compared", CsvColumn::Cell::kOneOrZero},
    {"settings", "settings", CsvColumn::Cell::kQuoted},
};

}  // namespace

std::string peers_table(const std::vector<PeersRow>& rows) {
  constexpr double kMillimetres = 1e3, kPercent = 100;
  std::string text =
      fmt::format("{:<18} {:<15} {:>10} {:>10} {:>8} {:>9} {:>9} {:>8} {:>8} {:>8} {:>7} {:>8} {:>7} {:>7} {:>7}  {}\n",
                  "scene", "engine", "median us", "p99 us", "worst/md", "contacts", "touching", "rms m/s", "mean mm",
                  "deep mm", "deep %", "travel m", "allocs", "/bullet", "/best", "gates");
  std::string scene, notes;
  for (const PeersRow& row : rows) {
    const Quality& q = row.quality;
    text += fmt::format(
        "{:<18} {:<15} {:>10.1f} {:>10.1f} {:>8.2f} {:>9.0f} {:>9.0f} {:>8.1e} {:>8.3f} {:>8.2f} {:>7.1f} {:>8.3f} "
        "{:>7} {:>7} {:>7}  {}\n",
        row.scene == scene ? "" : row.scene, row.engine, row.median_us, row.p99_us, row.worst_over_median, row.contacts,
        row.touching_pairs, row.residual_speed_rms_m_per_s, kMillimetres * q.overlap_mean_m,
        kMillimetres * q.overlap_max_m, kPercent * q.overlap_max_share, q.travel_m,
        allocations_are_counted() ? fmt::format("{:.1f}", row.allocations_per_step) : "-",
        ratio_or_dash(row.ratio_to_bullet), ratio_or_dash(row.ratio_to_best_peer), row.is_compared() ? "pass" : "FAIL");
    if (row.scene != scene) notes += fmt::format("{}\n", row.scene);
    notes += fmt::format("  {:<15} {}\n", row.engine, row.settings);
    if (row.slide)
      notes += fmt::format("  {:<15} boxes that slide over triangles end at most {:.1f} % off their known way ({})\n",
                           "", kPercent * row.slide->share, row.slide->ground);
    if (!row.failure.empty()) notes += fmt::format("  {:<15} DOES NOT COUNT: {}\n", "", row.failure);
    if (!row.missed_gate.empty()) notes += fmt::format("  {:<15} FAILS ITS GATE: {}\n", "", row.missed_gate);
    scene = row.scene;
  }
  return text +
         fmt::format(
             "\nCPU time of one thread; worst/md: the worst step over the median one, each the least of its runs; "
             "allocs: per step.\nOverlaps are computed from the poses by tactus' collision functions, alike for all: "
             "mean over the bodies, deepest,\ndeepest in shares of the thinner body. travel: mean path of a body. "
             "/bullet, /best: to the median of Bullet at its\ndefaults, of the fastest peer that passes; - where one "
             "of the two fails a gate: overlap at most {:.0f} % of a body,\n{:.0f} % in the mean, nothing outside the "
             "box, stirred bodies travel {:.0f} % of the rods' path.\n\n",
             kPercent * kMaxOverlapShare, kPercent * kMaxMeanOverlapShare, kPercent * kMinTravelShare) +
         notes;
}

std::string peers_json(const std::vector<PeersRow>& rows) {
  return report_text(ordered_json{{"rows", json_of(rows)}}, 2);
}

std::string peers_csv(const std::vector<PeersRow>& rows) { return csv_of(kPeersColumns, json_of(rows)); }

}  // namespace tactus::experiment
