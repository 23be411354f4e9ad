// The device's end of the USB link on a Linux board: frames through FunctionFS; the control period never waits for the
// bus.
//
// A read or write of a FunctionFS endpoint blocks until the host polls it, poll() does not work on endpoints, and data
// of asynchronous I/O is copied by a kernel worker of normal priority, which a busy board may delay for long.
// So each endpoint has its own thread that makes blocking calls at real-time priority; a queue of commands and a
// mailbox of the newest state connect them to the control period. A third thread serves endpoint 0: it passes a service
// request to the control period and keeps the reply until the host fetches it. Thread: open(), close(), plug(),
// unplug() [setup]; the four of DeviceLink [rt], the control period's alone: one atomic exchange and a copy each,
// send_state also wakes the writer; counters() [any]. Bound: one service request at a time; without a reply within 200
// ms it is dropped.
#pragma once

#include <atomic>
#include <cstdint>
#include <string>

#include "firmware/board.h"
#include "firmware/boards/linux/board_thread.h"
#include "firmware/boards/linux/mailbox.h"
#include "firmware/boards/linux_usb/usb_gadget.h"

struct usb_ctrlrequest;

namespace tactus::firmware {

// Since open().
struct GadgetCounters {
  std::uint64_t commands_received{0};
  std::uint64_t commands_superseded{0};  // arrived before the control period had taken the previous one
  std::uint64_t states_sent{0};          // fetched by the host
  std::uint64_t states_superseded{0};    // replaced by a newer one before the host fetched them
  std::uint64_t transfer_errors{0};      // transfers that failed while the device was configured
  std::uint64_t service_requests{0};
  std::uint64_t service_refused{0};  // malformed, unknown, or without a reply in time
  std::uint64_t disconnects{0};      // the host disconnected or reset the device
};

class UsbGadgetLink {
 public:
  UsbGadgetLink() = default;
  ~UsbGadgetLink() { close(); }
  UsbGadgetLink(const UsbGadgetLink&) = delete;
  UsbGadgetLink& operator=(const UsbGadgetLink&) = delete;

  // Sets the gadget up and binds it: the host may connect at once. priority: SCHED_FIFO of the three threads; must be
  // above the control period's, or a busy board starves its link. Returns the error in one line; empty: none.
  std::string open(const GadgetOptions& options, int priority);
  void close() noexcept;
  // Simulate plugging and unplugging the cable; for tests.
  std::string plug() { return gadget_.bind(); }
  void unplug() noexcept { gadget_.unbind(); }
  // Halts the state or the command endpoint until the host clears it; for tests. Waits for the end of the transfer in
  // progress, so do not call it while no host uses the endpoint.
  void halt(bool states) noexcept;

  bool configured() const noexcept { return configured_.load(std::memory_order_relaxed); }  // by the host
  bool realtime() const noexcept { return reader_.realtime() && writer_.realtime() && control_.realtime(); }
  const std::string& udc() const noexcept { return gadget_.udc(); }
  GadgetCounters counters() const noexcept;

  // --- DeviceLink
  std::size_t receive_command(std::span<std::byte, kMaxFrameSize> buffer) noexcept { return commands_.take(buffer); }
  void send_state(std::span<const std::byte> frame) noexcept;
  bool receive_service(ServiceMessage& message) noexcept;
  void reply_service(const ServiceMessage& message) noexcept;

 private:
  // Ownership of service_: only the present owner changes the state.
  enum class Service : std::uint8_t { kFree, kRequest, kAtPeriod, kReply };

  void read_commands() noexcept;
  void write_states() noexcept;
  void wake_writer() noexcept;
  void answer_control() noexcept;
  void handle_setup(const usb_ctrlrequest& setup) noexcept;
  bool take_request(const usb_ctrlrequest& setup) noexcept;
  bool give_reply(const usb_ctrlrequest& setup) noexcept;
  void await_reply() noexcept;
  void note_error(int error) noexcept;
  std::string open_files(const std::string& mount);
  std::string start_threads(int priority);

  using Counter = std::atomic<std::uint64_t>;
  static void count(Counter& counter) noexcept { counter.fetch_add(1, std::memory_order_relaxed); }

  UsbGadget gadget_;
  int control_file_{-1}, state_file_{-1}, command_file_{-1};
  CommandQueue commands_;
  Mailbox states_;
  std::atomic<std::uint32_t> states_written_{0};  // the writer thread waits for its change
  std::atomic<Service> service_state_{Service::kFree};
  ServiceMessage service_;
  std::atomic<bool> configured_{false};
  Counter commands_received_{0}, commands_superseded_{0}, states_sent_{0}, states_superseded_{0}, transfer_errors_{0},
      service_requests_{0}, service_refused_{0}, disconnects_{0};
  BoardThread reader_, writer_, control_;  // declared last: stopped before the members that they use are destroyed
};

static_assert(DeviceLink<UsbGadgetLink>);

}  // namespace tactus::firmware
