// The device of the bench: the whole firmware on simulated mechanics, behind a link of the kernel's.
//
//   bench_device LINK [OPTION VALUE]...     LINK: usb, can:IFACE, can-fd:IFACE
//   --scene FILE   whose device and hand it has    --rate HZ         control periods a second, default 1000
//   --control FIFO commands, a line each           --stop-line N     of --gpio-chip NAME: the e-stop
//   --priority N   SCHED_FIFO, default 60          --serial TEXT     of the USB device
//   --hand still   rests at the path's start
// Commands: NAME N of a LinkFaults member sets it for N frames; `plug`, `unplug`, `halt_states`, `halt_commands`
// (USB); `buttons N`; `motor-bus 0|1`; `jump COUNTS`: of axis 0, for one reading; `told_fault N`: all states tell BRAKE
// and that fault, until 0; `hand restart`; `restart N` ends the device's program for N periods, motors off, and begins
// it again, as `serial TEXT`, `class N`, `period_us N` made it before; `read REGISTER`, `write REGISTER VALUE`,
// `execute REGISTER VALUE` as another program would, answered by `answered status=N value=N`; `report` prints the truth
// so far; `quit`. What happens is told as lines on standard output, see simulated_board.h.
#include <cstdlib>
#include <cstring>
#include <map>
#include <string_view>
#include <thread>

#include "firmware/boards/linux/linux_program.h"
#include "firmware/boards/linux_can/can_device_link.h"
#include "firmware/boards/linux_usb/usb_gadget_link.h"
#include "tests/vm/bench_parts.h"
#include "tests/vm/hostile_link.h"
#include "tests/vm/simulated_board.h"

namespace tactus::vm {
namespace {

constexpr int kHaltPriority = 98;

struct Options {
  std::string link, scene, control, serial{"BENCH-1"}, gpio_chip{"gpiochip0"};
  unsigned rate_Hz{1000};
  int stop_line{-1}, priority{60};
  bool still{false};
};

Options read_options(int argc, char** argv) {
  if (argc < 2) fail("no link; accepted: usb, can:IFACE, can-fd:IFACE");
  Options options;
  options.link = argv[1];
  read_pairs(argc, argv, 2,
             {{"--scene", into(options.scene)},
              {"--control", into(options.control)},
              {"--serial", into(options.serial)},
              {"--gpio-chip", into(options.gpio_chip)},
              {"--rate", into(options.rate_Hz)},
              {"--hand", [&](const char* value) { options.still = std::string_view(value) == "still"; }},
              {"--stop-line", into(options.stop_line)},
              {"--priority", into(options.priority)}});
  if (options.rate_Hz < 1 || options.rate_Hz > 10'000) fail("--rate: accepted: 1 to 10000");
  return options;
}

// What the device's program begins with when it is restarted, and when that is.
struct Restart {
  firmware::Identity identity;
  firmware::Config config;
  std::uint64_t off_periods{0};  // until then; 0: it runs
};

// One request to the registers, given the text behind the operation's name.
void serve(firmware::Device& device, firmware::Operation operation, const char* text) {
  firmware::ServiceMessage request;
  request.operation = operation;
  char* end = nullptr;
  request.address = static_cast<std::uint16_t>(std::strtoul(text, &end, 0));
  request.value = static_cast<std::uint32_t>(std::strtoul(end, nullptr, 0));
  const firmware::ServiceMessage reply = device.serve(request);
  std::printf("answered status=%u value=%u\n", static_cast<unsigned>(reply.status), reply.value);
}

template <class Link>
bool obey(const std::string& line, HostileLink<Link>& link, Link& true_link, SimulatedBoard& board,
          firmware::Device& device, Restart& restart) {
  const std::size_t space = std::min(line.find(' '), line.size());
  const std::string name = line.substr(0, space);
  const std::uint64_t value = std::strtoull(line.c_str() + space, nullptr, 10);
  LinkFaults& f = link.faults;
  const std::map<std::string, std::uint64_t*> faults{{"lost_states", &f.lost_states},
                                                     {"corrupt_states", &f.corrupt_states},
                                                     {"repeated_states", &f.repeated_states},
                                                     {"wild_states", &f.wild_states},
                                                     {"odd_sizes", &f.odd_sizes},
                                                     {"silence", &f.silence},
                                                     {"lost_commands", &f.lost_commands},
                                                     {"corrupt_commands", &f.corrupt_commands},
                                                     {"repeated_commands", &f.repeated_commands},
                                                     {"idle_commands", &f.idle_commands},
                                                     {"old_commands", &f.old_commands},
                                                     {"broken_followers", &f.broken_followers},
                                                     {"nan_followers", &f.nan_followers},
                                                     {"babble", &f.babble},
                                                     {"told_fault", &f.told_fault}};
  if (const auto fault = faults.find(name); fault != faults.end()) {
    *fault->second = value;
  } else if (name == "buttons") {
    board.buttons = static_cast<std::uint8_t>(value);
  } else if (name == "motor-bus") {
    board.motor_bus_ok = value != 0;
  } else if (name == "jump") {
    board.jump = static_cast<std::int32_t>(value);
  } else if (name == "hand") {
    board.restart_hand();
  } else if (name == "restart") {
    restart.off_periods = value;
  } else if (name == "serial") {
    restart.identity = firmware::make_identity(restart.identity.device_class, line.substr(space + 1));
  } else if (name == "class") {
    restart.identity.device_class = static_cast<firmware::MechanismClass>(value);
  } else if (name == "period_us") {
    restart.config.period_us = static_cast<std::uint32_t>(value);
  } else if (name == "read") {
    serve(device, firmware::Operation::kRead, line.c_str() + space);
  } else if (name == "write") {
    serve(device, firmware::Operation::kWrite, line.c_str() + space);
  } else if (name == "execute") {
    serve(device, firmware::Operation::kExecute, line.c_str() + space);
  } else if (name == "report") {
    std::printf(
        "report periods=%llu commands=%llu refused=%u state=%u fault=%u share=%g largest_effort=%g "
        "largest_share=%g largest_rise=%g finite=%d\n",
        static_cast<unsigned long long>(board.periods()), static_cast<unsigned long long>(link.commands()),
        device.controller().refused_frames(), static_cast<unsigned>(device.controller().state()),
        static_cast<unsigned>(device.controller().fault()), board.share(), static_cast<double>(link.largest_effort()),
        board.largest_share_seen(), board.take_largest_rise(), !link.saw_effort_not_finite());
  } else if (name == "quit") {
    return false;
  } else if constexpr (requires { true_link.unplug(); }) {
    if (name == "unplug")
      true_link.unplug();
    else if (name == "halt_states" || name == "halt_commands")
      // Above the link's own threads, which use the endpoint all the time; beside the control period, for it waits.
      std::thread([&true_link, states = name == "halt_states"] {
        (void)firmware::make_realtime(kHaltPriority, -1);
        true_link.halt(states);
      }).detach();
    else if (name == "plug") {
      if (const std::string e = true_link.plug(); !e.empty()) fail(e);
    } else
      fail("unknown command '" + line + "'");
  } else {
    fail("unknown command '" + line + "'");
  }
  std::printf("done %s\n", line.c_str());
  return true;
}

template <class Link>
int run(const Options& options, Link& true_link) {
  const sim::Scene scene = read_scene(options.scene);
  const hal::DeviceProfile* profile = hal::find_profile(scene.device.profile);
  if (profile == nullptr) fail("the scene's device profile is none");
  const std::uint32_t period_us = 1'000'000 / options.rate_Hz;
  const firmware::Config config = hal::firmware_config(*profile, period_us);
  Restart restart{firmware::make_identity(firmware::MechanismClass::kVirtuose6, options.serial), config};
  firmware::Device device(config, restart.identity);
  SimulatedBoard board(*profile, hand_of(scene, options.still), config);
  if (options.stop_line >= 0)
    if (const std::string e = board.stop_line.open(options.gpio_chip, static_cast<unsigned>(options.stop_line));
        !e.empty())
      fail(e);
  HostileLink<Link> link(true_link, 1);
  ControlLines control(options.control);
  if (const std::string refused = firmware::make_realtime(options.priority, -1); !refused.empty()) fail(refused);
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  std::printf("ready\n");

  const std::atomic<bool>& stop = firmware::stop_on_signals();
  firmware::Pace pace(period_us);
  std::string line;
  for (bool go_on = true; go_on && !stop.load();) {
    pace.wait();
    if (restart.off_periods > 0) {
      if (--restart.off_periods == 0) device = firmware::Device(restart.config, restart.identity);
      board.drive({});
    } else {
      firmware::run_period(device, board, link);
    }
    board.tell(device);
    while (go_on && control.next(line)) go_on = obey(line, link, true_link, board, device, restart);
  }
  const firmware::PaceCounters& paced = pace.counters();
  std::printf("end periods=%llu skipped=%llu max_late_us=%lld\n", static_cast<unsigned long long>(paced.periods),
              static_cast<unsigned long long>(paced.skipped), static_cast<long long>(paced.max_late_ns / 1000));
  return 0;
}

int run_can(const Options& options, const std::string& interface, bool fd) {
  firmware::CanDeviceLink link;
  const firmware::CanOpenError error = link.open({interface.c_str(), 1, fd});
  if (error.step != firmware::CanOpenError::Step::kNone) fail(interface + ": " + std::strerror(error.number));
  return run(options, link);
}

int run_usb(const Options& options) {
  firmware::UsbGadgetLink link;
  firmware::GadgetOptions gadget;
  gadget.serial = options.serial;
  if (const std::string error = link.open(gadget, options.priority + 1); !error.empty()) fail(error);
  return run(options, link);
}

}  // namespace
}  // namespace tactus::vm

int main(int argc, char** argv) {
  const tactus::vm::Options options = tactus::vm::read_options(argc, argv);
  if (options.link == "usb") return tactus::vm::run_usb(options);
  if (options.link.starts_with("can:")) return tactus::vm::run_can(options, options.link.substr(4), false);
  if (options.link.starts_with("can-fd:")) return tactus::vm::run_can(options, options.link.substr(7), true);
  tactus::vm::fail("link '" + options.link + "' is none; accepted: usb, can:IFACE, can-fd:IFACE");
}
