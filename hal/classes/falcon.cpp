// falcon[:FILE[,GAIN]]: a Novint Falcon over USB; FILE is the firmware image that its user has, GAIN the motor values
// per N m. falcon-sim: a simulated one in the haptic thread. Both have properties of their own: a description has no
// effect.
#include <fmt/format.h>

#include <charconv>

#include "hal/device_class.h"
#include "hal/falcon/falcon_device.h"
#include "hal/falcon/falcon_usb.h"
#include "hal/falcon/simulated_falcon.h"

namespace tactus::hal {
namespace {

constexpr double kMinGain = 500, kMaxGain = 50000;

struct FalconAddress {
  std::string file;
  double gain{kFalconGain};
};

Status parse(std::string_view address, FalconAddress& parsed) {
  const std::size_t comma = address.rfind(',');
  parsed.file = address.substr(0, comma);
  if (comma == std::string_view::npos) return Status::good();
  const std::string_view digits = address.substr(comma + 1);
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), parsed.gain);
  const bool whole = error == std::errc() && end == digits.data() + digits.size();
  if (whole && parsed.gain >= kMinGain && parsed.gain <= kMaxGain) return Status::good();
  return Status::error(fmt::format("has no gain from {:g} to {:g} after the comma", kMinGain, kMaxGain));
}

Status check_address(std::string_view address) {
  FalconAddress parsed;
  return parse(address, parsed);
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
  auto port = FalconUsb::open();
  if (!port.ok()) return port.status();
  if (Status status = start_falcon(*port.value(), image); !status.ok()) return status;
  if (Status status = wait_until_homed(*port.value(), kFalconHomingWait); !status.ok()) return status;
  auto device = FalconDevice::start(std::move(port).value(), address.gain, request.period_ns);
  if (!device.ok()) return device.status();
  std::string identity = image.empty() ? "Novint Falcon, its firmware was running"
                                       : "Novint Falcon, firmware image " + falcon_checksum(image);
  return OpenedDevice{std::make_unique<AnyDevice>(std::move(device).value()), std::move(identity), {}};
}

Result<OpenedDevice> open_simulated(const DeviceRequest& request) {
  if (request.faults.count > 0) return Status::error("--inject: falcon-sim takes no faults; accepted: with sim");
  auto device = std::make_unique<SimulatedFalcon>(request.hand, request.period_ns);
  return OpenedDevice{std::make_unique<AnyDevice>(std::move(device)), "simulated Novint Falcon", {}};
}

}  // namespace

extern const DeviceClass falcon_class, simulated_falcon_class;

const DeviceClass falcon_class{.name = "falcon",
                               .forms = "falcon, falcon:FIRMWARE, falcon:FIRMWARE,GAIN",
                               .what = "a Novint Falcon on USB, with its user's firmware image",
                               .real = true,
                               .check_address = check_address,
                               .open = open};

const DeviceClass simulated_falcon_class{.name = "falcon-sim",
                                         .forms = "falcon-sim",
                                         .what = "a simulated Novint Falcon",
                                         .check_address = check_no_address,
                                         .open = open_simulated};

}  // namespace tactus::hal
