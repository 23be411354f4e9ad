#include "hal/falcon/falcon_usb.h"

#include <libusb.h>

#include <algorithm>
#include <array>
#include <string>

namespace tactus::hal {
namespace {

constexpr unsigned char kOut = 0x02, kIn = 0x81;
constexpr int kInterface = 0, kPacket = 64, kStatusBytes = 2;

Status refused(const char* what, int error) {
  return Status::error(std::string("--device falcon: ") + what + " (" + libusb_error_name(error) + ")");
}

}  // namespace

Result<std::unique_ptr<FalconPort>> FalconUsb::open() {
  std::unique_ptr<FalconUsb> port(new FalconUsb());
  if (const int error = libusb_init(&port->context_); error != 0) return refused("USB cannot be used", error);
  libusb_device** list = nullptr;
  const ssize_t count = libusb_get_device_list(port->context_, &list);
  int error = LIBUSB_ERROR_NO_DEVICE;
  for (ssize_t i = 0; i < count && port->handle_ == nullptr; ++i) {
    libusb_device_descriptor descriptor{};
    if (libusb_get_device_descriptor(list[i], &descriptor) != 0) continue;
    if (descriptor.idVendor == kVendor && descriptor.idProduct == kProduct)
      error = libusb_open(list[i], &port->handle_);
  }
  if (list != nullptr) libusb_free_device_list(list, 1);
  if (error == LIBUSB_ERROR_ACCESS)
    return refused(
        "this user may not use the Falcon; add a udev rule: SUBSYSTEM==\"usb\", ATTR{idVendor}==\"0403\", "
        "ATTR{idProduct}==\"cb48\", TAG+=\"uaccess\", and plug it in again",
        error);
  if (error != 0) return refused("no Falcon (0403:cb48) is plugged in", error);
  (void)libusb_set_auto_detach_kernel_driver(port->handle_, 1);  // ftdi_sio, where it has taken the device
  if (error = libusb_claim_interface(port->handle_, kInterface); error != 0)
    return refused("another program uses the Falcon", error);
  return std::unique_ptr<FalconPort>(std::move(port));
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
