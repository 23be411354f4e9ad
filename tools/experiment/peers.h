// tactus experiment peers: compares computing time of tactus, Bullet, ODE and MuJoCo on identical scenes, in one
// program.
//
// Every scene is settled, then timed by steps, in blocks that alternate between the engines, so that disturbances by
// the machine affect all equally; a block's first steps fill the caches and are not timed. Everything is run several
// times; the minimum of each step over the runs excludes interruptions. Contacts, speed and quality (quality.h) are
// sampled at the end of each block. On triangles an engine is checked against a known answer (known_slide.h), which is
// shown beside its row. A row that fails a gate is listed but not compared in time.
// Thread: one, on one core. Units in the names.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tools/experiment/engine.h"
#include "tools/experiment/known_slide.h"
#include "tools/experiment/progress.h"
#include "tools/experiment/quality.h"

namespace tactus::experiment {

struct PeersRequest {
  std::vector<BoxScene> scenes;
  std::vector<EngineKind> engines;  // all available; each gets the scenes that it takes
  EngineOptions options;            // `tuned` is taken from the kind
  unsigned runs{3};
};

struct PeersRow {
  std::string scene, engine, settings;
  double median_us{0}, p99_us{0};  // of all timed steps of all runs
  double worst_over_median{0};     // of the minimum of each step over the runs
  double contacts{0}, touching_pairs{0};
  double residual_speed_rms_m_per_s{0};
  Quality quality;
  std::optional<SlideError> slide;  // empty: not on triangles
  double allocations_per_step{0};
  // Ratios of medians; 0 if this row or the other is not compared, or there is no other.
  double ratio_to_bullet{0};     // to Bullet at its defaults
  double ratio_to_best_peer{0};  // to the fastest compared peer, over all its settings
  std::string failure;           // why the row is invalid; empty: valid
  std::string missed_gate;       // of its quality; empty: passed all

  bool is_compared() const noexcept { return failure.empty() && missed_gate.empty() && median_us > 0; }
};

// Fills the ratios of the rows of one scene.
void compare(std::span<PeersRow> rows) noexcept;

std::vector<PeersRow> run_peers(const PeersRequest& request, const Progress& progress);

std::string peers_table(const std::vector<PeersRow>& rows);  // for people
std::string peers_json(const std::vector<PeersRow>& rows);   // {"rows":[...]}; null: not measured
std::string peers_csv(const std::vector<PeersRow>& rows);    // units in the header

}  // namespace tactus::experiment
