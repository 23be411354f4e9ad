#include "tests/hal/usb/fake_libusb/fake_libusb.h"

#include <libusb.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <mutex>
#include <thread>
#include <vector>

#include "firmware/usb_interface.h"

struct libusb_context {};
struct libusb_device {
  tactus::test::FakeUsbPort port{1, {1}};
  bool is_falcon{false};
};
struct libusb_device_handle {};

namespace {

using tactus::test::FakeUsb;
using tactus::test::FakeUsbPort;
namespace firmware = tactus::firmware;

constexpr unsigned char kIn = 0x81, kOut = 0x02;

struct Bus {
  std::mutex mutex;
  FakeUsb usb;
  std::vector<libusb_transfer*> in_flight, cancelled;
};
Bus& bus() {
  static Bus made;
  return made;
}
libusb_device the_device;
std::deque<libusb_device> the_falcons;  // of the newest list
libusb_device_handle the_handle;

// What a transfer ends with now.
void set_outcome(Bus& b, libusb_transfer& t) {
  const bool cancelled = std::find(b.cancelled.begin(), b.cancelled.end(), &t) != b.cancelled.end();
  t.actual_length = 0;
  if (!b.usb.plugged) {
    t.status = LIBUSB_TRANSFER_NO_DEVICE;
  } else if (cancelled) {
    t.status = LIBUSB_TRANSFER_CANCELLED;
  } else if (t.endpoint == 0 || (t.endpoint == kIn && b.usb.in_halted) || (t.endpoint == kOut && b.usb.out_halted)) {
    t.status = LIBUSB_TRANSFER_STALL;
  } else {
    t.status = LIBUSB_TRANSFER_COMPLETED;
    t.actual_length = t.length;
    ++(t.endpoint == kIn ? b.usb.states : b.usb.commands);
  }
}

}  // namespace

namespace tactus::test {

void reset_fake_usb() {
  change_fake_usb([](FakeUsb& usb) { usb = {}; });
}
FakeUsb fake_usb() {
  const std::lock_guard lock(bus().mutex);
  return bus().usb;
}
FakeUsb& detail::lock_fake_usb() {
  bus().mutex.lock();
  return bus().usb;
}
void detail::unlock_fake_usb() { bus().mutex.unlock(); }

}  // namespace tactus::test

extern "C" {

int libusb_init(libusb_context** context) {
  *context = new libusb_context;
  return 0;
}
void libusb_exit(libusb_context* context) { delete context; }
const char* libusb_strerror(int) { return "an error of the fake"; }

ssize_t libusb_get_device_list(libusb_context*, libusb_device*** list) {
  const std::lock_guard lock(bus().mutex);
  the_falcons.clear();
  for (const FakeUsbPort& port : bus().usb.falcons) the_falcons.push_back({port, true});
  *list = static_cast<libusb_device**>(std::calloc(2 + the_falcons.size(), sizeof(libusb_device*)));
  ssize_t count = 0;
  if (bus().usb.plugged) (*list)[count++] = &the_device;
  for (libusb_device& falcon : the_falcons) (*list)[count++] = &falcon;
  return count;
}
void libusb_free_device_list(libusb_device** list, int) { std::free(list); }

int libusb_get_device_descriptor(libusb_device* device, libusb_device_descriptor* descriptor) {
  *descriptor = {};
  descriptor->idVendor = device->is_falcon ? 0x0403 : firmware::kUsbVendor;
  descriptor->idProduct = device->is_falcon ? 0xcb48 : firmware::kUsbProduct;
  descriptor->iSerialNumber = 1;
  return 0;
}
int libusb_get_active_config_descriptor(libusb_device*, libusb_config_descriptor** config) {
  static libusb_endpoint_descriptor endpoints[2]{};
  static libusb_interface_descriptor setting{};
  static libusb_interface interface {};
  static libusb_config_descriptor only{};
  endpoints[0].bEndpointAddress = kIn;
  endpoints[1].bEndpointAddress = kOut;
  for (auto& endpoint : endpoints) {
    endpoint.bmAttributes = 3;
    endpoint.wMaxPacketSize = firmware::kUsbPacketSize;
  }
  setting.bNumEndpoints = 2;
  setting.bInterfaceProtocol = 1;
  setting.endpoint = endpoints;
  setting.bInterfaceClass = firmware::kUsbInterfaceClass;
  setting.bInterfaceSubClass = firmware::kUsbInterfaceSubclass;
  interface.altsetting = &setting;
  interface.num_altsetting = 1;
  only.bNumInterfaces = 1;
  only.interface = &interface;
  *config = &only;
  return 0;
}
void libusb_free_config_descriptor(libusb_config_descriptor*) {}
std::uint8_t libusb_get_bus_number(libusb_device* device) { return device->port.bus; }
int libusb_get_port_numbers(libusb_device* device, std::uint8_t* ports, int) {
  std::copy(device->port.ports.begin(), device->port.ports.end(), ports);
  return static_cast<int>(device->port.ports.size());
}
int libusb_get_device_speed(libusb_device*) { return LIBUSB_SPEED_HIGH; }
int libusb_get_string_descriptor_ascii(libusb_device_handle*, std::uint8_t, unsigned char* data, int length) {
  const std::lock_guard lock(bus().mutex);
  const std::string& serial = bus().usb.serial;
  const int size = std::min(length, static_cast<int>(serial.size()));
  std::memcpy(data, serial.data(), static_cast<std::size_t>(size));
  return size;
}

int libusb_open(libusb_device* device, libusb_device_handle** handle) {
  const std::lock_guard lock(bus().mutex);
  if (device->is_falcon && bus().usb.falcons_forbidden) return LIBUSB_ERROR_ACCESS;
  if (device->is_falcon) bus().usb.falcon_opened = device->port;
  ++bus().usb.opened;
  *handle = &the_handle;
  return 0;
}
void libusb_close(libusb_device_handle*) {
  const std::lock_guard lock(bus().mutex);
  if (!bus().in_flight.empty()) ++bus().usb.closed_in_flight;
}
const char* libusb_error_name(int) { return "LIBUSB_ERROR"; }
int libusb_set_auto_detach_kernel_driver(libusb_device_handle*, int) { return 0; }
int libusb_control_transfer(libusb_device_handle*, std::uint8_t, std::uint8_t, std::uint16_t, std::uint16_t,
                            unsigned char*, std::uint16_t, unsigned) {
  return 0;
}
int libusb_bulk_transfer(libusb_device_handle*, unsigned char, unsigned char*, int, int* count, unsigned) {
  *count = 0;
  return LIBUSB_ERROR_TIMEOUT;
}
int libusb_claim_interface(libusb_device_handle*, int) { return 0; }
int libusb_release_interface(libusb_device_handle*, int) { return 0; }
int libusb_clear_halt(libusb_device_handle*, unsigned char endpoint) {
  const std::lock_guard lock(bus().mutex);
  FakeUsb& usb = bus().usb;
  if (!usb.plugged) return LIBUSB_ERROR_NO_DEVICE;
  ++(endpoint == kIn ? usb.cleared_in : usb.cleared_out);
  (endpoint == kIn ? usb.in_halted : usb.out_halted) = usb.halts_again;
  return 0;
}

libusb_transfer* libusb_alloc_transfer(int) {
  return static_cast<libusb_transfer*>(std::calloc(1, sizeof(libusb_transfer)));
}
void libusb_free_transfer(libusb_transfer* transfer) {
  const std::lock_guard lock(bus().mutex);
  const auto& in_flight = bus().in_flight;
  if (std::find(in_flight.begin(), in_flight.end(), transfer) != in_flight.end()) {
    ++bus().usb.freed_in_flight;
    return;  // kept, so that the test goes on
  }
  std::free(transfer);
}
int libusb_submit_transfer(libusb_transfer* transfer) {
  const std::lock_guard lock(bus().mutex);
  if (!bus().usb.plugged) return LIBUSB_ERROR_NO_DEVICE;
  if (bus().usb.submit_fails && transfer->endpoint == kIn) return LIBUSB_ERROR_IO;
  bus().in_flight.push_back(transfer);
  return 0;
}
int libusb_cancel_transfer(libusb_transfer* transfer) {
  const std::lock_guard lock(bus().mutex);
  const auto& in_flight = bus().in_flight;
  if (std::find(in_flight.begin(), in_flight.end(), transfer) == in_flight.end()) return LIBUSB_ERROR_NOT_FOUND;
  bus().cancelled.push_back(transfer);
  return 0;
}

// The oldest transfer ends; a little slower than at once, so that threads take turns.
int libusb_handle_events_timeout_completed(libusb_context*, timeval*, int*) {
  libusb_transfer* done = nullptr;
  {
    const std::lock_guard lock(bus().mutex);
    if (!bus().in_flight.empty()) {
      done = bus().in_flight.front();
      set_outcome(bus(), *done);
    }
    std::erase(bus().in_flight, done);
    std::erase(bus().cancelled, done);
  }
  if (done != nullptr) done->callback(done);
  std::this_thread::sleep_for(std::chrono::microseconds(100));
  return 0;
}

}  // extern "C"
