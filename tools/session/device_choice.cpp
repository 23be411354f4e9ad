#include "tools/session/device_choice.h"

#include <fmt/format.h>

#include <charconv>

#include "firmware/can_codec.h"

namespace tactus::session {
namespace {

constexpr std::size_t kMaxInterfaceName = 15;  // the kernel's IFNAMSIZ without its end

Status refused(const std::string& text, const std::string& what) {
  return Status::error(
      fmt::format("--device: '{}' {}; accepted: sim, usb, usb:SERIAL, can:IFACE or can:IFACE:NODE (NODE 1 to {})", text,
                  what, firmware::kMaxCanNode));
}

bool read_node(std::string_view digits, unsigned& node) {
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), node);
  return error == std::errc() && end == digits.data() + digits.size() && node >= 1 && node <= firmware::kMaxCanNode;
}

}  // namespace

Result<DeviceChoice> parse_device_choice(const std::string& text) {
  const std::size_t colon = text.find(':');
  const std::string kind = text.substr(0, colon);
  const std::string rest = colon == std::string::npos ? "" : text.substr(colon + 1);
  DeviceChoice choice;
  if (kind == "sim" && colon == std::string::npos) return choice;
  if (kind == "usb") {
    if (colon != std::string::npos && rest.empty()) return refused(text, "names no serial number after the colon");
    choice.kind = DeviceKind::kUsb;
    choice.serial = rest;
    return choice;
  }
  if (kind != "can") return refused(text, "is no device");
  choice.kind = DeviceKind::kCan;
  const std::size_t second = rest.find(':');
  choice.interface = rest.substr(0, second);
  if (choice.interface.empty()) return refused(text, "names no CAN interface");
  if (choice.interface.size() > kMaxInterfaceName) return refused(text, "names an interface of more than 15 letters");
  if (second != std::string::npos && !read_node(rest.substr(second + 1), choice.node))
    return refused(text, "has no such node id");
  return choice;
}

}  // namespace tactus::session
