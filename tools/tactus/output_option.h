// An option that names a file to write: a path that could not be written at the end of the work is refused when the
// command line is parsed.
//
// Thread: main, while the command line is parsed. Errors: those of exporting::check_replaced(), as CLI11 reports them.
#pragma once

#include <string>

#include "tools/export/output_file.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace tactus::tools {

// Adds the option `name` with its check; `path` is the value's place.
CLI::Option* add_output(CLI::App& command, const char* name, std::string& path, exporting::OutputKind kind,
                        const std::string& help);
// Adds the check to an option that exists. An empty value passes.
void check_output(CLI::Option& option, exporting::OutputKind kind);

}  // namespace tactus::tools
