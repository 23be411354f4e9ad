#include "tools/experiment/peers.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "tools/experiment/allocation_count.h"
#include "tools/experiment/statistics.h"
#include "tools/experiment/timing.h"

namespace tactus::experiment {
namespace {

constexpr std::uint32_t kWarmUpSteps = 2;  // of a block, not timed

// Blocks of about equal duration for small and large worlds.
std::uint32_t block_of(const BoxScene& scene) { return scene.cubes.size() < 500 ? 50 : 10; }

// Results of one engine in all runs of a scene.
struct Record {
  std::vector<std::vector<double>> us;  // by run, by step
  std::uint64_t allocations{0}, steps{0};
  Measurement sum;
  double samples{0};
  QualitySampler quality;
  std::string settings, failure;

  explicit Record(const BoxScene& scene) : quality(scene) {}
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
  record.samples += 1;
  record.quality.sample(engine);
}

void run_once(const BoxScene& scene, std::span<const EngineKind> kinds, EngineOptions options,
              const std::function<void(std::string)>& say, std::vector<Record>& records) {
  std::vector<std::unique_ptr<Engine>> engines;
  const auto settle_steps = static_cast<std::uint32_t>(std::lround(scene.settle_s / scene.step_s));
  for (const EngineKind& kind : kinds) {
    say(fmt::format("{} settles", kind.name));
    options.tuned = kind.tuned;
    options.iterations = kind.iterations;
    engines.push_back(kind.make(scene, options));
    for (std::uint32_t i = 0; i < settle_steps; ++i) engines.back()->step();
  }
  for (std::size_t e = 0; e < engines.size(); ++e) {
    records[e].us.emplace_back();
    records[e].quality.start(*engines[e]);
  }
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
  row.scene = scene.name;
  row.engine = kind.name;
  row.settings = record.settings;
  row.failure = record.failure;
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
  }
  row.quality = record.quality.result();
  row.missed_gate = missed_gate(row.quality);
  if (record.steps > 0)
    row.allocations_per_step = static_cast<double>(record.allocations) / static_cast<double>(record.steps);
  return row;
}

}  // namespace

void compare(std::span<PeersRow> rows) noexcept {
  double bullet_us = 0, best_us = 0;
  for (const PeersRow& row : rows) {
    if (!row.is_compared() || row.engine == "tactus") continue;
    if (row.engine == "bullet") bullet_us = row.median_us;
    if (!(best_us > 0) || row.median_us < best_us) best_us = row.median_us;
  }
  for (PeersRow& row : rows) {
    if (!row.is_compared()) continue;
    if (bullet_us > 0) row.ratio_to_bullet = row.median_us / bullet_us;
    if (best_us > 0) row.ratio_to_best_peer = row.median_us / best_us;
  }
}

std::vector<PeersRow> run_peers(const PeersRequest& request, const Progress& progress) {
  settle_on_core();
  std::vector<PeersRow> rows;
  for (const BoxScene& scene : request.scenes) {
    std::vector<EngineKind> engines;
    std::copy_if(request.engines.begin(), request.engines.end(), std::back_inserter(engines),
                 [&](const EngineKind& kind) { return kind.takes(scene); });
    std::vector<Record> records;
    records.reserve(engines.size());
    while (records.size() < engines.size()) records.emplace_back(scene);
    for (unsigned run = 0; run < request.runs; ++run)
      run_once(
          scene, engines, request.options,
          [&](const std::string& doing) {
            if (progress) progress(fmt::format("{}, run {} of {}: {}", scene.name, run + 1, request.runs, doing));
          },
          records);
    const std::size_t first = rows.size();
    for (std::size_t e = 0; e < records.size(); ++e) {
      rows.push_back(row_of(scene, engines[e], records[e]));
      if (scene.terrain) rows.back().slide = slide_error(engines[e], request.options);
    }
    compare(std::span(rows).subspan(first));
  }
  return rows;
}

}  // namespace tactus::experiment
