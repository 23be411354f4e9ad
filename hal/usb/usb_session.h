// The transfers of one USB connection: queued IN transfers for states, one OUT for a command, one control for call().
//
// Part of UsbLink, whose counters it updates. A halted endpoint is cleared and used again, a few times in a row; the
// other endpoint's transfers continue. Thread: the link's; ask() by its caller while the link's thread handles events.
// Bound: all transfers are allocated at construction; a callback does one copy and one resubmission.
#pragma once

#include <libusb.h>

#include <chrono>

#include "hal/usb/usb_link.h"

namespace tactus::hal {

class UsbLink::Session {
 public:
  Session(UsbLink& link, std::unique_ptr<UsbConnection> connection);
  ~Session();  // waits until no transfer is in flight
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  // Queues the IN transfers. False: the device is gone, or accepts none.
  bool begin() noexcept;
  // Clears halted endpoints; waits for the device's answer. Link's thread only.
  void clear_halts() noexcept;
  // Waits at most `wait` for bus events and runs their callbacks.
  void handle_events(std::chrono::microseconds wait) noexcept;
  // Sends the newest command, if there is one and no command transfer is in flight.
  void send_newest() noexcept;
  bool gone() const noexcept { return gone_; }
  void cancel() noexcept;
  bool idle() const noexcept { return in_flight_.load(std::memory_order_acquire) == 0; }

  // One control transfer of 16 bytes, in the direction of `request_type`. Returns 0 or the libusb error. Waits until
  // the link's thread has handled its completion.
  int ask(std::uint8_t request_type, std::uint8_t request, std::span<std::byte, firmware::kServiceFrameSize> data,
          std::chrono::milliseconds timeout);

 private:
  struct Transfer {
    libusb_transfer* usb{nullptr};
    std::array<unsigned char, 128> buffer{};
  };

  static void on_state(libusb_transfer* transfer);
  static void on_command(libusb_transfer* transfer);
  static void on_control(libusb_transfer* transfer);
  void take_state(const libusb_transfer& transfer) noexcept;
  // False if it could not be submitted.
  bool submit(Transfer& transfer) noexcept;
  void note_failure(const libusb_transfer& transfer) noexcept;
  bool clear(std::uint8_t endpoint) noexcept;
  void lose() noexcept;

  UsbLink& link_;
  std::unique_ptr<UsbConnection> connection_;
  std::array<Transfer, kInFlight> states_;
  Transfer command_, control_;
  std::atomic<unsigned> in_flight_{0};
  unsigned states_in_flight_{0};
  std::atomic<int> control_done_{0};
  bool command_under_way_{false}, gone_{false}, ending_{false};
  bool states_halted_{false}, commands_halted_{false};
  unsigned failures_in_a_row_{0}, halts_in_a_row_{0};  // without a state between them
};

}  // namespace tactus::hal
