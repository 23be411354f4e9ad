#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "tools/json_report.h"
#include "tools/tune/tune.h"

namespace tactus::tune {
namespace {

using nlohmann::ordered_json;

std::string line_of(const char* name, const Trial& t) {
  const CostSetting& s = t.setting;
  return fmt::format("{:<11} {:>9} {:>6} {:>8} {:>6} {:>12.3f} {:>12.0f} {:>15.0f}\n", name, s.sub_steps,
                     s.relax_sweeps, s.members, s.scheme.ratio, 100 * t.force_error, t.tick_us_p99,
                     t.global_us_per_tick);
}

bool is_stiffer(const FurtherStep& step, const Trial& chosen) {
  return step.change.setting.contact_Hz != chosen.setting.contact_Hz;
}

// "members 16 -> 20: saves 0.31 % of force error, costs 24 us a tick; fits"
std::string sentence_of(const FurtherStep& step, const Trial& chosen, const Limits& limits) {
  const double time_us = step.trial.tick_us_p99 - chosen.tick_us_p99,
               global_us = step.trial.global_us_per_tick - chosen.global_us_per_tick,
               error = 100 * (step.trial.force_error - chosen.force_error);
  const std::string buys =
      is_stiffer(step, chosen)  // the simulated stiffness differs, so errors are not comparable
          ? "overlaps a quarter as deep"
          : fmt::format("{} {:.3f} % of force error", error <= 0 ? "saves" : "adds", std::abs(error));
  std::string text =
      fmt::format("{} {} -> {}: {}, {} {:.0f} us a tick and {} {:.0f} us of the global world's; ", step.change.factor,
                  step.change.from, step.change.to, buys, time_us <= 0 ? "saves" : "costs", std::abs(time_us),
                  global_us <= 0 ? "saves" : "costs", std::abs(global_us));
  if (step.fits) return text + "fits";
  return text + (step.trial.tick_us_p99 > limits.tick_us
                     ? fmt::format("does not fit: a tick of {:.0f} us, {:.0f} are allowed", step.trial.tick_us_p99,
                                   limits.tick_us)
                     : fmt::format("does not fit: {:.0f} us of the global world a tick, {:.0f} are allowed",
                                   step.trial.global_us_per_tick, limits.global_us));
}

ordered_json to_json(const Trial& t) {
  const CostSetting& s = t.setting;
  return {
      {"sub_steps", s.sub_steps},     {"relax_sweeps", s.relax_sweeps}, {"contact_Hz", s.contact_Hz},
      {"members", s.members},         {"ratio", s.scheme.ratio},        {"force_error_rms", t.force_error},
      {"tick_us_p50", t.tick_us_p50}, {"tick_us_p99", t.tick_us_p99},   {"global_us_per_tick", t.global_us_per_tick}};
}

}  // namespace

std::string command_of(const TuneReport& report) {
  return fmt::format("tactus run {} --members {} --ratio {}", report.file, report.chosen.setting.members,
                     report.chosen.setting.scheme.ratio);
}

std::string snippet_of(const TuneReport& report) {
  const CostSetting& s = report.chosen.setting;
  return fmt::format("[simulation]\nsub_steps = {}\nrelax_sweeps = {}\nmembers = {}\nratio = {}\n", s.sub_steps,
                     s.relax_sweeps, s.members, s.scheme.ratio);
}

std::string tune_text(const TuneReport& r) {
  std::string text;
  if (r.of_scene.level() != session::Level::kGood)
    text = fmt::format("the scene itself is {}\n{}\n", r.of_scene.line(), r.of_scene.text());
  text += fmt::format("{:<11} {:>9} {:>6} {:>8} {:>6} {:>12} {:>12} {:>15}\n", r.scene, "sub-steps", "relax", "members",
                      "ratio", "force err. %", "tick p99 us", "global us/tick");
  text += line_of("as written", r.written) + line_of(r.fits ? "chosen" : "cheapest", r.chosen);
  text += fmt::format(
      "\n{} settings, {} windows of 200 ms in which the hand presses, against all {} bodies at 1 kHz with 16 sub-steps "
      "and two\nrelax sweeps. Times as in the loop: {:.2f} times those of ticks in a row. Allowed: {:.0f} us a tick, "
      "{:.0f} us of the\nglobal world.\n",
      r.trials, r.windows, r.bodies, r.core_factor, r.limits.tick_us, r.limits.global_us);
  const RealRun& real = r.real;
  text += fmt::format(
      "\nin real time, {:.0f} s{}: tick p50 {:.0f}, p99 {:.0f}, max {:.0f} us; {} lost to own work; {:.2f} % with "
      "fewer "
      "sub-steps,\n{:.2f} % of the cycles with fewer members, {:.2f} % late: {}\n",
      real.duration_s, real.degraded ? ", degraded: the set-up is not as asked for" : "", real.tick_us_p50,
      real.tick_us_p99, real.tick_us_max, real.lost, 100 * real.reduced_share, 100 * real.restrained_share,
      100 * real.late_share, real.holds() ? "it holds" : "IT DOES NOT HOLD");
  text += fmt::format("\n{}\n\nand in the scene, where sub-steps and relax sweeps are set:\n\n{}", command_of(r),
                      snippet_of(r));
  if (!r.further.empty()) text += "\nOne step further:\n";
  for (const FurtherStep& step : r.further) text += "  " + sentence_of(step, r.chosen, r.limits) + "\n";
  return text;
}

std::string tune_json(const TuneReport& r) {
  ordered_json further = ordered_json::array();
  for (const FurtherStep& step : r.further) {
    ordered_json one = to_json(step.trial);
    one["factor"] = step.change.factor;
    one["from"] = step.change.from;
    one["to"] = step.change.to;
    one["fits"] = step.fits;
    one["sentence"] = sentence_of(step, r.chosen, r.limits);
    further.push_back(one);
  }
  return report_text(ordered_json{{"scene", r.scene},
                                  {"scene_file", r.file},
                                  {"scene_hash", r.scene_hash},
                                  {"scene_verdict", r.of_scene.line()},
                                  {"bodies", r.bodies},
                                  {"windows", r.windows},
                                  {"trials", r.trials},
                                  {"core_factor", r.core_factor},
                                  {"limits",
                                   {{"tick_us", r.limits.tick_us},
                                    {"global_us_per_tick", r.limits.global_us},
                                    {"members", r.limits.members},
                                    {"sub_steps", r.limits.sub_steps}}},
                                  {"written", to_json(r.written)},
                                  {"chosen", to_json(r.chosen)},
                                  {"fits", r.fits},
                                  {"real",
                                   {{"duration_s", r.real.duration_s},
                                    {"tick_us_p50", r.real.tick_us_p50},
                                    {"tick_us_p99", r.real.tick_us_p99},
                                    {"tick_us_max", r.real.tick_us_max},
                                    {"lost_to_own_work", r.real.lost},
                                    {"reduced_share", r.real.reduced_share},
                                    {"restrained_share", r.real.restrained_share},
                                    {"late_share", r.real.late_share},
                                    {"degraded", r.real.degraded},
                                    {"holds", r.real.holds()}}},
                                  {"command", command_of(r)},
                                  {"snippet", snippet_of(r)},
                                  {"further", further}},
                     2);
}

}  // namespace tactus::tune
