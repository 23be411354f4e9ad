// tactus experiment hard-cases: every case at every accuracy and step, and the stacks compared with other engines.
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
  std::vector<experiment::EngineKind> peers;  // engines that also simulate the stacks, in addition to tactus
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
// Lists the failed metrics; empty if none failed.
std::string failures_text(const Report& report);
// {"rows": [{"case", "accuracy", "step_ms", "score", "passed", ...}], "peers": [...]}.
std::string report_json(const Report& report);
std::string report_csv(const Report& report);  // one line per metric
std::string report_svg(const Report& report);  // scores: one row per case, one column per accuracy and step

}  // namespace tactus::hard_cases
