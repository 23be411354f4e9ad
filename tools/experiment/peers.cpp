#include "tools/experiment/peers.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "tools/experiment/allocation_count.h"
#include "tools/experiment/statistics.h"
#include "tools/experiment/timing.h"

namespace tactus::experiment {
namespace {

constexpr std::uint32_t kWarmUpSteps = 2;  // of a block, not timed

// About as long for a small world as for a large one.
std::uint32_t block_of(const BoxScene& scene) { return scene.cubes.size() < 500 ? 50 : 10; }

// What one engine did in all runs of a scene.
struct Record {
  std::vector<std::vector<double>> us;  // by run, by step
  std::uint64_t allocations{0}, steps{0};
  Measurement sum;  // but the overlap, which is the largest
  double samples{0};
  std::string settings, failure;
};

void time_block(Engine& engine, std::uint32_t steps, Record& record) {
  for (std::uint32_t i = 0; i < kWarmUpSteps; ++i) engine.step();
  for (std::uint32_t i = 0; i < steps; ++i) {
    const std::uint64_t allocations = allocation_count();
    const double start = thread_time_us();
    engine.step();
    const double end = thread_time_us();
    record.allocations += allocation_count() - allocations;
    record.us.back().push_back(end - start);
  }
  record.steps += steps;
  const Measurement m = engine.measure();
  record.sum.contacts += m.contacts;
  record.sum.touching_pairs += m.touching_pairs;
  record.sum.residual_speed_m_per_s += m.residual_speed_m_per_s * m.residual_speed_m_per_s;
  record.sum.penetration_m = std::max(record.sum.penetration_m, m.penetration_m);
  record.samples += 1;
}

void run_once(const BoxScene& scene, const PeersRequest& request, const std::function<void(std::string)>& say,
              std::vector<Record>& records) {
  std::vector<std::unique_ptr<Engine>> engines;
  const auto settle_steps = static_cast<std::uint32_t>(std::lround(scene.settle_s / scene.step_s));
  for (const EngineKind& kind : request.engines) {
    say(fmt::format("{} settles", kind.name));
    EngineOptions options = request.options;
    options.tuned = kind.tuned;
    engines.push_back(kind.make(scene, options));
    for (std::uint32_t i = 0; i < settle_steps; ++i) engines.back()->step();
  }
  for (Record& record : records) record.us.emplace_back();
  const std::uint32_t block = block_of(scene);
  for (std::uint32_t done = 0; done < scene.timed_steps; done += block) {
    say(fmt::format("{} of {} steps timed", done, scene.timed_steps));
    for (std::size_t e = 0; e < engines.size(); ++e)
      time_block(*engines[e], std::min(block, scene.timed_steps - done), records[e]);
  }
  for (std::size_t e = 0; e < engines.size(); ++e) {
    records[e].settings = engines[e]->settings();
    records[e].failure = engines[e]->failure();
  }
}

PeersRow row_of(const BoxScene& scene, const EngineKind& kind, const Record& record) {
  PeersRow row;
  row.scene = scene.name, row.engine = kind.name, row.settings = record.settings, row.failure = record.failure;
  std::vector<double> all;
  for (const auto& run : record.us) all.insert(all.end(), run.begin(), run.end());
  const std::vector<double> least = minimum_by_step(record.us);
  row.median_us = median(all);
  row.p99_us = quantile(all, 0.99);
  const double middle = median(least);
  row.worst_over_median = middle > 0 ? *std::max_element(least.begin(), least.end()) / middle : 0;
  if (record.samples > 0) {
    row.contacts = record.sum.contacts / record.samples;
    row.touching_pairs = record.sum.touching_pairs / record.samples;
    row.residual_speed_rms_m_per_s = std::sqrt(record.sum.residual_speed_m_per_s / record.samples);
    row.penetration_max_m = record.sum.penetration_m;
  }
  if (record.steps > 0)
    row.allocations_per_step = static_cast<double>(record.allocations) / static_cast<double>(record.steps);
  return row;
}

}  // namespace

std::vector<PeersRow> run_peers(const PeersRequest& request, const Progress& progress) {
  settle_on_core();
  std::vector<PeersRow> rows;
  for (const BoxScene& scene : request.scenes) {
    std::vector<Record> records(request.engines.size());
    for (unsigned run = 0; run < request.runs; ++run)
      run_once(
          scene, request,
          [&](const std::string& doing) {
            if (progress) progress(fmt::format("{}, run {} of {}: {}", scene.name, run + 1, request.runs, doing));
          },
          records);
    const std::size_t first = rows.size();
    for (std::size_t e = 0; e < records.size(); ++e) rows.push_back(row_of(scene, request.engines[e], records[e]));
    const auto bullet = std::find_if(rows.begin() + static_cast<std::ptrdiff_t>(first), rows.end(),
                                     [](const PeersRow& row) { return row.engine == "bullet"; });
    if (bullet == rows.end() || !(bullet->median_us > 0)) continue;
    const double base = bullet->median_us;
    for (std::size_t i = first; i < rows.size(); ++i) rows[i].ratio_to_bullet = rows[i].median_us / base;
  }
  return rows;
}

std::string peers_table(const std::vector<PeersRow>& rows) {
  std::string text =
      fmt::format("{:<15} {:<13} {:>10} {:>10} {:>8} {:>9} {:>9} {:>10} {:>9} {:>8} {:>7}\n", "scene", "engine",
                  "median us", "p99 us", "worst/md", "contacts", "touching", "rms m/s", "deepest m", "allocs", "ratio");
  std::string scene, notes;
  for (const PeersRow& row : rows) {
    text +=
        fmt::format("{:<15} {:<13} {:>10.1f} {:>10.1f} {:>8.2f} {:>9.0f} {:>9.0f} {:>10.1e} {:>9.1e} {:>8} {:>7}\n",
                    row.scene == scene ? "" : row.scene, row.engine, row.median_us, row.p99_us, row.worst_over_median,
                    row.contacts, row.touching_pairs, row.residual_speed_rms_m_per_s, row.penetration_max_m,
                    allocations_are_counted() ? fmt::format("{:.1f}", row.allocations_per_step) : "-",
                    row.ratio_to_bullet > 0 ? fmt::format("{:.2f}", row.ratio_to_bullet) : "-");
    if (row.scene != scene) notes += fmt::format("{}\n", row.scene);
    notes += fmt::format("  {:<13} {}\n", row.engine, row.settings);
    if (!row.failure.empty()) notes += fmt::format("  {:<13} DOES NOT COUNT: {}\n", "", row.failure);
    scene = row.scene;
  }
  return text +
         "\nCPU time of one thread; worst/md: the worst step over the median one, each the least of its runs; "
         "allocs: per step;\nratio: to the median of Bullet at its defaults.\n\n" +
         notes;
}

std::string peers_json(const std::vector<PeersRow>& rows) {
  using nlohmann::ordered_json;
  ordered_json list = ordered_json::array();
  for (const PeersRow& row : rows)
    list.push_back(
        {{"scene", row.scene},
         {"engine", row.engine},
         {"median_us", row.median_us},
         {"p99_us", row.p99_us},
         {"worst_over_median", row.worst_over_median},
         {"contacts", row.contacts},
         {"touching_pairs", row.touching_pairs},
         {"residual_speed_rms_m_per_s", row.residual_speed_rms_m_per_s},
         {"penetration_max_m", row.penetration_max_m},
         {"allocations_per_step",
          allocations_are_counted() ? ordered_json(row.allocations_per_step) : ordered_json(nullptr)},
         {"ratio_to_bullet", row.ratio_to_bullet > 0 ? ordered_json(row.ratio_to_bullet) : ordered_json(nullptr)},
         {"settings", row.settings},
         {"failure", row.failure}});
  return ordered_json{{"rows", list}}.dump(2);
}

}  // namespace tactus::experiment
