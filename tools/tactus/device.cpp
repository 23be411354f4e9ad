// tactus device: registers, descriptions and calibration of force-feedback devices.
#include "tools/tactus/device.h"

namespace tactus::tools {

CLI::App* add_device_command(CLI::App& program, int& exit_code) {
  CLI::App* device = program.add_subcommand(
      "device", "Read and write a device's registers, write its description, calibrate an arm of drives.");
  device->footer(
      "Examples:\n  tactus device ask --device usb\n"
      "  tactus device new --kind point_arm --family damiao --out my_arm.toml\n"
      "  tactus device calibrate --device-file my_arm.toml --out my_arm.toml");
  add_device_ask_command(*device, exit_code);
  add_device_new_command(*device, exit_code);
  add_device_calibrate_command(*device, exit_code);
  return device;
}

}  // namespace tactus::tools
