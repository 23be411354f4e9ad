// The host's end of a USB link: FrameLink over libusb, with a thread of its own between the bus and the haptic thread.
//
// The link's thread keeps kInFlight transfers IN queued, so that no poll of the bus finds none; each that completes
// stores its frame and arrival time as the newest value, is queued again, and sends the newest command that the haptic
// thread has left: one transfer OUT at a time, so that what leaves is never older than one transfer. When no frame
// comes, it looks for commands every kIdleLook all the same. The haptic thread exchanges values with it
// (rt/base/latest_value.h): it calls neither libusb nor the kernel.
// Unplugged: connected() is false with the first transfer that says so, commands are refused and counted. The thread
// then looks for a device with the same serial every kReplugLook, opens it and goes on; nobody has to do anything.
// An endpoint that halts (STALL) is cleared when the link opens and whenever it happens, by the link's thread; one that
// halts again and again ends the connection as if it were unplugged.
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
  // The link's thread. Above the haptic thread's priority: where both share a core, a frame that arrived must not wait
  // for the next tick. cpu: -1 for any; the haptic loop's own core is the wrong one.
  loop::SetupRequest realtime{.cpu = -1, .priority = 85};
};

class UsbLink {
 public:
  static constexpr unsigned kInFlight = 4;
  static constexpr std::chrono::milliseconds kIdleLook{2}, kReplugLook{200};

  // Errors, one line each: no device, no permission, several devices, no such serial, no tactus interface, another
  // protocol version, in use by a kernel driver or a program. Missing real-time privileges are no error: see
  // setup_report(). Frames flow from here on.
  static Result<std::unique_ptr<UsbLink>> open(const UsbOptions& options = {});
  ~UsbLink();
  UsbLink(const UsbLink&) = delete;
  UsbLink& operator=(const UsbLink&) = delete;

  // Drops what waits and clears the counters, just before the first tick.
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
  std::unique_ptr<Session> session_;  // the link's thread's, but for call(), which holds the lock
  std::mutex calls_;                  // one question at a time, and no session ends under one
  LatestValue<State> states_;
  LatestValue<Command> commands_;
  std::atomic<bool> connected_{false}, stop_{false};
  std::string refused_;  // why the last new connection failed; under calls_
  Counter received_{0}, malformed_{0}, sent_{0}, send_failed_{0}, errors_{0}, disconnects_{0};
  std::uint64_t taken_number_{0};  // the haptic thread's
  LinkCounters before_start_;
  loop::RealtimeThread thread_;  // last: it is joined before anything that it uses goes
};

static_assert(FrameLink<UsbLink>);

}  // namespace tactus::hal
