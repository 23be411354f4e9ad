#include "hal/device_class.h"

#include <fmt/format.h>

#include "hal/device_list.h"

namespace tactus::hal {

#define TACTUS_DECLARE(name) extern const DeviceClass name##_class;
TACTUS_DEVICE_CLASSES(TACTUS_DECLARE)
#undef TACTUS_DECLARE

std::span<const DeviceClass* const> device_classes() noexcept {
#define TACTUS_LIST(name) &name##_class,
  static constexpr const DeviceClass* kClasses[] = {TACTUS_DEVICE_CLASSES(TACTUS_LIST)};
#undef TACTUS_LIST
  return kClasses;
}

const DeviceClass* find_device_class(std::string_view name) noexcept {
  for (const DeviceClass* device_class : device_classes())
    if (device_class->name == name) return device_class;
  return nullptr;
}

namespace {

std::string names_where(bool (*chosen)(const DeviceClass&)) {
  std::vector<std::string_view> names;
  for (const DeviceClass* device_class : device_classes())
    if (chosen(*device_class)) names.push_back(device_class->name);
  const std::string_view last = names.back();
  names.pop_back();
  return names.empty() ? std::string(last) : fmt::format("{} or {}", fmt::join(names, ", "), last);
}

// "sim, drives-sim, falcon-sim or example": those without hardware, which may run in virtual time.
std::string simulated_devices() {
  return names_where([](const DeviceClass& device_class) { return !device_class.real; });
}

std::string described_by_files() {
  return names_where([](const DeviceClass& device_class) { return !device_class.describes_itself; });
}

// The address in NAME:ADDRESS; empty if there is no colon.
std::string_view address_in(std::string_view text) {
  const std::size_t colon = text.find(':');
  return colon == std::string_view::npos ? std::string_view() : text.substr(colon + 1);
}

}  // namespace

std::string accepted_devices() {
  std::string text;
  for (const DeviceClass* device_class : device_classes())
    text += fmt::format("{}{}", text.empty() ? "" : ", ", device_class->forms);
  return text;
}

std::string described_devices() {
  std::string text;
  for (const DeviceClass* device_class : device_classes())
    text += fmt::format("{}{}: {}", text.empty() ? "" : "\n", device_class->forms, device_class->what);
  return text;
}

std::string device_mistake(const std::string& text) {
  const std::size_t colon = text.find(':');
  const DeviceClass* device_class = find_device_class(std::string_view(text).substr(0, colon));
  if (device_class == nullptr) return fmt::format("'{}' is no device", text);
  if (colon != std::string::npos && colon + 1 == text.size())
    return fmt::format("'{}' names nothing after the colon", text);
  const Status status = device_class->check_address(address_in(text));
  return status.ok() ? std::string() : fmt::format("'{}' {}", text, status.message());
}

Result<DeviceChoice> choose_device(const std::string& text) {
  if (const std::string mistake = device_mistake(text); !mistake.empty())
    return Status::error(fmt::format("--device: {}; accepted: {}", mistake, accepted_devices()));
  return DeviceChoice{find_device_class(std::string_view(text).substr(0, text.find(':'))),
                      std::string(address_in(text))};
}

Status check_virtual_time(const DeviceClass& device_class, const std::string& text) {
  if (!device_class.real) return Status::good();
  return Status::error(
      fmt::format("--virtual-time: {} keeps real time; accepted: with --device {}", text, simulated_devices()));
}

Status check_described(const DeviceClass& device_class, const std::string& text) {
  if (!device_class.describes_itself) return Status::good();
  return Status::error(
      fmt::format("--device-file: {} has properties of its own, and a description no effect; accepted: without it, or "
                  "with {}",
                  text, described_by_files()));
}

std::vector<std::string> takes_the_only_one(std::string_view, const DeviceDescription&) { return {std::string()}; }

Status check_no_address(std::string_view address) {
  return address.empty() ? Status::good() : Status::error("takes nothing after the name");
}

}  // namespace tactus::hal
