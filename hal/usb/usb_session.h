// The transfers of one USB connection: states IN kept in flight, one command OUT, one control exchange for call().
//
// Part of UsbLink, which it reports to. An endpoint that halts is cleared and used again, a few times in a row; what is
// under way on the other goes on. Thread: the link's; ask() by the one that calls, while the link's thread serves.
// Bound: all transfers are allocated at construction; a callback does one copy and one resubmission.
#pragma once

#include <libusb.h>

#include <chrono>

#include "hal/usb/usb_link.h"

namespace tactus::hal {

class UsbLink::Session {
 public:
  Session(UsbLink& link, std::unique_ptr<UsbConnection> connection);
  ~Session();  // waits until nothing is in flight any more
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  // Queues the transfers IN. False: the device is gone, or takes none.
  bool begin() noexcept;
  // Clears the endpoints that have halted; waits for the device's answer, by the link's thread alone.
  void clear_halts() noexcept;
  // Waits for what the bus does, at most `wait`, and lets the callbacks run.
  void handle_events(std::chrono::microseconds wait) noexcept;
  // The newest command, if there is one and none is under way.
  void send_newest() noexcept;
  bool gone() const noexcept { return gone_; }
  void cancel() noexcept;
  bool idle() const noexcept { return in_flight_.load(std::memory_order_acquire) == 0; }

  // One control transfer of 16 bytes each way: 0 or the libusb error. Waits for the link's thread to see it complete.
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
  // False when it is not under way.
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
