// tactus_device_usb: the device's program on a Linux board with a USB device port.
#include <algorithm>
#include <cstdio>

#include "firmware/boards/linux/linux_io.h"
#include "firmware/boards/linux/linux_program.h"
#include "firmware/boards/linux/linux_storage.h"
#include "firmware/boards/linux_usb/usb_gadget_link.h"

using namespace tactus::firmware;

namespace {

int fail(const std::string& error) {
  std::fprintf(stderr, "tactus_device_usb: %s\n", error.c_str());
  return 3;
}

int run(const ProgramOptions& options, const GadgetOptions& gadget, const MechanicsDescription& description) {
  const std::atomic<bool>& stop = stop_on_signals();
  LinuxMechanics mechanics;
  if (const std::string error = mechanics.open(description); !error.empty()) return fail(error);
  FileStorage storage;
  if (const std::string error = storage.open(options.state); !error.empty()) return fail(error);
  Config control = description.control;
  control.period_us = options.period_us;
  Device device(control, make_identity(description.device_class, gadget.serial));
  if (!restore_configuration(device, storage))
    std::fprintf(stderr, "%s holds no configuration of this firmware: starting with the file's\n",
                 options.state.c_str());
  UsbGadgetLink link;
  const int link_priority = options.priority > 0 ? std::min(options.priority + 1, 99) : 0;
  if (const std::string error = link.open(gadget, link_priority); !error.empty()) return fail(error);
  std::printf("device %s on %s, %u us\n", gadget.serial.c_str(), link.udc().c_str(), options.period_us);
  std::fflush(stdout);

  const PaceCounters pace = run_board(options, stop, device, mechanics, link, storage);
  const GadgetCounters counters = link.counters();
  std::printf(
      "%llu periods, %llu skipped, latest %lld us late; %llu commands, %llu states fetched, %llu not; "
      "%llu i/o failures\n",
      static_cast<unsigned long long>(pace.periods), static_cast<unsigned long long>(pace.skipped),
      static_cast<long long>(pace.max_late_ns / 1000), static_cast<unsigned long long>(counters.commands_received),
      static_cast<unsigned long long>(counters.states_sent),
      static_cast<unsigned long long>(counters.states_superseded),
      static_cast<unsigned long long>(mechanics.failures()));
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  ProgramOptions options;
  GadgetOptions gadget;
  // Name, value, meaning, target.
  const BoardOption board_options[] = {
      {"serial", "TEXT", "this device's own serial number, at most 16 characters", &gadget.serial},
      {"udc", "NAME", "the USB device controller, if there are several", &gadget.udc},
      {"gadget", "NAME", "the gadget's name in configfs; tactus if not given", &gadget.name},
      {"mount", "PATH", "where FunctionFS goes; /run/tactus/usb if not given", &gadget.mount},
  };
  const ParsedArguments parsed =
      parse_arguments(argc, argv, "A force-feedback device on this board's USB device port.", board_options, options);
  if (!parsed.run) {
    std::fprintf(parsed.status == 0 ? stdout : stderr, "%s\n", parsed.text.c_str());
    return parsed.status;
  }
  const bool printable =
      std::all_of(gadget.serial.begin(), gadget.serial.end(), [](char c) { return c > ' ' && c <= '~'; });
  if (gadget.serial.empty() || gadget.serial.size() > kSerialSize || !printable) {
    std::fprintf(stderr, "tactus_device_usb: --serial: '%s'; accepted: 1 to 16 ASCII characters without spaces\n",
                 gadget.serial.c_str());
    return 2;
  }
  MechanicsDescription description;
  if (const std::string error = read_mechanics(options.mechanics, description); !error.empty()) {
    std::fprintf(stderr, "tactus_device_usb: %s\n", error.c_str());
    return 2;
  }
  return run(options, gadget, description);
}
