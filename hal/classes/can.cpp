// can:IFACE[:NODE]: a device that speaks firmware/PROTOCOL.md over CAN.
#include <fmt/format.h>

#include <charconv>

#include "firmware/can_codec.h"
#include "hal/can/can_link.h"
#include "hal/classes/on_link.h"

namespace tactus::hal {
namespace {

struct CanAddress {
  std::string_view interface;
  unsigned node{0};  // 0: the description's
};

Status parse(std::string_view address, CanAddress& parsed) {
  const std::size_t colon = address.find(':');
  parsed.interface = address.substr(0, colon);
  if (const Status status = check_can_name(parsed.interface); !status.ok()) return status;
  if (colon == std::string_view::npos) return Status::good();
  const std::string_view digits = address.substr(colon + 1);
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), parsed.node);
  const bool whole = error == std::errc() && end == digits.data() + digits.size();
  if (!whole || parsed.node < 1 || parsed.node > firmware::kMaxCanNode)
    return Status::error(fmt::format("has no such node id (1 to {})", firmware::kMaxCanNode));
  return Status::good();
}

Status check_address(std::string_view address) {
  CanAddress parsed;
  return parse(address, parsed);
}

std::vector<std::string> can_interfaces(std::string_view address) {
  return {std::string(address.substr(0, address.find(':')))};
}

std::vector<std::string> takes(std::string_view address, const DeviceDescription& description) {
  CanAddress parsed;
  (void)parse(address, parsed);
  return {fmt::format("{} node {}", parsed.interface, parsed.node != 0 ? parsed.node : description.can_node)};
}

Result<OpenedLink> open_link(const DeviceRequest& request) {
  CanAddress address;
  if (const Status status = parse(request.address, address); !status.ok()) return status;
  CanOptions options;
  options.interface = address.interface;
  options.node = static_cast<std::uint8_t>(address.node != 0 ? address.node : request.profile.description.can_node);
  options.period = std::chrono::nanoseconds(request.period_ns);
  auto link = CanLink::open(options);
  if (!link.ok()) return Status::error("--device can: " + link.message());
  std::string name = fmt::format("CAN {}, interface {}, node {}", link.value()->is_fd() ? "FD" : "classic",
                                 options.interface, options.node);
  return OpenedLink{std::make_unique<AnyLink>(std::move(link).value()), std::move(name)};
}

}  // namespace

extern const DeviceClass can_class;
const DeviceClass can_class{.name = "can",
                            .forms = "can:IFACE, can:IFACE:NODE",
                            .what = "a device with tactus' firmware or wire protocol, on classic CAN or CAN FD",
                            .real = true,
                            .check_address = check_address,
                            .open = open_over<open_link>,
                            .open_link = open_link,
                            .takes = takes,
                            .each_its_own = "such as can:can0:1 and can:can0:2, or sim",
                            .can_interfaces = can_interfaces};

}  // namespace tactus::hal
