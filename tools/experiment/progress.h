// One line on a terminal that says how far an experiment is; nothing where stderr is none. Thread: one.
#pragma once

#include <functional>
#include <string>

namespace tactus::experiment {

// Called with what is being done now; may be empty.
using Progress = std::function<void(const std::string& doing)>;

// A line on stderr that each call overwrites, and that goes with the last copy. Empty where stderr is no terminal.
Progress terminal_progress();

}  // namespace tactus::experiment
