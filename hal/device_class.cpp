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

namespace {

std::string names_where(bool (*chosen)(const DeviceClass&)) {
  std::vector<std::string_view> names;
  for (const DeviceClass* device_class : device_classes())
    if (chosen(*device_class)) names.push_back(device_class->name);
  const std::string_view last = names.back();
  names.pop_back();
  return names.empty() ? std::string(last) : fmt::format("{} or {}", fmt::join(names, ", "), last);
}

}  // namespace

std::string simulated_devices() {
  return names_where([](const DeviceClass& device_class) { return !device_class.real; });
}

std::string described_by_files() {
  return names_where([](const DeviceClass& device_class) { return !device_class.describes_itself; });
}

Result<DeviceChoice> choose_device(const std::string& text) {
  const std::size_t colon = text.find(':');
  const DeviceClass* device_class = find_device_class(std::string_view(text).substr(0, colon));
  Status status = Status::good();
  std::string address;
  if (device_class == nullptr) {
    status = Status::error("is no device");
  } else if (colon != std::string::npos && colon + 1 == text.size()) {
    status = Status::error("names nothing after the colon");
  } else {
    if (colon != std::string::npos) address = text.substr(colon + 1);
    status = device_class->check_address(address);
  }
  if (!status.ok())
    return Status::error(fmt::format("--device: '{}' {}; accepted: {}", text, status.message(), accepted_devices()));
  return DeviceChoice{device_class, std::move(address)};
}

Status check_no_address(std::string_view address) {
  return address.empty() ? Status::good() : Status::error("takes nothing after the name");
}

}  // namespace tactus::hal
