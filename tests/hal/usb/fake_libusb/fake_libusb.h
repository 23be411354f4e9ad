// A libusb of the tests' own, in place of the real one: one device with the endpoints of firmware/PROTOCOL.md, whose
// faults are switched on from outside, and Falcons at ports, which can be opened and no more. It counts what the real
// one would crash at.
//
// Linked into a test program it takes the place of libusb's functions. Thread: all functions, any.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace tactus::test {

struct FakeUsbPort {
  std::uint8_t bus{0};
  std::vector<std::uint8_t> ports{};
  bool operator==(const FakeUsbPort&) const = default;
};

struct FakeUsb {
  bool plugged{true};
  std::string serial{"A1"};
  std::vector<FakeUsbPort> falcons{};        // at these ports
  bool falcons_forbidden{false};             // this user may not use them
  bool in_halted{false}, out_halted{false};  // until the host clears them
  bool halts_again{false};                   // a cleared endpoint halts at once
  bool submit_fails{false};                  // transfers IN are refused

  // Counted since reset_fake_usb().
  unsigned freed_in_flight{0}, closed_in_flight{0};  // what libusb aborts at
  unsigned opened{0}, cleared_in{0}, cleared_out{0};
  FakeUsbPort falcon_opened{};
  std::uint64_t states{0}, commands{0};  // transfers completed with data
};

// Everything as at the start.
void reset_fake_usb();
// The device now.
FakeUsb fake_usb();
// `change` under the lock.
template <class F>
void change_fake_usb(F&& change);

namespace detail {
FakeUsb& lock_fake_usb();
void unlock_fake_usb();
}  // namespace detail

template <class F>
void change_fake_usb(F&& change) {
  change(detail::lock_fake_usb());
  detail::unlock_fake_usb();
}

}  // namespace tactus::test
