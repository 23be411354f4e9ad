// The figures of a run in virtual time, `--figures COLUMN:HOW`: of the records of its ticks, with or without a tape.
// Thread: main; the records come from the thread that drains the recorder.
#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "tools/export/figures.h"
#include "tools/session/session.h"

namespace tactus::tools {

// Null without figures. The session must be recorded afterwards, with or without a tape, and end before the figures.
// Error, one line: as exporting::parse_figures.
Result<std::unique_ptr<exporting::Figures>> take_figures(session::Session& session,
                                                         const std::vector<std::string>& words);

// Into the run's JSON object, and as lines below its summary; nothing without figures.
void add_figures(nlohmann::json& object, const exporting::Figures* figures);
void print_figures(const exporting::Figures* figures);

}  // namespace tactus::tools
