#include "tools/session/verdict.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <nlohmann/json.hpp>

#include "tools/session/summary.h"

namespace tactus::session {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();
// Smaller amounts are the error of an energy account kept per cycle, and energy stored in the hand's contacts.
constexpr double kMinDegraded_J = 5e-3, kMinBad_J = 20e-3;
constexpr unsigned kLateCycles = 4;

double share_of(std::uint64_t part, std::uint64_t whole) {
  return whole == 0 ? 0.0 : static_cast<double>(part) / static_cast<double>(whole);
}

RunRuling fault_of(const RunSummary& s) {
  const auto& faults = s.stats.faults;
  const bool latched = s.fault_latched();
  const Fault fault = latched ? faults[faults.size() - 1].fault : Fault::kNone;
  return {.rule = "fault",
          .figure = "faults latched at the end",
          .unit = "",
          .measured = latched ? 1.0 : 0.0,
          .degraded_above = kInfinite,
          .bad_above = 0,
          .found = latched ? fmt::format("a fault is latched: {}", describe(fault)) : "",
          .remedy = "see the faults below; Enter or --rearm takes one back"};
}

RunRuling recovered_of(const RunSummary& s) {
  const std::uint64_t recovered = s.stats.fault_count - std::min<std::uint64_t>(s.stats.fault_count, s.fault_latched());
  return {.rule = "faults",
          .figure = "faults that were taken back",
          .unit = "",
          .measured = static_cast<double>(recovered),
          .degraded_above = 0,
          .bad_above = kInfinite,
          .found = fmt::format("{} {} latched and taken back: no force meanwhile", recovered,
                               recovered == 1 ? "fault" : "faults"),
          .remedy = "see the faults below: each has its cause"};
}

// Without a sample the hand feels a fading force, or none.
RunRuling samples_of(const RunSummary& s) {
  const auto ticks_with = [&](StatusBit bit) {
    return s.stats.status_ticks[std::countr_zero(static_cast<std::uint32_t>(bit))];
  };
  const std::uint64_t missing = ticks_with(kFrameMissing), rejected = ticks_with(kInputRejected);
  return {
      .rule = "samples",
      .figure = "ticks without a sample of the device that could be used",
      .unit = "%",
      .measured = 100 * std::min(1.0, share_of(missing + rejected, s.stats.ticks)),
      .degraded_above = 1,
      .bad_above = kInfinite,
      .found = fmt::format("in {} ticks no sample came, in {} it was refused, of {}", missing, rejected, s.stats.ticks),
      .remedy = "see the faults and conditions below; `tactus hil` looks at the link"};
}

RunRuling own_work_of(const RunSummary& s) {
  return {.rule = "own-work",
          .figure = "ticks lost to own work",
          .unit = "",
          .measured = static_cast<double>(s.overruns_own_work),
          .degraded_above = kInfinite,
          .bad_above = 0,
          .found = fmt::format("{} ticks were lost to the program's own work", s.overruns_own_work),
          .remedy = "fewer --members, a lower --rate, or --budget"};
}

RunRuling scene_of(const std::vector<std::string>& problems) {
  std::string found;
  for (const std::string& problem : problems) found += (found.empty() ? "" : "; ") + problem;
  return {.rule = "scene",
          .figure = "problems of the scene",
          .unit = "",
          .measured = static_cast<double>(problems.size()),
          .degraded_above = kInfinite,
          .bad_above = 0,
          .found = found,
          .remedy = "mend the scene: `tactus scene check` says the same"};
}

RunRuling overlap_of(const RunSummary& s) {
  const physics::Overlap& deepest = s.global.overlap;
  const bool known = s.has_global && deepest.share >= s.stats.deepest_share;
  const double share = std::max(s.stats.deepest_share, s.has_global ? deepest.share : 0.0);
  const std::string who =
      !known ? std::string("two bodies overlapped")
             : fmt::format("{} overlapped by {:.2f} mm",
                           s.overlapped.empty() ? fmt::format("bodies {} and {}", deepest.a, deepest.b) : s.overlapped,
                           1e3 * deepest.depth);
  return {.rule = "overlap",
          .figure = "deepest overlap of the thinner body",
          .unit = "%",
          .measured = 100 * share,
          .degraded_above = 10,
          .bad_above = 50,
          .found = fmt::format("{}, {:.0f} % of the thinner one's thickness", who, 100 * share),
          .remedy = "more sub-steps with a higher contact_hertz_Hz, more --members, a lower --ratio, or a slower hand"};
}

// An incomplete energy account is not judged.
void add_energy(const RunSummary& s, std::vector<RunRuling>& rulings) {
  const sim::EnergyBalance& balance = s.global.energy;
  if (!s.has_global || !balance.complete) return;
  const double in_play_J = balance.in_play_J(), found_J = balance.unexplained_J;
  // If almost no energy is in play, every share is large; amounts below `least_J` count as 0.
  const auto share_above = [&](double least_J) { return found_J > least_J ? 100 * found_J / in_play_J : 0.0; };
  const double shown = std::min(1e6, share_above(kMinDegraded_J));
  rulings.push_back(
      {.rule = "energy",
       .figure = "energy that nothing explains",
       .unit = "%",
       .measured = shown,
       .degraded_above = 10,
       .bad_above = found_J > kMinBad_J ? 25 : kInfinite,
       .found = fmt::format("the bodies had {:.3g} J more than gravity and the hand explain, {:.0f} % of the {:.3g} J "
                            "put in or moved",
                            found_J, shown, in_play_J),
       .remedy = "more --members or a lower --ratio: the border between the worlds makes it; more sub-steps where "
                 "there is no border"});
}

RunRuling border_of(const RunSummary& s) {
  const auto bit = static_cast<unsigned>(std::countr_zero(static_cast<std::uint32_t>(kBorderSpent)));
  const std::uint64_t ticks = s.stats.status_ticks[bit];
  return {.rule = "border",
          .figure = "ticks with the border spent",
          .unit = "%",
          .measured = 100 * share_of(ticks, s.stats.ticks),
          .degraded_above = 1,
          .bad_above = 10,
          .found = fmt::format("the border had nothing left to give in {} of {} ticks", ticks, s.stats.ticks),
          .remedy = "more --members, or a lower --ratio"};
}

std::string capacity_words(std::uint32_t bits) {
  static constexpr std::pair<std::uint32_t, const char*> kWords[] = {{physics::kBodiesFull, "bodies"},
                                                                     {physics::kFixedBodiesFull, "fixed bodies"},
                                                                     {physics::kPairsFull, "pairs"},
                                                                     {physics::kContactsFull, "contacts"},
                                                                     {physics::kBorderContactsFull, "border contacts"},
                                                                     {physics::kMeshTrianglesFull, "mesh triangles"}};
  std::string words;
  for (const auto& [bit, word] : kWords)
    if ((bits & bit) != 0) words += (words.empty() ? "" : ", ") + std::string(word);
  return words.empty() ? "entries" : words;
}

RunRuling capacity_of(const RunSummary& s) {
  const std::uint32_t bits = s.stats.capacity_bits | (s.has_global ? s.global.capacity_bits : 0u);
  const std::uint64_t dropped = s.stats.dropped + (s.has_global ? s.global.dropped_entries : 0u);
  return {
      .rule = "capacity",
      .figure = "entries left out",
      .unit = "",
      .measured = bits != 0 ? std::max(1.0, static_cast<double>(dropped)) : 0.0,
      .degraded_above = 0,
      .bad_above = kInfinite,
      .found = fmt::format("a capacity was exceeded, of {}: {} entries were left out", capacity_words(bits), dropped),
      .remedy = "fewer --members, or a scene with fewer contacts in one place"};
}

RunRuling deadlines_of(const RunSummary& s) {
  const std::uint64_t late = s.overruns_late_wake + s.overruns_interrupted, lost = late + s.timing.skipped_ticks;
  const std::uint64_t all = s.timing.ticks + s.timing.skipped_ticks;
  return {.rule = "deadlines",
          .figure = "deadlines lost to the machine",
          .unit = "of 10000",
          .measured = 1e4 * share_of(lost, all),
          .degraded_above = most_lost_of_10000(all),
          .bad_above = kInfinite,
          .found = fmt::format("the machine lost {} deadlines: {} ticks late, {} skipped", lost, late,
                               s.timing.skipped_ticks),
          .remedy = "`tactus doctor` says what takes the core",
          .machine = true};
}

RunRuling clock_of(const RunSummary& s) {
  const double run_ms = static_cast<double>(s.stats.ticks) * s.options.period_s() * 1e3;
  const double cycles_ms = kLateCycles * s.ratio * s.options.period_s() * 1e3, late_ms = s.dilation_ms();
  return {.rule = "clock",
          .figure = "global clock behind the haptic one",
          .unit = "%",
          .measured = run_ms > 0 ? 100 * late_ms / run_ms : 0.0,
          .degraded_above = run_ms > 0 ? std::max(1.0, 100 * cycles_ms / run_ms) : 1.0,
          .bad_above = kInfinite,
          .found = fmt::format("the global world was late: its clock lost {:.0f} of {:.0f} ms", late_ms, run_ms),
          .remedy = "a higher --ratio, --world-threads, or a lighter scene",
          .machine = true};
}

RunRuling setup_of(const RunSummary& s) {
  std::string names;
  unsigned failed = 0;
  for (const auto& step : s.setup.steps)
    if (!step.ok) {
      ++failed;
      names += fmt::format("{}{}", names.empty() ? "" : ", ", step.name);
    }
  return {
      .rule = "set-up",
      .figure = "set-up steps that failed",
      .unit = "",
      .measured = static_cast<double>(failed),
      .degraded_above = 0,
      .bad_above = kInfinite,
      .found = fmt::format("without {} as asked for: its timing says more about the machine than about tactus", names),
      .remedy = "see set-up: each line has its remedy",
      .machine = true};
}

RunRuling tape_of(const RunSummary& s) {
  const bool faulty = !s.tape_fault.empty();
  return {.rule = "tape",
          .figure = "ticks and records that are not on the tape",
          .unit = "",
          .measured = static_cast<double>(s.tape_lost_ticks + s.tape_dropped + (faulty ? 1 : 0)),
          .degraded_above = 0,
          .bad_above = kInfinite,
          .found = faulty ? fmt::format("{}; {} ticks are not on it", s.tape_fault, s.tape_lost_ticks)
                          : fmt::format("the disk was too slow for the tape: {} records are not on it", s.tape_dropped),
          .remedy = "a disk with room, and fast enough; the run itself is whole",
          .machine = true};
}

// A limit is infinite if the rule does not have that level.
std::string limit_text(const RunRuling& r) {
  const double limit = r.level() == Level::kBad ? r.bad_above : r.degraded_above;
  const auto number = [](double x) { return std::abs(x) < 1000 ? fmt::format("{:.3g}", x) : fmt::format("{:.0f}", x); };
  return limit > 0 ? fmt::format(" ({} {}; good up to {})", number(r.measured), r.unit,
                                 number(std::min(r.degraded_above, r.bad_above)))
                   : "";
}

nlohmann::json finite_or_null(double value) {
  return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json(nullptr);
}

}  // namespace

const char* name_of(Level level) noexcept {
  switch (level) {
    case Level::kGood:
      return "good";
    case Level::kDegraded:
      return "degraded";
    case Level::kBad:
      return "bad";
  }
  return "";
}

// Written so that NaN is not good.
Level RunRuling::level() const noexcept {
  if (!(measured <= bad_above)) return Level::kBad;
  return measured <= degraded_above ? Level::kGood : Level::kDegraded;
}

Level RunVerdict::level() const noexcept {
  Level worst = Level::kGood;
  for (const RunRuling& ruling : rulings) worst = std::max(worst, ruling.level());
  return worst;
}

std::string RunVerdict::line() const {
  const Level worst = level();
  if (worst == Level::kGood) return "good";
  const auto first =
      std::find_if(rulings.begin(), rulings.end(), [worst](const RunRuling& r) { return r.level() == worst; });
  return fmt::format("{}: {}", worst == Level::kBad ? "BAD" : "DEGRADED", first->found);
}

std::string RunVerdict::text() const {
  std::string text;
  for (const Level level : {Level::kBad, Level::kDegraded})
    for (const RunRuling& r : rulings)
      if (r.level() == level)
        text += fmt::format("  {:<8} {:<13} {}{}\n  {:<22} {}\n", name_of(level), r.rule, r.found, limit_text(r), "",
                            r.remedy);
  return text.empty() ? text : "why not good\n" + text;
}

double most_lost_of_10000(std::uint64_t ticks) noexcept {
  return ticks == 0 ? 1.0 : std::max(1.0, 1e4 / static_cast<double>(ticks));
}

std::vector<RunRuling> judge_simulation(const RunSummary& s) {
  std::vector<RunRuling> rulings{fault_of(s), recovered_of(s), samples_of(s), scene_of(s.scene_problems),
                                 overlap_of(s)};
  add_energy(s, rulings);
  rulings.push_back(border_of(s));
  rulings.push_back(capacity_of(s));
  if (s.has_global) rulings.push_back(clock_of(s));
  if (s.real_time) rulings.push_back(setup_of(s));
  if (!s.tape.empty()) rulings.push_back(tape_of(s));
  return rulings;
}

RunVerdict judge(const RunSummary& s) {
  RunVerdict verdict{judge_simulation(s)};
  if (!s.real_time) return verdict;
  verdict.rulings.insert(verdict.rulings.begin() + 1, own_work_of(s));
  verdict.rulings.push_back(deadlines_of(s));
  return verdict;
}

RunVerdict judge(const sim::SceneReport& report) { return {{scene_of(report.problems)}}; }

nlohmann::json to_json(const RunVerdict& verdict) {
  nlohmann::json list = nlohmann::json::array();
  for (const RunRuling& r : verdict.rulings) {
    nlohmann::json one{{"rule", r.rule},
                       {"level", name_of(r.level())},
                       {"figure", r.figure},
                       {"unit", r.unit},
                       {"measured", finite_or_null(r.measured)},
                       {"degraded_above", finite_or_null(r.degraded_above)},
                       {"bad_above", finite_or_null(r.bad_above)},
                       {"whose", r.machine ? "machine" : "program"}};
    if (r.level() != Level::kGood) {
      one["found"] = r.found;
      one["cure"] = r.remedy;
    }
    list.push_back(one);
  }
  return list;
}

}  // namespace tactus::session
