// Reports of the suite: as a table, as one JSON object, as JUnit XML.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "tools/hil/suite.h"
#include "tools/json_report.h"
#include "tools/xml_text.h"

namespace tactus::hil {
namespace {

const char* word(CheckVerdict verdict) {
  return verdict == CheckVerdict::kGood ? "good" : verdict == CheckVerdict::kBad ? "bad" : "skipped";
}

std::string totals(const SuiteReport& report) {
  return fmt::format("{} good, {} bad, {} skipped", report.count(CheckVerdict::kGood), report.count(CheckVerdict::kBad),
                     report.count(CheckVerdict::kSkipped));
}

}  // namespace

std::string to_line(const CheckReport& report) {
  const CheckFinding& finding = report.finding;
  std::string line = fmt::format("  {:<18} {:<8}{}\n", report.check->name, word(finding.verdict),
                                 finding.measured.empty() ? finding.reason : finding.measured);
  if (finding.verdict == CheckVerdict::kSkipped) return line;
  if (!finding.threshold.empty()) line += fmt::format("  {:<26} held against: {}\n", "", finding.threshold);
  if (!finding.reason.empty() && !finding.measured.empty())
    line +=
        fmt::format("  {:<26} {}: {}\n", "", finding.verdict == CheckVerdict::kBad ? "bad" : "note", finding.reason);
  if (!finding.unseen.empty()) line += fmt::format("  {:<26} not checked: {}\n", "", finding.unseen);
  return line;
}

std::string to_text(const SuiteReport& report) {
  std::string text = fmt::format("tactus hil: {}: {}{}\n", report.device, report.good() ? "good" : "BAD",
                                 report.degraded() ? ", DEGRADED: the set-up is not as asked for" : "");
  text += fmt::format("  {}\n", totals(report));
  if (!report.left_in.empty()) text += fmt::format("  the device is left in {}\n", report.left_in);
  if (report.degraded())
    for (const auto& step : report.setup.steps)
      if (!step.ok) text += fmt::format("  FAIL {:<17} {}\n", step.name, step.message());
  return text;
}

std::string to_json_text(const SuiteReport& report) {
  nlohmann::ordered_json object{{"device", report.device},
                                {"identity", report.identity},
                                {"verdict", !report.good()      ? "bad"
                                            : report.degraded() ? "degraded"
                                                                : "good"},
                                {"degraded", report.degraded()},
                                {"real_time", report.real_time},
                                {"good", report.count(CheckVerdict::kGood)},
                                {"bad", report.count(CheckVerdict::kBad)},
                                {"skipped", report.count(CheckVerdict::kSkipped)},
                                {"left_in", report.left_in}};
  object["checks"] = nlohmann::ordered_json::array();
  for (const CheckReport& one : report.checks) {
    nlohmann::ordered_json check{{"name", one.check->name},
                                 {"verdict", word(one.finding.verdict)},
                                 {"measured", one.finding.measured},
                                 {"threshold", one.finding.threshold},
                                 {"reason", one.finding.reason},
                                 {"not_checked", one.finding.unseen},
                                 {"took_s", one.took_s}};
    check["figures"] = nlohmann::ordered_json::object();
    for (const Figure& figure : one.finding.figures) check["figures"][figure.name] = figure.value;
    object["checks"].push_back(std::move(check));
  }
  if (report.real_time) {
    object["setup"] = nlohmann::ordered_json::array();
    for (const auto& step : report.setup.steps)
      object["setup"].push_back({{"name", step.name}, {"ok", step.ok}, {"message", std::string(step.message())}});
  }
  return report_text(object, 2);
}

std::string to_junit(const SuiteReport& report) {
  double all_s = 0;
  for (const CheckReport& one : report.checks) all_s += one.took_s;
  std::string xml = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";
  xml += fmt::format("<testsuite name=\"tactus hil {}\" tests=\"{}\" failures=\"{}\" skipped=\"{}\" time=\"{:.3f}\">\n",
                     xml_text(report.device), report.checks.size(), report.count(CheckVerdict::kBad),
                     report.count(CheckVerdict::kSkipped), all_s);
  for (const CheckReport& one : report.checks) {
    const CheckFinding& finding = one.finding;
    xml += fmt::format("  <testcase classname=\"hil\" name=\"{}\" time=\"{:.3f}\">\n", xml_text(one.check->name),
                       one.took_s);
    if (finding.verdict == CheckVerdict::kBad)
      xml += fmt::format("    <failure message=\"{}\">held against: {}</failure>\n", xml_text(finding.reason),
                         xml_text(finding.threshold));
    if (finding.verdict == CheckVerdict::kSkipped)
      xml += fmt::format("    <skipped message=\"{}\"/>\n", xml_text(finding.reason));
    const char* const before_unseen = finding.measured.empty() || finding.unseen.empty() ? "" : "; ";
    const std::string unseen = finding.unseen.empty() ? "" : before_unseen + ("not checked: " + finding.unseen);
    if (!finding.measured.empty() || !unseen.empty())
      xml += fmt::format("    <system-out>{}{}</system-out>\n", xml_text(finding.measured), xml_text(unseen));
    xml += "  </testcase>\n";
  }
  return xml + "</testsuite>\n";
}

}  // namespace tactus::hil
