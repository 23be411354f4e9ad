#include "tools/validation/trial_report.h"
#include "tools/json_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <nlohmann/json.hpp>

namespace tactus::hard_cases {
namespace {

using nlohmann::ordered_json;
using physics::Body;
using physics::ShapeKind;

RandomTrial figures_of(const RandomTrial& trial) {
  RandomTrial figures;
  figures.seed = trial.seed;
  figures.row = trial.row;
  figures.start_overlap = trial.start_overlap;
  figures.fell = trial.fell;
  figures.still = trial.still;
  auto& row = figures.row;
  row.start.clear();
  row.end.clear();
  row.direct_end.clear();
  return figures;
}

const char* outcome_of(const RandomTrial& trial) {
  if (trial.collapses_overlapping()) return "collapses, overlapping from the start";
  if (trial.still_falls()) return "collapses: what stood still falls";
  if (trial.collapses()) return "collapses";
  if (trial.falls_by_chance()) return "falls by chance";
  return trial.gains_energy() ? "gains energy" : "stands";
}

ordered_json figures_json(const RandomTrial& trial) {
  const auto& row = trial.row;
  return {{"seed", trial.seed},
          {"outcome", outcome_of(trial)},
          {"fell", trial.fell},
          {"still", trial.still},
          {"members", row.members},
          {"standing", row.standing},
          {"fallen", row.fallen},
          {"lost", trial.lost()},
          {"start_overlap_share", trial.start_overlap},
          {"off_share", row.pose_off_share},
          {"energy_gain_share", trial.gain()},
          {"force_error", row.force_error},
          {"force_rms_N", row.force_rms_N}};
}

ordered_json pose_json(const Body& body) {
  const auto& [p, q] = body.motion.pose;
  ordered_json pose = ordered_json::array();
  for (const double value : {p.x, p.y, p.z, q.w, q.x, q.y, q.z}) pose.push_back(value);
  return pose;
}

// Half extents of a box; radius and half length of a capsule (sphere: length 0); nothing for a plane.
ordered_json shape_json(const Body& body) {
  const auto& shape = body.shape;
  if (shape.kind == ShapeKind::kPlane) return {{"shape", "plane"}};
  if (shape.kind == ShapeKind::kBox)
    return {{"shape", "box"}, {"half_m", {shape.half_extents.x, shape.half_extents.y, shape.half_extents.z}}};
  return {{"shape", "capsule"}, {"radius_m", shape.radius}, {"half_length_m", shape.half_length}};
}

ordered_json drawn_json(const RandomTrial& trial) {
  ordered_json one = figures_json(trial), bodies = ordered_json::array(), fixed = ordered_json::array();
  const auto& row = trial.row;
  for (std::size_t k = 0; k < row.end.size(); ++k) {
    ordered_json body = shape_json(row.end[k]);
    const BodyId id = row.end[k].id;
    body["id"] = id;
    body["fell"] = std::find(trial.fell.begin(), trial.fell.end(), id) != trial.fell.end();
    body["start"] = pose_json(row.start[k]);
    body["direct"] = pose_json(row.direct_end[k]);
    body["sub_world"] = pose_json(row.end[k]);
    bodies.push_back(std::move(body));
  }
  for (const Body& one_fixed : trial.fixed) {
    ordered_json body = shape_json(one_fixed);
    body["pose"] = pose_json(one_fixed);
    fixed.push_back(std::move(body));
  }
  one["bodies"] = std::move(bodies);
  one["fixed"] = std::move(fixed);
  return one;
}

std::size_t count(const std::vector<RandomTrial>& trials, bool (RandomTrial::*asked)() const noexcept) {
  return static_cast<std::size_t>(std::count_if(trials.begin(), trials.end(), std::mem_fn(asked)));
}

}  // namespace

void TrialReport::add(Trials trials) {
  for (RandomTrial& trial : trials.trials) add(std::move(trial));
  left_out.insert(left_out.end(), trials.left_out.begin(), trials.left_out.end());
}

void TrialReport::add(RandomTrial trial) {
  with_border += trial.row.end.size() > trial.row.members;
  standing += trial.row.standing;
  const RandomTrial figures = figures_of(trial);
  rows.push_back(figures.row);
  if (!trial.row.stands || trial.gains_energy()) noted.push_back(figures);
  worst.insert(std::upper_bound(worst.begin(), worst.end(), trial, worse), std::move(trial));
  if (worst.size() > kWorst) worst.pop_back();
}

std::size_t TrialReport::collapsed() const { return count(noted, &RandomTrial::collapses); }
std::size_t TrialReport::still_fallen() const { return count(noted, &RandomTrial::still_falls); }
std::size_t TrialReport::overlapping() const { return count(noted, &RandomTrial::collapses_overlapping); }
std::size_t TrialReport::by_chance() const { return count(noted, &RandomTrial::falls_by_chance); }
std::size_t TrialReport::gain_energy() const { return count(noted, &RandomTrial::gains_energy); }

Trials try_seeds(std::uint64_t first, std::uint64_t worlds) {
  Trials trials;
  for (std::uint64_t seed = first; seed < first + worlds; ++seed) {
    auto trial = try_random_world(seed);
    if (trial.ok())
      trials.trials.push_back(std::move(trial).value());
    else
      trials.left_out.push_back(seed);
  }
  return trials;
}

std::string trial_text(const TrialReport& report) {
  std::string text = fmt::format("{:>10} {:>8} {:>9} {:>7} {:>12} {:>9} {:>13}  {}\n", "seed", "members", "standing",
                                 "fallen", "off, sizes", "energy %", "force error %", "outcome");
  const auto line = [&](const RandomTrial& trial) {
    const auto& row = trial.row;
    text += fmt::format("{:>10} {:>8} {:>9} {:>7} {:>12.3g} {:>9.2g} {:>13.3g}  {}\n", trial.seed, row.members,
                        row.standing, row.fallen, row.pose_off_share, 100 * trial.gain(), 100 * row.force_error,
                        outcome_of(trial));
  };
  for (const RandomTrial& trial : report.noted) line(trial);
  text += "\nthe worst:\n";
  for (const RandomTrial& trial : report.worst) line(trial);
  return text +
         fmt::format(
             "\n{} random worlds from seed {}, {} of them with a border; {} bodies stand in the direct runs\n"
             "{} worlds collapse, in {} of them falls what stood still; {} of them start with bodies that overlap by "
             "more than half; in {} a body falls by chance; {} gain energy; {} left out, too fast for a scene file\n",
             report.worlds, report.first, report.with_border, report.standing, report.collapsed(),
             report.still_fallen(), report.overlapping(), report.by_chance(), report.gain_energy(),
             report.left_out.size());
}

std::string trial_json(const TrialReport& report) {
  ordered_json noted = ordered_json::array(), worst = ordered_json::array();
  for (const RandomTrial& trial : report.noted) noted.push_back(figures_json(trial));
  for (const RandomTrial& trial : report.worst) worst.push_back(drawn_json(trial));
  return report_text(ordered_json{{"worlds", report.worlds},
                                  {"first", report.first},
                                  {"ratio", kTrialRatio},
                                  {"seconds", kTrial_s},
                                  {"left_out", report.left_out},
                                  {"with_border", report.with_border},
                                  {"standing_bodies", report.standing},
                                  {"collapsed", report.collapsed()},
                                  {"still_fallen", report.still_fallen()},
                                  {"overlapping", report.overlapping()},
                                  {"by_chance", report.by_chance()},
                                  {"gain_energy", report.gain_energy()},
                                  {"noted", noted},
                                  {"worst", worst}},
                     2);
}

}  // namespace tactus::hard_cases
