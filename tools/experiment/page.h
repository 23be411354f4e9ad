// The page of an experiment: one HTML file with its figures, drawn by tools/experiment_page with matplotlib,
// and with date, version, machine and command.
// Thread: one; runs another program and waits for it. Bound: none that matters, it is the end of an experiment.
#pragma once

#include <string>

#include "rt/base/result.h"

namespace tactus::experiment {

// `json`: what the experiment prints, `command`: what a person types to get it. An error is one line: what is missing
// and how to get it.
Status write_page(const std::string& experiment, const std::string& json, const std::string& command,
                  const std::string& path);

}  // namespace tactus::experiment
