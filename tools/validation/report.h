// tactus experiment hard-cases: every case at every accuracy and step, and the stacks beside other engines.
// Thread: one. Units in the names.
#pragma once

#include <string>
#include <vector>

#include "tools/experiment/engine.h"
#include "tools/experiment/progress.h"
#include "tools/validation/hard_case.h"
#include "tools/validation/stack_spec.h"

namespace tactus::hard_cases {

struct Request {
  std::vector<const HardCase*> cases;
  std::vector<Accuracy> accuracies;
  std::vector<double> steps_s;
  std::vector<experiment::EngineKind> peers;  // that are given the stacks, beside tactus
};

struct Row {
  const HardCase* one{nullptr};
  Setting setting;
  Outcome outcome;
};

struct PeerRow {
  std::string stack, engine;
  double step_s{0};
  StackState state;
};

struct Report {
  std::vector<Row> rows;
  std::vector<PeerRow> peers;

  bool all_pass_at(Accuracy accuracy) const noexcept;
};

Report run(const Request& request, const experiment::Progress& progress);

std::string report_table(const Report& report);
// What failed, metric by metric; empty where nothing did.
std::string failures_text(const Report& report);
// {"rows": [{"case", "accuracy", "step_ms", "score", "passed", ...}], "peers": [...]}.
std::string report_json(const Report& report);
std::string report_csv(const Report& report);  // one line per metric
std::string report_svg(const Report& report);  // the scores: cases down, accuracies and steps across

}  // namespace tactus::hard_cases
