// The subcommands of `tactus device`, one source file each. Thread: [setup].
#pragma once

#include "tools/tactus/commands.h"

namespace tactus::tools {

void add_device_ask_command(CLI::App& device, int& exit_code);
void add_device_new_command(CLI::App& device, int& exit_code);
void add_device_calibrate_command(CLI::App& device, int& exit_code);

}  // namespace tactus::tools
