// How `tactus experiment energy-loss` and `couplings` are divided for several processes, and joined again: a part is
// the windows of one scene with one cap on members, or the whole runs of one scene with one cap. Thread: [setup].
#pragma once

#include <string>
#include <vector>

#include "rt/base/result.h"
#include "tools/experiment/coupling/coupling_study.h"

namespace tactus::tools {

struct CouplingOptions;

std::size_t coupling_parts(const CouplingOptions& options, const experiment::StudyRequest& request);
// `part`: below coupling_parts(), those of windows first.
Result<experiment::StudyReport> run_coupling_part(const CouplingOptions& options, experiment::StudyRequest request,
                                                  std::size_t part);

// All of it, by the workers or in this process: the same rows in the same order. `arguments`: of this program, that
// give the same figures. Error, one line: a scene cannot be loaded, or a part failed.
Result<experiment::StudyReport> run_couplings_elsewhere(const CouplingOptions& options,
                                                        const experiment::StudyRequest& request,
                                                        const std::vector<std::string>& arguments);
Result<experiment::StudyReport> run_couplings_here(const CouplingOptions& options, experiment::StudyRequest request);

}  // namespace tactus::tools
