// The host's end of a USB link: FrameLink over libusb, with its own thread between the bus and the haptic thread.
//
// The link's thread keeps kInFlight IN transfers queued, so that every poll of the bus finds one. When one completes,
// the thread stores its frame and arrival time as the newest value, queues it again, and sends the newest command from
// the haptic thread: one OUT transfer at a time, so that a command waits for at most one transfer. While no frame
// arrives, it checks for commands every kIdleLook. The haptic thread exchanges values with it
// (rt/base/latest_value.h): it calls neither libusb nor the kernel.
// Unplugged: connected() is false from the first transfer that reports it; commands are refused and counted. The thread
// then searches for a device with the same serial every kReplugLook and reconnects automatically.
// A halted endpoint (STALL) is cleared when the link opens and whenever it occurs, by the link's thread; repeated halts
// end the connection as if the device were unplugged.
// Thread: open(), start(), call() [setup] and normal threads, call() while the loop runs too; receive(), send() [rt],
// by the haptic thread alone; connected(), counters() [any]. Bound: receive() and send(): one atomic exchange and a
// copy. call(): its timeout. open(): the scan (usb_connection.h). The destructor: one transfer's cancellation, ms.
#pragma once

#include <atomic>
#include <chrono>
#include <memory>
#include <mutex>
#include <string>

#include "hal/frame_link.h"
#include "hal/usb/usb_connection.h"
#include "rt/base/latest_value.h"
#include "rt/thread/realtime_thread.h"

namespace tactus::hal {

struct UsbOptions {
  UsbSelection device;
  // The link's thread. Its priority is above the haptic thread's, so that on a shared core a received frame does not
  // wait for the next tick. cpu: -1 for any; do not use the haptic loop's core.
  loop::SetupRequest realtime{.cpu = -1, .priority = 85};
};

class UsbLink {
 public:
  static constexpr unsigned kInFlight = 4;
  static constexpr std::chrono::milliseconds kIdleLook{2}, kReplugLook{200};

  // Starts the exchange of frames. Errors, one line each: no device, no permission, several devices, no such serial, no
  // tactus interface, another protocol version, in use by a kernel driver or a program. Missing real-time privileges
  // are no error: see setup_report().
  static Result<std::unique_ptr<UsbLink>> open(const UsbOptions& options = {});
  ~UsbLink();
  UsbLink(const UsbLink&) = delete;
  UsbLink& operator=(const UsbLink&) = delete;

  // Drops waiting frames and clears the counters, just before the first tick.
  Status start();

  // --- FrameLink
  ReceivedFrame receive(std::span<std::byte, firmware::kMaxFrameSize> buffer) noexcept;
  bool send(std::span<const std::byte> frame) noexcept;
  bool connected() const noexcept { return connected_.load(std::memory_order_relaxed); }
  LinkCounters counters() const noexcept;
  Result<firmware::ServiceMessage> call(const firmware::ServiceMessage& request, std::chrono::milliseconds timeout);

  const loop::SetupReport& setup_report() const noexcept { return thread_.report(); }
  const UsbDeviceInfo& info() const noexcept { return info_; }  // as it was at open()

 private:
  struct State {
    std::uint64_t number{0};  // frames received before this one
    std::int64_t arrival_ns{0};
    std::uint32_t size{0};
    std::array<std::byte, firmware::kMaxFrameSize> bytes{};
  };
  struct Command {
    std::uint32_t size{0};
    std::array<std::byte, firmware::kMaxFrameSize> bytes{};
  };
  class Session;  // the transfers of one connection

  using Counter = std::atomic<std::uint64_t>;
  static void count(Counter& counter) noexcept { counter.fetch_add(1, std::memory_order_relaxed); }

  explicit UsbLink(const UsbOptions& options);
  static void run_thread(void* self) noexcept { static_cast<UsbLink*>(self)->run(); }
  void run() noexcept;
  void serve() noexcept;
  void end_session() noexcept;
  void reconnect() noexcept;
  void drop_command() noexcept;
  LinkCounters total() const noexcept;

  UsbSelection selection_;
  UsbDeviceInfo info_;
  std::unique_ptr<Session> session_;  // used by the link's thread, and by call() under the lock
  std::mutex calls_;                  // one request at a time; no session ends during a request
  LatestValue<State> states_;
  LatestValue<Command> commands_;
  std::atomic<bool> connected_{false}, stop_{false};
  std::string refused_;  // why the last reconnection failed; guarded by calls_
  Counter received_{0}, malformed_{0}, sent_{0}, send_failed_{0}, errors_{0}, disconnects_{0};
  std::uint64_t taken_number_{0};  // the haptic thread's
  LinkCounters before_start_;
  loop::RealtimeThread thread_;  // declared last: joined before the members that it uses are destroyed
};

static_assert(FrameLink<UsbLink>);

}  // namespace tactus::hal
