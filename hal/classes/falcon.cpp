// falcon[:[FILE[,GAIN]][@PORT]]: a Novint Falcon over USB; FILE is the firmware image that its user has, GAIN the motor
// values per N m, PORT the USB port that it is plugged into: it has no serial number to choose by. falcon-sim[:GAIN]: a
// simulated one in the haptic thread, whose motors have kFalconGain. Both have properties of their own: a description
// has no effect.
#include <fmt/format.h>

#include <charconv>

#include "hal/device_class.h"
#include "hal/falcon/falcon_device.h"
#include "hal/falcon/falcon_usb.h"
#include "hal/falcon/simulated_falcon.h"
#include "hal/usb/usb_port.h"

namespace tactus::hal {
namespace {

constexpr double kMinGain = 500, kMaxGain = 50000;

struct FalconAddress {
  std::string file;
  double gain{kFalconGain};
  std::string port;  // empty: the only one
};

Status parse_gain(std::string_view digits, double& gain) {
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), gain);
  const bool whole = error == std::errc() && end == digits.data() + digits.size();
  if (whole && gain >= kMinGain && gain <= kMaxGain) return Status::good();
  return Status::error(fmt::format("has no gain from {:g} to {:g}", kMinGain, kMaxGain));
}

// Takes the port from the end; an @ in the name of a folder is none.
Status take_port(std::string_view& address, std::string& port) {
  const std::size_t at = address.rfind('@');
  if (at == std::string_view::npos || address.find('/', at) != std::string_view::npos) return Status::good();
  port = address.substr(at + 1);
  address = address.substr(0, at);
  if (is_usb_port(port)) return Status::good();
  return Status::error(fmt::format("has '{}' behind the @, which is no USB port such as 1-2 or 1-2.4", port));
}

Status parse(std::string_view address, FalconAddress& parsed) {
  if (Status status = take_port(address, parsed.port); !status.ok()) return status;
  const std::size_t comma = address.rfind(',');
  parsed.file = address.substr(0, comma);
  if (comma == std::string_view::npos) return Status::good();
  return parse_gain(address.substr(comma + 1), parsed.gain);
}

Status check_address(std::string_view address) {
  FalconAddress parsed;
  return parse(address, parsed);
}

double gain_of(std::string_view address) {
  FalconAddress parsed;
  return parse(address, parsed).ok() ? parsed.gain : kFalconGain;
}

std::string with_gain(std::string_view address, double gain_per_Nm) {
  FalconAddress parsed;
  (void)parse(address, parsed);
  return fmt::format("{},{:.0f}{}{}", parsed.file, gain_per_Nm, parsed.port.empty() ? "" : "@", parsed.port);
}

std::vector<std::string> takes(std::string_view address, const DeviceDescription&) {
  FalconAddress parsed;
  (void)parse(address, parsed);
  return {parsed.port.empty() ? std::string() : "USB port " + parsed.port};
}

Result<OpenedDevice> open(const DeviceRequest& request) {
  FalconAddress address;
  if (Status status = parse(request.address, address); !status.ok()) return status;
  std::vector<std::uint8_t> image;
  if (!address.file.empty()) {
    auto loaded = load_falcon_image(address.file);
    if (!loaded.ok()) return loaded.status();
    image = std::move(loaded).value();
  }
  auto port = FalconUsb::open(address.port);
  if (!port.ok()) return port.status();
  std::string identity =
      fmt::format("Novint Falcon at USB port {}, {}", port.value()->port(),
                  image.empty() ? std::string("its firmware was running") : "firmware image " + falcon_checksum(image));
  if (Status status = start_falcon(*port.value(), image); !status.ok()) return status;
  if (Status status = wait_until_homed(*port.value(), kFalconHomingWait); !status.ok()) return status;
  auto device = FalconDevice::start(std::move(port).value(), address.gain, request.period_ns);
  if (!device.ok()) return device.status();
  OpenedDevice opened{std::make_unique<AnyDevice>(std::move(device).value()), std::move(identity)};
  opened.not_checked = {
      {"watchdog",
       "what brakes here is this program; none is known in the device, which keeps its last force when a "
       "program is killed"}};
  return opened;
}

double simulated_gain_of(std::string_view address) {
  double gain = kFalconGain;
  return address.empty() || !parse_gain(address, gain).ok() ? kFalconGain : gain;
}

Status check_simulated(std::string_view address) {
  double gain = 0;
  return address.empty() ? Status::good() : parse_gain(address, gain);
}

std::string simulated_with_gain(std::string_view, double gain_per_Nm) { return fmt::format("{:.0f}", gain_per_Nm); }

Result<OpenedDevice> open_simulated(const DeviceRequest& request) {
  if (request.faults.count > 0) return Status::error("--inject: falcon-sim takes no faults; accepted: with sim");
  auto device = std::make_unique<SimulatedFalcon>(request.hand, request.period_ns, simulated_gain_of(request.address));
  return OpenedDevice{std::make_unique<AnyDevice>(std::move(device)), "simulated Novint Falcon", {}};
}

}  // namespace

extern const DeviceClass falcon_class, simulated_falcon_class;

const DeviceClass falcon_class{
    .name = "falcon",
    .forms = "falcon, falcon:FIRMWARE, falcon:FIRMWARE,GAIN, falcon:[FIRMWARE[,GAIN]]@USB-PORT",
    .what = "a Novint Falcon on USB, with the user's firmware image",
    .real = true,
    .check_address = check_address,
    .open = open,
    .takes = takes,
    .each_its_own =
        "such as falcon:@1-2 and falcon:@1-3 by the USB ports, as it has no serial number to choose by, or falcon-sim",
    .describes_itself = true,
    .force_gain = gain_of,
    .with_force_gain = with_gain};

const DeviceClass simulated_falcon_class{.name = "falcon-sim",
                                         .forms = "falcon-sim, falcon-sim:GAIN",
                                         .what = "a simulated Novint Falcon",
                                         .check_address = check_simulated,
                                         .open = open_simulated,
                                         .describes_itself = true,
                                         .hand_by_script = true,
                                         .force_gain = simulated_gain_of,
                                         .with_force_gain = simulated_with_gain};

}  // namespace tactus::hal
