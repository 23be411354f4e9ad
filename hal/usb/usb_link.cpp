#include "hal/usb/usb_link.h"

#include <algorithm>
#include <thread>

#include "hal/usb/usb_session.h"
#include "rt/base/clock.h"

namespace tactus::hal {

using firmware::ServiceDirection;
using firmware::ServiceMessage;

Result<std::unique_ptr<UsbLink>> UsbLink::open(const UsbOptions& options) {
  Result<std::unique_ptr<UsbConnection>> connection = UsbConnection::open(options.device);
  if (!connection.ok()) return connection.status();
  std::unique_ptr<UsbLink> link(new UsbLink(options));
  link->info_ = connection.value()->info();
  link->selection_.serial = link->info_.serial;  // a replug accepts the same device only
  link->session_ = std::make_unique<Session>(*link, std::move(connection).value());
  // Queue the transfers here, so that open() returns a connected link or an error.
  if (!link->session_->begin()) {
    link->end_session();
    return Status::error("the USB device was unplugged just now: plug it in again");
  }
  link->connected_.store(true, std::memory_order_relaxed);
  constexpr std::uint32_t kStack_KiB = 512;  // the bus scan at a replug keeps long paths on the stack
  if (Status status = link->thread_.start(kStack_KiB, options.realtime, &run_thread, link.get()); !status.ok()) {
    link->end_session();
    return status;
  }
  return link;
}

UsbLink::UsbLink(const UsbOptions& options) : selection_(options.device) {}

UsbLink::~UsbLink() {
  stop_.store(true, std::memory_order_release);
  thread_.join();
}

Status UsbLink::start() {
  if (!connected()) return Status::error("the USB device is unplugged: plug it in again");
  while (const State* state = states_.take()) taken_number_ = state->number + 1;
  before_start_ = total();
  return Status::good();
}

// --- the haptic thread

ReceivedFrame UsbLink::receive(std::span<std::byte, firmware::kMaxFrameSize> buffer) noexcept {
  const State* state = states_.take();
  if (state == nullptr) return {};
  std::copy_n(state->bytes.begin(), state->size, buffer.begin());
  const std::uint64_t superseded = state->number - taken_number_;
  taken_number_ = state->number + 1;
  return {state->size, state->arrival_ns, static_cast<std::uint32_t>(superseded)};
}

bool UsbLink::send(std::span<const std::byte> frame) noexcept {
  if (!connected() || frame.empty() || frame.size() > firmware::kMaxFrameSize) {
    count(send_failed_);
    return false;
  }
  Command& command = commands_.writing();
  command.size = static_cast<std::uint32_t>(frame.size());
  std::copy(frame.begin(), frame.end(), command.bytes.begin());
  commands_.publish();
  count(sent_);
  return true;
}

LinkCounters UsbLink::total() const noexcept {
  const auto read = [](const Counter& counter) { return counter.load(std::memory_order_relaxed); };
  return {.received = read(received_),
          .superseded = states_.superseded(),
          .malformed = read(malformed_),
          .sent = read(sent_),
          .send_superseded = commands_.superseded(),
          .send_failed = read(send_failed_),
          .errors = read(errors_),
          .disconnects = read(disconnects_)};
}

LinkCounters UsbLink::counters() const noexcept {
  LinkCounters now = total();
  now.received -= before_start_.received;
  now.superseded -= before_start_.superseded;
  now.malformed -= before_start_.malformed;
  now.sent -= before_start_.sent;
  now.send_superseded -= before_start_.send_superseded;
  now.send_failed -= before_start_.send_failed;
  now.errors -= before_start_.errors;
  now.disconnects -= before_start_.disconnects;
  return now;
}

// --- the link's thread

void UsbLink::run() noexcept {
  while (!stop_.load(std::memory_order_acquire)) {
    if (session_ != nullptr) {
      serve();
      end_session();
    } else {
      reconnect();
    }
  }
  if (session_ != nullptr) end_session();
}

void UsbLink::serve() noexcept {
  while (!stop_.load(std::memory_order_relaxed) && !session_->gone()) {
    session_->handle_events(kIdleLook);  // returns when the first transfer completes
    session_->clear_halts();
    session_->send_newest();
  }
}

void UsbLink::end_session() noexcept {
  const bool lost = session_->gone();
  connected_.store(false, std::memory_order_relaxed);
  if (lost) count(disconnects_);
  session_->cancel();
  // A request may be in progress: its transfer ends because the device is gone, or by its timeout.
  std::unique_lock<std::mutex> no_calls(calls_, std::defer_lock);
  while (!session_->idle() || !no_calls.try_lock()) session_->handle_events(kIdleLook);
  session_.reset();
  drop_command();
}

// Drops an unsent command, so that an old one is not sent after a replug.
void UsbLink::drop_command() noexcept {
  if (commands_.take() != nullptr) count(send_failed_);
}

void UsbLink::reconnect() noexcept {
  constexpr std::chrono::milliseconds kPiece{20};
  for (auto waited = kPiece; waited < kReplugLook && !stop_.load(std::memory_order_relaxed); waited += kPiece)
    std::this_thread::sleep_for(kPiece);
  if (stop_.load(std::memory_order_relaxed)) return;
  Result<std::unique_ptr<UsbConnection>> connection = UsbConnection::open(selection_);
  const std::lock_guard<std::mutex> no_calls(calls_);
  if (!connection.ok()) {  // not there yet, permissions not set yet, or a different device
    const bool nobody = connection.message() == no_usb_device(selection_).message();
    refused_ = nobody ? "" : connection.message();
    return;
  }
  refused_.clear();
  session_ = std::make_unique<Session>(*this, std::move(connection).value());
  drop_command();
  if (session_->begin()) connected_.store(true, std::memory_order_relaxed);
}

// --- service requests

Result<ServiceMessage> UsbLink::call(const ServiceMessage& request, std::chrono::milliseconds timeout) {
  using Milliseconds = std::chrono::milliseconds;
  const std::lock_guard<std::mutex> one_at_a_time(calls_);
  const std::int64_t deadline_ns = MonotonicClock::now_ns() + std::chrono::nanoseconds(timeout).count();
  const auto left = [deadline_ns] { return Milliseconds((deadline_ns - MonotonicClock::now_ns()) / 1'000'000); };
  std::array<std::byte, firmware::kServiceFrameSize> bytes;
  firmware::encode_service(request, ServiceDirection::kRequest, bytes);

  int error = LIBUSB_ERROR_NO_DEVICE;
  if (session_ != nullptr && connected())
    error = session_->ask(firmware::kUsbRequestOut, firmware::kUsbWriteService, bytes, left());
  if (error == 0) {
    // The device stalls the read while it has no reply.
    do {
      error = connected() ? session_->ask(firmware::kUsbRequestIn, firmware::kUsbReadService, bytes, left())
                          : static_cast<int>(LIBUSB_ERROR_NO_DEVICE);
      if (error == LIBUSB_ERROR_PIPE) std::this_thread::sleep_for(Milliseconds(1));
    } while (error == LIBUSB_ERROR_PIPE && left() > Milliseconds(0));
  }
  if (error == LIBUSB_ERROR_NO_DEVICE)
    return Status::error(refused_.empty() ? "the USB device is unplugged: plug it in again" : refused_);
  if (error == LIBUSB_ERROR_PIPE || error == LIBUSB_ERROR_TIMEOUT)
    return Status::error("the USB device did not answer within " + std::to_string(timeout.count()) +
                         " ms: its control loop stands still, or its firmware knows no service requests");
  if (error != 0) return Status::error(std::string("the question to the USB device failed: ") + libusb_strerror(error));

  ServiceMessage reply;
  if (firmware::decode_service(bytes, ServiceDirection::kReply, reply) != firmware::DecodeError::kNone)
    return Status::error("the USB device's answer is broken: its firmware is of another version");
  if (reply.tag != request.tag || reply.address != request.address)
    return Status::error("the USB device answered another question: ask again");
  return reply;
}

}  // namespace tactus::hal
