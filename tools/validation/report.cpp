#include "tools/validation/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "tools/json_report.h"
#include "tools/plot/svg.h"

namespace tactus::hard_cases {
namespace {

using nlohmann::ordered_json;

// A column: one accuracy at one step.
std::vector<Setting> settings_in(const Report& report) {
  std::vector<Setting> settings;
  for (const Row& row : report.rows) {
    const auto same = [&](const Setting& s) {
      return s.accuracy == row.setting.accuracy && s.step_s == row.setting.step_s;
    };
    if (std::none_of(settings.begin(), settings.end(), same)) settings.push_back(row.setting);
  }
  std::stable_sort(settings.begin(), settings.end(),
                   [](const Setting& a, const Setting& b) { return a.step_s < b.step_s; });
  return settings;
}

const Row* row_at(const Report& report, const HardCase* one, const Setting& setting) {
  for (const Row& row : report.rows)
    if (row.one == one && row.setting.accuracy == setting.accuracy && row.setting.step_s == setting.step_s) return &row;
  return nullptr;
}

std::vector<const HardCase*> cases_in(const Report& report) {
  std::vector<const HardCase*> cases;
  for (const Row& row : report.rows)
    if (cases.empty() || cases.back() != row.one) cases.push_back(row.one);
  return cases;
}

std::string heading(const Setting& setting) {
  return fmt::format("{} {:g} ms", name_of(setting.accuracy), 1e3 * setting.step_s);
}

std::string cell(const Row* row) {
  if (row == nullptr) return "-";
  return fmt::format("{:.2f}{}", row->outcome.score(), row->outcome.passed() ? "" : " FAIL");
}

constexpr const char* kLegend =
    "1: every metric within its tolerance; a half less for each factor of ten beyond; 0: a gate broke; -: only in 1 "
    "ms.";

}  // namespace

std::string report_table(const Report& report) {
  const auto settings = settings_in(report);
  std::string text = fmt::format("{:>4} {:<44}", "", "score");
  for (const Setting& setting : settings) text += fmt::format(" {:>15}", heading(setting));
  text += '\n';
  for (const HardCase* one : cases_in(report)) {
    text += fmt::format("{:>4} {:<44}", one->number, one->name);
    for (const Setting& setting : settings) text += fmt::format(" {:>15}", cell(row_at(report, one, setting)));
    text += '\n';
  }
  text += fmt::format("\n{}\n", kLegend);
  if (report.peers.empty()) return text;
  text +=
      fmt::format("\n{:<32} {:<14} {:>8} {:>7} {:>10} {:>10}\n", "stack", "engine", "step ms", "", "sag mm", "side mm");
  for (const PeerRow& row : report.peers)
    text += fmt::format("{:<32} {:<14} {:>8g} {:>7} {:>10.3f} {:>10.3f}\n", row.stack, row.engine, 1e3 * row.step_s,
                        row.state.stands ? "stands" : "FALLS", 1e3 * row.state.sag_m, 1e3 * row.state.side_m);
  return text;
}

std::string failures_text(const Report& report) {
  std::string text;
  for (const Row& row : report.rows) {
    if (row.outcome.passed()) continue;
    text += fmt::format("{} {}, {}:\n", row.one->number, row.one->name, heading(row.setting));
    const std::string_view why = row.one->why_it_fails(row.setting.step_s);
    if (!why.empty() && row.setting.accuracy == Accuracy::kBalanced) text += fmt::format("    known: {}\n", why);
    for (const std::string& gate : row.outcome.broken_gates) text += fmt::format("    gate broken: {}\n", gate);
    for (const Metric& metric : row.outcome.metrics)
      if (!metric.within())
        text += fmt::format("    {}: {:.6g}, expected {:.6g}, error {:.3g} of {:.3g} allowed\n", metric.name,
                            metric.observed, metric.expected, metric.error, metric.tolerance);
  }
  return text;
}

std::string report_json(const Report& report) {
  ordered_json rows = ordered_json::array(), peers = ordered_json::array();
  for (const Row& row : report.rows) {
    ordered_json metrics = ordered_json::array();
    for (const Metric& m : row.outcome.metrics)
      metrics.push_back({{"name", m.name},
                         {"observed", m.observed},
                         {"expected", m.expected},
                         {"error", m.error},
                         {"tolerance", m.tolerance},
                         {"score", m.score()}});
    rows.push_back({{"case", row.one->name},
                    {"number", row.one->number},
                    {"accuracy", name_of(row.setting.accuracy)},
                    {"step_ms", 1e3 * row.setting.step_s},
                    {"score", row.outcome.score()},
                    {"passed", row.outcome.passed()},
                    {"known_failure", row.one->why_it_fails(row.setting.step_s)},
                    {"broken_gates", row.outcome.broken_gates},
                    {"state_hash", fmt::format("{:016x}", row.outcome.hash)},
                    {"metrics", metrics}});
  }
  for (const PeerRow& row : report.peers)
    peers.push_back({{"case", row.stack},
                     {"engine", row.engine},
                     {"step_ms", 1e3 * row.step_s},
                     {"stands", row.state.stands},
                     {"sag_mm", 1e3 * row.state.sag_m},
                     {"side_mm", 1e3 * row.state.side_m}});
  return report_text(ordered_json{{"rows", rows}, {"peers", peers}}, 2);
}

std::string report_csv(const Report& report) {
  std::string text = "number,case,accuracy,step [ms],metric,observed,expected,error,tolerance,score,passed\n";
  for (const Row& row : report.rows) {
    const std::string start = fmt::format("{},\"{}\",{},{:g}", row.one->number, row.one->name,
                                          name_of(row.setting.accuracy), 1e3 * row.setting.step_s);
    for (const std::string& gate : row.outcome.broken_gates)
      text += fmt::format("{},\"gate: {}\",,,,,0,false\n", start, gate);
    for (const Metric& m : row.outcome.metrics)
      text += fmt::format("{},\"{}\",{},{},{},{},{:.3f},{}\n", start, m.name, m.observed, m.expected, m.error,
                          m.tolerance, m.score(), m.within());
  }
  return text;
}

std::string report_svg(const Report& report) {
  const auto settings = settings_in(report);
  const auto cases = cases_in(report);
  constexpr plot::Size kCell{112, 20};
  constexpr double kLeft = 400, kTop = 40;
  plot::Drawing drawing;
  const auto x_of = [&](std::size_t column) { return kLeft + kCell.width * static_cast<double>(column); };
  const auto y_of = [&](std::size_t row) { return kTop + kCell.height * static_cast<double>(row); };
  for (std::size_t k = 0; k < settings.size(); ++k)
    drawing.text("column", {x_of(k) + 0.5 * kCell.width, kTop - 12}, plot::Anchor::kMiddle, heading(settings[k]));
  for (std::size_t j = 0; j < cases.size(); ++j) {
    const double y = y_of(j);
    drawing.text("row", {kLeft - 8, y + 14}, plot::Anchor::kEnd,
                 fmt::format("{} {}", cases[j]->number, cases[j]->name));
    for (std::size_t k = 0; k < settings.size(); ++k) {
      const Row* row = row_at(report, cases[j], settings[k]);
      // From red over yellow to green; grey: only in 1 ms.
      drawing.box({x_of(k), y}, kCell,
                  row != nullptr ? fmt::format("hsl({:.0f},60%,70%)", 120 * row->outcome.score()) : "#e5e5e5");
      drawing.text("boxed", {x_of(k) + 0.5 * kCell.width, y + 14}, plot::Anchor::kMiddle, cell(row));
    }
  }
  const double width = x_of(settings.size()) + 10;
  const double bottom =
      drawing.paragraph("made", {8, y_of(cases.size()) + 20}, kLegend, static_cast<std::size_t>(width / 7));
  return drawing.svg("Scores of the hard cases", {width, bottom});
}

}  // namespace tactus::hard_cases
