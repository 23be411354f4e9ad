#include "hal/usb/usb_connection.h"

#include <fmt/format.h>
#include <libusb.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <utility>

#include "hal/printable.h"
#include "hal/usb/usb_port.h"

namespace tactus::hal {
namespace {

struct Interface {
  std::uint8_t number{0}, state_endpoint{0}, command_endpoint{0}, protocol{0};
};

std::string ids(const UsbSelection& selection) {
  char text[16];
  std::snprintf(text, sizeof text, "%04x:%04x", selection.vendor, selection.product);
  return text;
}

const char* speed_of(libusb_device* device) {
  switch (libusb_get_device_speed(device)) {
    case LIBUSB_SPEED_LOW:
      return "low";
    case LIBUSB_SPEED_FULL:
      return "full";
    case LIBUSB_SPEED_HIGH:
      return "high";
    case LIBUSB_SPEED_SUPER:
      return "super";
    case LIBUSB_SPEED_SUPER_PLUS:
      return "super+";
    default:
      return "unknown";
  }
}

// The tactus interface in the active configuration; protocol 0 if there is none, or if it lacks an endpoint.
Interface find_interface(libusb_device* device) {
  Interface found;
  libusb_config_descriptor* config = nullptr;
  if (libusb_get_active_config_descriptor(device, &config) != 0) return found;
  for (int i = 0; i < config->bNumInterfaces; ++i) {
    if (config->interface[i].num_altsetting < 1) continue;
    const libusb_interface_descriptor& interface = config->interface[i].altsetting[0];
    if (interface.bInterfaceClass != firmware::kUsbInterfaceClass ||
        interface.bInterfaceSubClass != firmware::kUsbInterfaceSubclass)
      continue;
    Interface candidate{.number = interface.bInterfaceNumber,
                        .state_endpoint = 0,
                        .command_endpoint = 0,
                        .protocol = interface.bInterfaceProtocol};
    for (int e = 0; e < interface.bNumEndpoints; ++e) {
      const libusb_endpoint_descriptor& endpoint = interface.endpoint[e];
      const bool interrupt =
          (endpoint.bmAttributes & LIBUSB_TRANSFER_TYPE_MASK) == LIBUSB_ENDPOINT_TRANSFER_TYPE_INTERRUPT;
      if (!interrupt || endpoint.wMaxPacketSize != firmware::kUsbPacketSize) continue;
      const bool in = (endpoint.bEndpointAddress & LIBUSB_ENDPOINT_DIR_MASK) == LIBUSB_ENDPOINT_IN;
      (in ? candidate.state_endpoint : candidate.command_endpoint) = endpoint.bEndpointAddress;
    }
    if (candidate.state_endpoint != 0 && candidate.command_endpoint != 0) found = candidate;
  }
  libusb_free_config_descriptor(config);
  return found;
}

std::string permission_cure(const UsbSelection& selection) {
  char rule[200];
  std::snprintf(rule, sizeof rule,
                "SUBSYSTEM==\"usb\", ATTR{idVendor}==\"%04x\", ATTR{idProduct}==\"%04x\", MODE=\"0660\", "
                "GROUP=\"plugdev\"",
                selection.vendor, selection.product);
  return "no permission: put this line into /etc/udev/rules.d/70-tactus.rules, join the group, plug the device in "
         "again: " +
         std::string(rule);
}

std::string interface_problem(const Interface& interface) {
  if (interface.protocol == 0) return "has no tactus interface: it is another product, or its firmware is not tactus's";
  if (interface.protocol != firmware::kProtocolVersion)
    return "speaks protocol version " + std::to_string(interface.protocol) + ", this program speaks " +
           std::to_string(firmware::kProtocolVersion) + ": bring both to the same release";
  return "";
}

// Examines one device; on success `handle` is open and owned by the caller.
UsbDeviceInfo look_at(libusb_device* device, const libusb_device_descriptor& descriptor, const UsbSelection& selection,
                      libusb_device_handle*& handle, Interface& interface) {
  UsbDeviceInfo info;
  info.port = usb_port_of(device);
  info.speed = speed_of(device);
  info.release = descriptor.bcdDevice;
  interface = find_interface(device);
  info.protocol_version = interface.protocol;
  info.problem = interface_problem(interface);
  const int error = libusb_open(device, &handle);
  if (error != 0) {
    handle = nullptr;
    info.problem = error == LIBUSB_ERROR_ACCESS      ? permission_cure(selection)
                   : error == LIBUSB_ERROR_NO_DEVICE ? "was unplugged just now: plug it in again"
                                                     : std::string("cannot be opened: ") + libusb_strerror(error);
    return info;
  }
  std::array<unsigned char, 128> serial{};
  const int length = descriptor.iSerialNumber == 0
                         ? 0
                         : libusb_get_string_descriptor_ascii(handle, descriptor.iSerialNumber, serial.data(),
                                                              static_cast<int>(serial.size()));
  if (length > 0) info.serial.assign(reinterpret_cast<const char*>(serial.data()), static_cast<std::size_t>(length));
  return info;
}

struct Candidate {
  UsbDeviceInfo info;
  Interface interface;
  libusb_device_handle* handle{nullptr};
};

// All devices of the vendor and product, opened where permitted. The caller closes the handles.
Status scan(libusb_context* context, const UsbSelection& selection, std::vector<Candidate>& candidates) {
  libusb_device** devices = nullptr;
  const ssize_t count = libusb_get_device_list(context, &devices);
  if (count < 0)
    return Status::error(std::string("cannot list USB devices: ") + libusb_strerror(static_cast<int>(count)));
  for (ssize_t i = 0; i < count; ++i) {
    libusb_device_descriptor descriptor{};
    if (libusb_get_device_descriptor(devices[i], &descriptor) != 0) continue;
    if (descriptor.idVendor != selection.vendor || descriptor.idProduct != selection.product) continue;
    Candidate candidate;
    candidate.info = look_at(devices[i], descriptor, selection, candidate.handle, candidate.interface);
    candidates.push_back(std::move(candidate));
  }
  libusb_free_device_list(devices, 1);
  std::sort(candidates.begin(), candidates.end(),
            [](const Candidate& a, const Candidate& b) { return a.info.port < b.info.port; });
  return Status::good();
}

Status init_context(libusb_context*& context) {
  const int error = libusb_init(&context);
  if (error == 0) return Status::good();
  context = nullptr;
  return Status::error(std::string("libusb does not start: ") + libusb_strerror(error));
}

std::string list(const std::vector<Candidate>& candidates) {
  std::string text;
  for (const Candidate& candidate : candidates) text += (text.empty() ? "" : "; ") + describe(candidate.info);
  return text;
}

// The candidate that the selection names, or why there is none.
Result<std::size_t> choose(const std::vector<Candidate>& candidates, const UsbSelection& selection) {
  if (candidates.empty()) return no_usb_device(selection);
  std::vector<std::size_t> matching;
  bool unreadable = false;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const Candidate& candidate = candidates[i];
    if (candidate.handle == nullptr) unreadable = true;
    if (selection.serial.empty() || (candidate.handle != nullptr && candidate.info.serial == selection.serial))
      matching.push_back(i);
  }
  if (matching.empty())
    return Status::error((unreadable ? "no readable USB device with serial " : "no USB device with serial ") +
                         printable(selection.serial) + "; there are: " + list(candidates));
  if (matching.size() > 1)
    return Status::error("several tactus devices on USB, choose one by its serial (usb:SERIAL): " + list(candidates));
  const UsbDeviceInfo& info = candidates[matching.front()].info;
  if (!info.problem.empty()) return Status::error("USB device at port " + info.port + ": " + info.problem);
  return matching.front();
}

// The kernel driver bound to an interface, from sysfs; empty if none.
std::string kernel_driver(const std::string& port, std::uint8_t interface) {
  std::error_code error;
  const std::filesystem::path link = "/sys/bus/usb/devices/" + port + ":1." + std::to_string(interface) + "/driver";
  const std::filesystem::path target = std::filesystem::read_symlink(link, error);
  return error ? "" : target.filename().string();
}

}  // namespace

Status no_usb_device(const UsbSelection& selection) {
  return Status::error("no tactus device on USB (" + ids(selection) + "): plug it in and switch it on");
}

std::string describe(const UsbDeviceInfo& info) {
  std::string text = info.serial.empty() ? "serial unknown" : "serial " + printable(info.serial);
  text += ", port " + info.port + ", " + info.speed + " speed";
  if (!info.problem.empty()) text += " (" + info.problem + ")";
  return text;
}

Result<std::vector<UsbDeviceInfo>> enumerate_usb(const UsbSelection& selection) {
  libusb_context* context = nullptr;
  if (Status status = init_context(context); !status.ok()) return status;
  std::vector<Candidate> candidates;
  const Status status = scan(context, selection, candidates);
  std::vector<UsbDeviceInfo> infos;
  for (Candidate& candidate : candidates) {
    if (candidate.handle != nullptr) libusb_close(candidate.handle);
    if (selection.serial.empty() || selection.serial == candidate.info.serial) infos.push_back(candidate.info);
  }
  libusb_exit(context);
  if (!status.ok()) return status;
  return infos;
}

Result<std::unique_ptr<UsbConnection>> UsbConnection::open(const UsbSelection& selection) {
  std::unique_ptr<UsbConnection> connection(new UsbConnection);
  if (Status status = init_context(connection->context_); !status.ok()) return status;
  if (Status status = connection->find(selection); !status.ok()) return status;
  if (Status status = connection->claim(); !status.ok()) return status;
  return connection;
}

Status UsbConnection::find(const UsbSelection& selection) {
  std::vector<Candidate> candidates;
  if (Status status = scan(context_, selection, candidates); !status.ok()) return status;
  const Result<std::size_t> chosen = choose(candidates, selection);
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    Candidate& candidate = candidates[i];
    if (chosen.ok() && chosen.value() == i) {
      handle_ = candidate.handle;
      info_ = candidate.info;
      interface_ = candidate.interface.number;
      state_endpoint_ = candidate.interface.state_endpoint;
      command_endpoint_ = candidate.interface.command_endpoint;
    } else if (candidate.handle != nullptr) {
      libusb_close(candidate.handle);
    }
  }
  return chosen.ok() ? Status::good() : chosen.status();
}

Status UsbConnection::claim() {
  const int error = libusb_claim_interface(handle_, interface_);
  const std::string device = "USB device at port " + info_.port + ": ";
  if (error == 0) {
    claimed_ = true;
    // The previous user may have left its endpoints halted.
    for (const std::uint8_t endpoint : {state_endpoint_, command_endpoint_})
      if (libusb_clear_halt(handle_, endpoint) == LIBUSB_ERROR_NO_DEVICE)
        return Status::error(device + "was unplugged just now: plug it in again");
    return Status::good();
  }
  if (error == LIBUSB_ERROR_NO_DEVICE) return Status::error(device + "was unplugged just now: plug it in again");
  if (error != LIBUSB_ERROR_BUSY) return Status::error(device + "cannot be claimed: " + libusb_strerror(error));
  const std::string driver = kernel_driver(info_.port, interface_);
  const std::string name = info_.port + ":1." + std::to_string(interface_);
  if (!driver.empty() && driver != "usbfs")
    return Status::error(device + "the kernel's driver " + driver + " has it; as root: echo " + name +
                         " > /sys/bus/usb/drivers/" + driver + "/unbind");
  return Status::error(device + "another program uses it: end that one first");
}

UsbConnection::~UsbConnection() {
  if (claimed_) libusb_release_interface(handle_, interface_);
  if (handle_ != nullptr) libusb_close(handle_);
  if (context_ != nullptr) libusb_exit(context_);
}

}  // namespace tactus::hal
