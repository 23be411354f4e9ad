#include "hal/falcon/falcon_usb.h"

#include <fmt/format.h>
#include <libusb.h>

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "hal/usb/usb_port.h"

namespace tactus::hal {
namespace {

constexpr unsigned char kOut = 0x02, kIn = 0x81;
constexpr int kInterface = 0, kPacket = 64, kStatusBytes = 2;

Status refused(const char* what, int error) {
  return Status::error(std::string("--device falcon: ") + what + " (" + libusb_error_name(error) + ")");
}

// The Falcons on the bus with their ports; the devices are held until the end.
struct Falcons {
  explicit Falcons(libusb_context* context) {
    const ssize_t count = libusb_get_device_list(context, &list);
    for (ssize_t i = 0; i < count; ++i) {
      libusb_device_descriptor descriptor{};
      if (libusb_get_device_descriptor(list[i], &descriptor) != 0) continue;
      if (descriptor.idVendor != FalconUsb::kVendor || descriptor.idProduct != FalconUsb::kProduct) continue;
      found.push_back({list[i], usb_port_of(list[i])});
    }
    std::sort(found.begin(), found.end(), [](const Falcon& a, const Falcon& b) { return a.port < b.port; });
  }
  ~Falcons() {
    if (list != nullptr) libusb_free_device_list(list, 1);
  }
  Falcons(const Falcons&) = delete;
  Falcons& operator=(const Falcons&) = delete;

  std::string ports() const {
    std::string text;
    for (const Falcon& falcon : found) text += (text.empty() ? "" : ", ") + falcon.port;
    return text;
  }

  struct Falcon {
    libusb_device* device;
    std::string port;
  };
  libusb_device** list{nullptr};
  std::vector<Falcon> found;
};

}  // namespace

Status FalconUsb::choose(const std::string& port) {
  const Falcons falcons(context_);
  if (falcons.found.empty()) return refused("no Falcon (0403:cb48) is plugged in", LIBUSB_ERROR_NO_DEVICE);
  if (port.empty() && falcons.found.size() > 1)
    return Status::error(
        fmt::format("--device falcon: {} Falcons are plugged in, at the USB ports {}; say which: falcon:@{}, or behind "
                    "the firmware "
                    "and the gain",
                    falcons.found.size(), falcons.ports(), falcons.found.front().port));
  const auto chosen = std::find_if(falcons.found.begin(), falcons.found.end(),
                                   [&port](const auto& one) { return port.empty() || one.port == port; });
  if (chosen == falcons.found.end())
    return Status::error(
        fmt::format("--device falcon: no Falcon is plugged into USB port {}; accepted: where there is one: {}", port,
                    falcons.ports()));
  port_ = chosen->port;
  const int error = libusb_open(chosen->device, &handle_);
  if (error == LIBUSB_ERROR_ACCESS)
    return refused(
        "this user may not use the Falcon; add a udev rule: SUBSYSTEM==\"usb\", ATTR{idVendor}==\"0403\", "
        "ATTR{idProduct}==\"cb48\", TAG+=\"uaccess\", and plug it in again",
        error);
  return error == 0 ? Status::good() : refused("the Falcon cannot be opened", error);
}

Result<std::unique_ptr<FalconUsb>> FalconUsb::open(const std::string& port) {
  std::unique_ptr<FalconUsb> usb(new FalconUsb());
  if (const int error = libusb_init(&usb->context_); error != 0) return refused("USB cannot be used", error);
  if (Status status = usb->choose(port); !status.ok()) return status;
  (void)libusb_set_auto_detach_kernel_driver(usb->handle_, 1);  // ftdi_sio, where it has taken the device
  if (const int error = libusb_claim_interface(usb->handle_, kInterface); error != 0)
    return refused("another program uses the Falcon", error);
  return usb;
}

FalconUsb::~FalconUsb() {
  if (handle_ != nullptr) {
    (void)libusb_release_interface(handle_, kInterface);
    libusb_close(handle_);
  }
  if (context_ != nullptr) libusb_exit(context_);
}

bool FalconUsb::control(FtdiRequest request, std::uint16_t value) noexcept {
  constexpr std::uint8_t kVendorOut = 0x40;  // from the host, vendor, to the device
  return libusb_control_transfer(handle_, kVendorOut, static_cast<std::uint8_t>(request), value, 0, nullptr, 0,
                                 static_cast<unsigned>(kTransfer.count())) >= 0;
}

bool FalconUsb::write(std::span<const std::uint8_t> bytes) noexcept {
  std::array<unsigned char, kPacket> copy{};
  int sent = 0;
  const std::size_t size = std::min(bytes.size(), copy.size());
  std::copy_n(bytes.begin(), size, copy.begin());
  const int error = libusb_bulk_transfer(handle_, kOut, copy.data(), static_cast<int>(size), &sent,
                                         static_cast<unsigned>(kTransfer.count()));
  return error == 0 && static_cast<std::size_t>(sent) == size;
}

// The first two bytes of every packet are the chip's own status. An empty packet comes with each latency tick.
int FalconUsb::read(std::span<std::uint8_t> bytes, std::chrono::milliseconds longest) noexcept {
  const auto deadline = std::chrono::steady_clock::now() + longest;
  std::array<unsigned char, kPacket> packet{};
  do {
    int count = 0;
    const int error = libusb_bulk_transfer(handle_, kIn, packet.data(), kPacket, &count,
                                           static_cast<unsigned>(std::max<long>(1, longest.count())));
    if (error != 0 && error != LIBUSB_ERROR_TIMEOUT) return -1;
    if (count <= kStatusBytes) continue;
    const auto size = std::min(bytes.size(), static_cast<std::size_t>(count - kStatusBytes));
    std::copy_n(packet.begin() + kStatusBytes, size, bytes.begin());
    return static_cast<int>(size);
  } while (std::chrono::steady_clock::now() < deadline);
  return 0;
}

}  // namespace tactus::hal
