#include "tools/timing/report.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "tools/session/cores.h"
#include "tools/timing/plot.h"

namespace tactus::timing {
namespace {

using nlohmann::ordered_json;

const Histogram& wake(const TimingResult& r) {
  return r.statistics.stages[static_cast<std::size_t>(TimedStage::kWake)];
}

std::string times_line(const std::string& name, const Histogram& h) {
  return fmt::format("  {:<24} {:>8.1f} {:>8.1f} {:>8.1f} {:>9.1f}\n", name, us(h.percentile_ns(50)),
                     us(h.percentile_ns(99)), us(h.percentile_ns(99.99)), us(h.max_ns()));
}

ordered_json times_json(const Histogram& h) {
  return {{"count", h.count()},
          {"p50_us", us(h.percentile_ns(50))},
          {"p99_us", us(h.percentile_ns(99))},
          {"p99_99_us", us(h.percentile_ns(99.99))},
          {"max_us", us(h.max_ns())}};
}

std::string four_digits(double value) { return fmt::format("{:.{}f}", value, std::abs(value) < 999.95 ? 1 : 0); }

// The rows on times first, then the findings of the rules of a run.
std::string verdict_line(const TimingResult& r) {
  const TimingVerdict verdict = r.verdict();
  if (verdict == TimingVerdict::kGood) return "good";
  const bool bad = verdict == TimingVerdict::kBad;
  std::string found;
  for (const VerdictRow& row : r.rows) {
    if (row.good() || row.ours != bad) continue;
    if (row.found.empty())
      return fmt::format("{}: {} {}, at most {}{}{}{}", bad ? "BAD" : "THE MACHINE", row.figure,
                         four_digits(row.measured), four_digits(row.limit), row.unit.empty() ? "" : " ", row.unit,
                         bad ? "" : "; the program lost no tick to its own work");
    if (found.empty()) found = row.found;
  }
  return (bad ? "BAD: " : "DEGRADED: ") + found;
}

std::string stages_text(const TimingResult& r) {
  const TickStatistics& b = r.statistics;
  std::string text =
      fmt::format("time of                     {:>8} {:>8} {:>8} {:>9}  us\n", "p50", "p99", "p99.99", "max");
  for (std::uint32_t i = 0; i < kStages; ++i) text += times_line(name_of(static_cast<TimedStage>(i)), b.stages[i]);
  text += times_line("execution", b.execution);
  text += times_line("  computing", b.compute);
  text += times_line("  the loop's own part", b.overhead);
  text += times_line("done, from the deadline on", b.done);
  text += times_line("force age, when written", b.force_age);
  text += times_line("force age, when replaced", b.oldest_age);
  if (b.bare_ticks > 0) text += times_line("bare timer's wake-up", b.bare_wake);
  if (r.cyclictest_wake.count() > 0) text += times_line("cyclictest's wake-up", r.cyclictest_wake);
  return text;
}

std::string ratio_text(const TimingResult& r, const char* name, const Histogram& other) {
  if (other.count() == 0) return "";
  return fmt::format("wake-up of the loop / {:<14} p50 {:.2f}, p99 {:.2f}\n", name, wake_ratio(r, other, 50),
                     wake_ratio(r, other, 99));
}

struct ViewerRow {
  const char *name, *key;
  Histogram WindowTimes::*times;
};
constexpr ViewerRow kViewerRows[] = {{"wake-up", "wake", &WindowTimes::wake},
                                     {"read, compute, write", "execution", &WindowTimes::execution}};

std::string viewer_text(const WatchedWindows& v) {
  if (!v.any()) return "";
  std::string text = fmt::format(
      "a viewer in turns          {} windows with it ({} ticks, {} frames taken), {} without ({} ticks), {} neither\n"
      "                            with, p50  without    ratio  with, p99  without    ratio  us\n",
      v.with.windows, v.with.ticks, v.with.frames, v.without.windows, v.without.ticks, v.other);
  for (const ViewerRow& row : kViewerRows) {
    const Histogram &with = v.with.*row.times, &without = v.without.*row.times;
    text += fmt::format("  {:<24}", row.name);
    for (const double percent : {50.0, 99.0})
      text += fmt::format(" {:>10.1f} {:>8.1f} {:>8.3f}", us(with.percentile_ns(percent)),
                          us(without.percentile_ns(percent)), ratio_of(with, without, percent));
    text += "\n";
  }
  return text;
}

ordered_json viewer_json(const WatchedWindows& v) {
  ordered_json j;
  for (const auto& [key, windows] : {std::pair{"with", &v.with}, std::pair{"without", &v.without}}) {
    j[key] = {{"windows", windows->windows}, {"ticks", windows->ticks}, {"frames", windows->frames}};
    for (const ViewerRow& row : kViewerRows) j[key][row.key] = times_json(windows->*row.times);
  }
  j["windows_neither"] = v.other;
  for (const ViewerRow& row : kViewerRows)
    for (const int percent : {50, 99})
      j[fmt::format("{}_ratio_p{}", row.key, percent)] = ratio_of(v.with.*row.times, v.without.*row.times, percent);
  return j;
}

std::string overruns_text(const TimingResult& r) {
  const TickStatistics& b = r.statistics;
  std::string causes;
  for (std::uint32_t i = 0; i < kCauses; ++i)
    causes += fmt::format("{}{} {}", i > 0 ? ", " : "", name_of(static_cast<Cause>(i)), b.overruns_by_cause[i]);
  std::string text = fmt::format("overruns                   {} of {} ticks, {} deadlines skipped\n  {}\n", b.overruns,
                                 b.ticks, b.skipped, causes);
  text += fmt::format("haptic thread              {} page faults, {} involuntary context switches\n",
                      b.minor_faults + b.major_faults, b.involuntary_switches);
  text += "latest ticks, overruns or not\n";
  for (const Spike& s : b.spikes)
    text += fmt::format("  tick {:>9}  done {:>7.0f} us after its period's start, {}: {} ({})\n", s.times.tick,
                        static_cast<double>(s.times.wrote_ns - s.times.scheduled_ns) * 1e-3,
                        b.late(s.times) ? "OVERRUN" : "in time", name_of(s.attribution.cause), s.attribution.evidence);
  return text;
}

std::string verdict_text(const TimingResult& r) {
  std::string text = fmt::format("{:<38} {:>10} {:>10}\n", "verdict", "measured", "limit");
  for (const VerdictRow& row : r.rows)
    text += fmt::format("  {:<36} {:>10.1f} {:>10.1f} {:<9} {}\n", row.figure, row.measured, row.limit, row.unit,
                        row.good()          ? "ok"
                        : row.ours          ? "BAD"
                        : row.found.empty() ? "the machine"
                                            : "degraded");
  for (const VerdictRow& row : r.rows)
    if (!row.found.empty()) text += fmt::format("{}\n", row.found);
  return text;
}

}  // namespace

double wake_ratio(const TimingResult& r, const Histogram& other, double percent) {
  const auto mine = static_cast<double>(wake(r).percentile_ns(percent)),
             theirs = static_cast<double>(other.percentile_ns(percent));
  return theirs > 0 ? mine / theirs : 0;
}

std::string to_text(const TimingResult& r) {
  const TickStatistics& b = r.statistics;
  std::string text = fmt::format("tactus timing: {}\n", verdict_line(r));
  text += fmt::format(
      "run                        {} ticks at {:g} Hz on cpu {}, {} processes of load; {} ticks of the bare timer\n",
      b.ticks, r.options.run.rate_Hz, r.options.run.cpu,
      r.options.load == LoadKind::kNone ? 0 : session::cores_without(r.options.run.cpu).size(), b.bare_ticks);
  text += fmt::format(
      "capacity                   {} members declared, {} reached ({} ticks); {} contacts, {} points, {} border "
      "contacts\n\n",
      r.options.members, b.members_max, b.at_capacity, b.contacts_max, b.points_max, b.border_max);
  std::vector<Curve> curves{{"done after the deadline's start", &b.done}, {"wake-up", &wake(r)}};
  if (b.bare_ticks > 0) curves.push_back({"bare timer's wake-up", &b.bare_wake});
  if (r.cyclictest_wake.count() > 0) curves.push_back({"cyclictest's wake-up", &r.cyclictest_wake});
  text += histogram_text(curves, b.settings().period_ns) + "\n" + stages_text(r);
  text += ratio_text(r, "bare timer", b.bare_wake) + ratio_text(r, "cyclictest", r.cyclictest_wake);
  text += viewer_text(r.viewer) + "\n";
  text += overruns_text(r) + "\n" + verdict_text(r);
  if (r.records_lost > 0)
    text += fmt::format("{} ticks were not recorded: the other cores were too busy to look\n", r.records_lost);
  text += "set-up of the haptic thread\n";
  for (const auto& step : r.summary.setup.steps)
    text += fmt::format("  {:<4} {:<17} {}\n", step.ok ? "ok" : "FAIL", step.name, step.message());
  return text;
}

ordered_json to_json(const TimingResult& r) {
  const TickStatistics& b = r.statistics;
  ordered_json j{{"scene", r.summary.scene_name},      {"scene_file", r.options.run.scene.string()},
                 {"scene_hash", r.summary.scene_hash}, {"verdict", name_of(r.verdict())},
                 {"degraded", r.summary.degraded()},   {"ticks", b.ticks},
                 {"rate_Hz", r.options.run.rate_Hz},   {"cpu", r.options.run.cpu}};
  for (std::uint32_t i = 0; i < kStages; ++i)
    j["stages"][name_of(static_cast<TimedStage>(i))] = times_json(b.stages[i]);
  j["execution"] = times_json(b.execution);
  j["computing"] = times_json(b.compute);
  j["own_part"] = times_json(b.overhead);
  j["done"] = times_json(b.done);
  j["force_age"] = times_json(b.force_age);
  j["force_age_when_replaced"] = times_json(b.oldest_age);
  j["bare_timer"] = times_json(b.bare_wake);
  if (r.cyclictest_wake.count() > 0) {
    j["cyclictest"] = times_json(r.cyclictest_wake);
    j["cyclictest"]["wake_ratio_p50"] = wake_ratio(r, r.cyclictest_wake, 50);
    j["cyclictest"]["wake_ratio_p99"] = wake_ratio(r, r.cyclictest_wake, 99);
  }
  if (r.viewer.any()) j["viewer"] = viewer_json(r.viewer);
  for (std::uint32_t i = 0; i < kCauses; ++i) j["overruns"][key_of(static_cast<Cause>(i))] = b.overruns_by_cause[i];
  j["overruns_total"] = b.overruns;
  j["skipped_ticks"] = b.skipped;
  j["page_faults"] = b.minor_faults + b.major_faults;
  j["context_switches"] = b.involuntary_switches;
  j["records_lost"] = r.records_lost;
  j["capacity"] = {{"members_declared", r.options.members},
                   {"members", b.members_max},
                   {"ticks_with_them", b.at_capacity},
                   {"contacts", b.contacts_max},
                   {"points", b.points_max},
                   {"border_contacts", b.border_max}};
  j["thresholds"] = ordered_json::array();
  for (const VerdictRow& row : r.rows)
    j["thresholds"].push_back({{"figure", row.figure},
                               {"unit", row.unit},
                               {"measured", row.measured},
                               {"limit", row.limit},
                               {"good", row.good()},
                               {"whose", row.ours ? "program" : "machine"}});
  j["spikes"] = ordered_json::array();
  for (const Spike& s : b.spikes)
    j["spikes"].push_back({{"tick", s.times.tick},
                           {"done_us", static_cast<double>(s.times.wrote_ns - s.times.scheduled_ns) * 1e-3},
                           {"overrun", b.late(s.times)},
                           {"cause", key_of(s.attribution.cause)},
                           {"evidence", s.attribution.evidence}});
  j["setup"] = ordered_json::array();
  for (const auto& step : r.summary.setup.steps)
    j["setup"].push_back({{"name", step.name}, {"ok", step.ok}, {"message", std::string(step.message())}});
  return j;
}

namespace {

// One sentence that states the result of the plot.
std::string answer(const TimingResult& r) {
  const TickStatistics& b = r.statistics;
  const auto own = b.overruns_by_cause[static_cast<std::size_t>(Cause::kOwnWork)];
  const std::string overruns = b.overruns == 0
                                   ? "none overran"
                                   : fmt::format("{} overran, {} of them by the program's own work", b.overruns, own);
  return fmt::format(
      "Of {} ticks at {:g} Hz with {} members {}: half were done {:.0f} \u00b5s after their period's start, one in 100 "
      "later than {:.0f} \u00b5s, the last {:.0f} \u00b5s, of {:.0f} \u00b5s; verdict: {}.",
      b.ticks, r.options.run.rate_Hz, b.members_max, overruns, us(b.done.percentile_ns(50)),
      us(b.done.percentile_ns(99)), us(b.done.max_ns()), static_cast<double>(b.settings().period_ns) * 1e-3,
      verdict_line(r));
}

}  // namespace

std::string to_svg(const TimingResult& r, const Provenance& made) {
  const TickStatistics& b = r.statistics;
  return histogram_svg(answer(r), made,
                       {{"done, from the period's start on", &b.done},
                        {"wake-up of the loop", &wake(r)},
                        {"wake-up of the bare timer", &b.bare_wake},
                        {"wake-up of cyclictest", &r.cyclictest_wake}},
                       b.settings().period_ns);
}

}  // namespace tactus::timing
