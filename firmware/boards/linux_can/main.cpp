// tactus_device_can: the device's program on a Linux board with a CAN interface.
#include <charconv>
#include <cstdio>
#include <cstring>
#include <fstream>

#include "firmware/boards/linux/linux_io.h"
#include "firmware/boards/linux/linux_program.h"
#include "firmware/boards/linux/linux_storage.h"
#include "firmware/boards/linux_can/can_device_link.h"

using namespace tactus::firmware;

namespace {

constexpr const char* kPurpose =
    "A force-feedback device on a CAN interface that is up. With restart-ms set on the interface it comes back from\n"
    "bus-off by itself.";

struct BoardOptions {
  std::string interface { "can0" }, node, format{"auto"}, serial;
};

int fail(const std::string& error, int status = 3) {
  std::fprintf(stderr, "tactus_device_can: %s\n", error.c_str());
  return status;
}

// The interface's MTU, bytes; 0: no such interface.
unsigned mtu_of(const std::string& interface) {
  std::ifstream file("/sys/class/net/" + interface + "/mtu");
  unsigned mtu = 0;
  return file >> mtu ? mtu : 0;
}

// Returns the error; empty: none. The node is 0 if it is not given.
std::string choose(const BoardOptions& board, CanDeviceOptions& can) {
  can.interface = board.interface.c_str();
  can.node = 0;
  const char* const end = board.node.data() + board.node.size();
  const auto [stopped, error] = std::from_chars(board.node.data(), end, can.node);
  if (!board.node.empty() && (error != std::errc() || stopped != end || can.node < 1 || can.node > kMaxCanNode))
    return "--node: '" + board.node + "'; accepted: 1 to 127";
  if (board.format != "auto" && board.format != "classic" && board.format != "fd")
    return "--format: '" + board.format + "'; accepted: auto, classic, fd";
  if (board.serial.size() > kSerialSize) return "--serial: '" + board.serial + "'; accepted: at most 16 characters";
  can.fd = board.format == "fd" || (board.format == "auto" && mtu_of(board.interface) >= CANFD_MTU);
  return "";
}

std::string message_of(const CanOpenError& error, const std::string& interface) {
  const std::string reason = std::strerror(error.number);
  if (error.step == CanOpenError::Step::kSocket) return "no CAN sockets (" + reason + "); as root: modprobe can_raw";
  if (error.step == CanOpenError::Step::kName) return "no interface '" + interface + "'; ip link shows what there is";
  return interface + ": " + reason;
}

void report(const CanDeviceCounters& link, const PaceCounters& pace, std::uint64_t failures) {
  const auto line = [](const char* name, std::uint64_t value) {
    std::printf("%-22s %llu\n", name, static_cast<unsigned long long>(value));
  };
  line("periods", pace.periods);
  line("periods skipped", pace.skipped);
  line("i/o failures", failures);
  line("states sent", link.states);
  line("states not sent", link.send_failed);
  line("commands", link.commands);
  line("commands superseded", link.superseded);
  line("commands incomplete", link.incomplete);
  line("malformed frames", link.malformed);
  line("lost frames", link.lost);
  line("arbitration lost", link.arbitration_lost);
  line("error passive", link.error_passive);
  line("bus-off", link.bus_off);
  line("interface down", link.interface_down);
}

int run(const ProgramOptions& options, const BoardOptions& board, CanDeviceOptions can,
        const MechanicsDescription& description) {
  const std::atomic<bool>& stop = stop_on_signals();
  LinuxMechanics mechanics;
  if (const std::string error = mechanics.open(description); !error.empty()) return fail(error);
  FileStorage storage;
  if (const std::string error = storage.open(options.state); !error.empty()) return fail(error);
  DeviceConfig config;
  config.control = description.control;
  config.control.period_us = options.period_us;
  Device device(config, make_identity(description.device_class, board.serial));
  if (!restore_configuration(device, storage))
    std::fprintf(stderr, "%s holds no configuration of this firmware: starting with the file's\n",
                 options.state.c_str());
  if (can.node == 0) can.node = static_cast<std::uint8_t>(device.config().bus.can_node_id);

  CanDeviceLink link;
  if (const CanOpenError error = link.open(can); error.step != CanOpenError::Step::kNone)
    return fail(message_of(error, board.interface));
  std::printf("node %u on %s, %s, %u us\n", can.node, can.interface, can.fd ? "CAN FD" : "classic CAN",
              options.period_us);
  std::fflush(stdout);
  const PaceCounters pace = run_board(options, stop, device, mechanics, link, storage);
  report(link.counters(), pace, mechanics.failures());
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  ProgramOptions options;
  BoardOptions board;
  // Name, value, meaning, target.
  const BoardOption board_options[] = {
      {"interface", "NAME", "CAN interface; can0 if not given", &board.interface},
      {"node", "N", "node id, 1 to 127; the stored one, or 1, if not given", &board.node},
      {"format", "WHICH", "classic, fd or auto (fd where the interface takes it); auto if not given", &board.format},
      {"serial", "TEXT", "this device's own serial number, at most 16 characters", &board.serial},
  };
  const ParsedArguments parsed = parse_arguments(argc, argv, kPurpose, board_options, options);
  if (!parsed.run) {
    std::fprintf(parsed.status == 0 ? stdout : stderr, "%s\n", parsed.text.c_str());
    return parsed.status;
  }
  CanDeviceOptions can;
  if (const std::string wrong = choose(board, can); !wrong.empty()) return fail(wrong, 2);
  // Otherwise the socket would open but no state could be sent.
  if (const unsigned mtu = mtu_of(board.interface); can.fd && mtu > 0 && mtu < CANFD_MTU)
    return fail(board.interface +
                " takes no FD frames; set its FD bit rate ('dbitrate ... fd on'), or --format classic");
  MechanicsDescription description;
  if (const std::string wrong = read_mechanics(options.mechanics, description); !wrong.empty()) return fail(wrong, 2);
  return run(options, board, can, description);
}
