// Writes the page of an experiment: one HTML file with its figures, drawn by tools/experiment_page with matplotlib,
// and with date, version, machine and command.
// Thread: one; runs another program and waits for it. Bound: none; called once, at the end of an experiment.
#pragma once

#include <string>

#include "rt/base/result.h"

namespace tactus::experiment {

// Error, as of write_page: what drawing a page needs is not there. For before the experiment.
Status check_page_writer();

// `json`: output of the experiment; `command`: command line that produced it. Error, one line: what is missing and how
// to install it.
Status write_page(const std::string& experiment, const std::string& json, const std::string& command,
                  const std::string& path);

}  // namespace tactus::experiment
