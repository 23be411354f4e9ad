// dhd[:FOLDER[,SERIAL]]: a Force Dimension device through the maker's library that its user has installed. Its
// properties are its own: a description has no effect.
#include <fmt/format.h>

#include <charconv>

#include "hal/classes/of_library.h"
#include "hal/device_class.h"
#include "hal/sdk/dhd_port.h"
#include "hal/sdk/sdk_device.h"
#include "hal/sdk/within.h"

namespace tactus::hal {
namespace {

// A library that does not return has hung: the device is unplugged, or its driver waits for it.
constexpr std::chrono::seconds kOpening{10};

struct DhdAddress {
  std::string folder;
  std::optional<unsigned> serial;
};

// Parses FOLDER[,SERIAL]. Text after the last comma is a serial number only if it is a number; otherwise it belongs to
// the folder's name.
DhdAddress parse(std::string_view address) {
  const std::size_t comma = address.rfind(',');
  if (comma == std::string_view::npos) return {std::string(address), {}};
  const std::string_view digits = address.substr(comma + 1);
  unsigned serial = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), serial);
  if (error != std::errc() || end != digits.data() + digits.size()) return {std::string(address), {}};
  return {std::string(address.substr(0, comma)), serial};
}

Status check_address(std::string_view address) {
  return address.ends_with(',') ? Status::error("names no serial number after the comma") : Status::good();
}

std::vector<std::string> takes(std::string_view address, const DeviceDescription&) {
  const auto serial = parse(address).serial;
  return {serial ? fmt::format("serial {}", *serial) : std::string()};
}

Result<std::string> look(std::string_view address) {
  const auto library = DhdLibrary::load(parse(address).folder);
  if (!library.ok()) return library.status();
  return "Force Dimension's library is " + library.value()->path();
}

Result<OpenedDevice> open_with(std::unique_ptr<DhdLibrary> library, std::optional<unsigned> serial,
                               std::int64_t period_ns) {
  auto port = DhdPort::open(std::move(library), serial);
  if (!port.ok()) return port.status();
  std::string identity = port.value()->identity();
  auto device = SdkDevice::start(std::move(port).value(), period_ns);
  if (!device.ok()) return device.status();
  return opened_library(std::move(device).value(), std::move(identity));
}

Result<OpenedDevice> open(const DeviceRequest& request) {
  const DhdAddress address = parse(request.address);
  auto library = DhdLibrary::load(address.folder);
  if (!library.ok()) return library.status();
  auto opening = std::make_shared<std::unique_ptr<DhdLibrary>>(std::move(library).value());
  return within<OpenedDevice>(kOpening, "the maker's library does not return from opening the device",
                              [opening, serial = address.serial, period_ns = request.period_ns] {
                                return open_with(std::move(*opening), serial, period_ns);
                              });
}

}  // namespace

extern const DeviceClass dhd_class;
const DeviceClass dhd_class{.name = "dhd",
                            .forms = "dhd, dhd:FOLDER, dhd:FOLDER,SERIAL",
                            .what = "a Force Dimension device, through the maker's library",
                            .real = true,
                            .check_address = check_address,
                            .open = open,
                            .takes = takes,
                            .each_its_own = "such as dhd:FOLDER,1234 and dhd:FOLDER,1235",
                            .describes_itself = true,
                            .look = look};

}  // namespace tactus::hal
