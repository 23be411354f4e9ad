#include "tools/tactus/output_option.h"

#include <CLI/CLI.hpp>

namespace tactus::tools {

void check_output(CLI::Option& option, exporting::OutputKind kind) {
  option.check([kind](const std::string& path) {
    return path.empty() ? std::string() : exporting::check_replaced(path, kind).message();
  });
}

CLI::Option* add_output(CLI::App& command, const char* name, std::string& path, exporting::OutputKind kind,
                        const std::string& help) {
  CLI::Option* option = command.add_option(name, path, help);
  check_output(*option, kind);
  return option;
}

}  // namespace tactus::tools
