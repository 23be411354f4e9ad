// An option that names a file to write: what would be refused at the end of the work is refused before it begins.
#pragma once

#include <string>

#include "tools/export/output_file.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace tactus::tools {

CLI::Option* add_output(CLI::App& command, const char* name, std::string& path, exporting::OutputKind kind,
                        const std::string& help);
// Checks the option's value so.
void check_output(CLI::Option& option, exporting::OutputKind kind);

}  // namespace tactus::tools
