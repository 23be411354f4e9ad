#include "hal/usb/usb_session.h"

#include <algorithm>

#include "rt/base/clock.h"

namespace tactus::hal {
namespace {

// Consecutive failed transfers after which the connection is ended and reopened: a cable being unplugged causes some.
constexpr unsigned kMaxFailures = 20;
// The same for consecutive halts of the state endpoint.
constexpr unsigned kMaxHalts = 5;

}  // namespace

UsbLink::Session::Session(UsbLink& link, std::unique_ptr<UsbConnection> connection)
    : link_(link), connection_(std::move(connection)) {
  libusb_device_handle* handle = connection_->handle();
  for (Transfer& transfer : states_) {
    transfer.usb = libusb_alloc_transfer(0);
    TACTUS_CHECK(transfer.usb != nullptr, 0, 0);
    libusb_fill_interrupt_transfer(transfer.usb, handle, connection_->state_endpoint(), transfer.buffer.data(),
                                   firmware::kUsbPacketSize, &on_state, this, 0);
  }
  command_.usb = libusb_alloc_transfer(0);
  control_.usb = libusb_alloc_transfer(0);
  TACTUS_CHECK(command_.usb != nullptr && control_.usb != nullptr, 0, 0);
  libusb_fill_interrupt_transfer(command_.usb, handle, connection_->command_endpoint(), command_.buffer.data(), 0,
                                 &on_command, this, 0);
}

UsbLink::Session::~Session() {
  cancel();
  while (!idle()) handle_events(kIdleLook);
  for (Transfer& transfer : states_) libusb_free_transfer(transfer.usb);
  libusb_free_transfer(command_.usb);
  libusb_free_transfer(control_.usb);
}

bool UsbLink::Session::submit(Transfer& transfer) noexcept {
  in_flight_.fetch_add(1, std::memory_order_acq_rel);
  const int error = libusb_submit_transfer(transfer.usb);
  if (error == 0) return true;
  in_flight_.fetch_sub(1, std::memory_order_acq_rel);
  if (error == LIBUSB_ERROR_NO_DEVICE) lose();
  return false;
}

bool UsbLink::Session::begin() noexcept {
  for (Transfer& transfer : states_) {
    if (!submit(transfer)) {
      lose();
      return false;
    }
    ++states_in_flight_;
  }
  return true;
}

bool UsbLink::Session::clear(std::uint8_t endpoint) noexcept {
  const bool cleared = libusb_clear_halt(connection_->handle(), endpoint) == 0;
  if (!cleared) lose();
  return cleared;
}

// The state endpoint is cleared only after all IN transfers have completed, so that the order of frames is preserved.
void UsbLink::Session::clear_halts() noexcept {
  if (gone_ || ending_) return;
  if (commands_halted_ && clear(connection_->command_endpoint())) commands_halted_ = false;
  if (!states_halted_ || states_in_flight_ > 0 || gone_) return;
  if (++halts_in_a_row_ > kMaxHalts) return lose();
  if (!clear(connection_->state_endpoint())) return;
  states_halted_ = false;
  (void)begin();
}

void UsbLink::Session::lose() noexcept {
  gone_ = true;
  link_.connected_.store(false, std::memory_order_relaxed);
}

void UsbLink::Session::note_failure(const libusb_transfer& transfer) noexcept {
  if (transfer.status == LIBUSB_TRANSFER_CANCELLED) return;
  if (transfer.status == LIBUSB_TRANSFER_NO_DEVICE) return lose();
  count(link_.errors_);
  if (transfer.status != LIBUSB_TRANSFER_STALL) {
    if (++failures_in_a_row_ >= kMaxFailures) lose();
  } else if (&transfer == command_.usb) {
    commands_halted_ = true;
  } else if (!states_halted_) {
    states_halted_ = true;
    for (Transfer& other : states_)
      libusb_cancel_transfer(other.usb);  // some controllers do not complete them otherwise
  }
}

void UsbLink::Session::take_state(const libusb_transfer& transfer) noexcept {
  const auto size = static_cast<std::size_t>(transfer.actual_length);
  if (size == 0 || size > firmware::kMaxFrameSize) return count(link_.malformed_);
  State& state = link_.states_.writing();
  state.number = link_.received_.load(std::memory_order_relaxed);
  state.arrival_ns = MonotonicClock::now_ns();
  state.size = static_cast<std::uint32_t>(size);
  std::copy_n(reinterpret_cast<const std::byte*>(transfer.buffer), size, state.bytes.begin());
  count(link_.received_);
  link_.states_.publish();
}

void UsbLink::Session::on_state(libusb_transfer* transfer) {
  auto& session = *static_cast<Session*>(transfer->user_data);
  session.in_flight_.fetch_sub(1, std::memory_order_acq_rel);
  --session.states_in_flight_;
  if (transfer->status == LIBUSB_TRANSFER_COMPLETED) {
    session.failures_in_a_row_ = session.halts_in_a_row_ = 0;
    session.take_state(*transfer);
  } else if (transfer->status == LIBUSB_TRANSFER_OVERFLOW) {
    count(session.link_.malformed_);  // a packet larger than the endpoint's: not a tactus frame
  } else {
    session.note_failure(*transfer);
  }
  if (session.gone_ || session.ending_ || session.states_halted_) return;
  for (Transfer& own : session.states_) {
    if (own.usb != transfer) continue;
    if (session.submit(own)) {
      ++session.states_in_flight_;
    } else if (!session.gone_) {
      count(session.link_.errors_);
      session.lose();  // without IN transfers no frames arrive: reconnect
    }
  }
  session.send_newest();
}

void UsbLink::Session::send_newest() noexcept {
  if (command_under_way_ || commands_halted_ || gone_ || ending_) return;
  const Command* command = link_.commands_.take();
  if (command == nullptr) return;
  std::copy_n(command->bytes.begin(), command->size, reinterpret_cast<std::byte*>(command_.buffer.data()));
  command_.usb->length = static_cast<int>(command->size);
  command_under_way_ = submit(command_);
  if (!command_under_way_) count(link_.send_failed_);
}

void UsbLink::Session::on_command(libusb_transfer* transfer) {
  auto& session = *static_cast<Session*>(transfer->user_data);
  session.in_flight_.fetch_sub(1, std::memory_order_acq_rel);
  session.command_under_way_ = false;
  if (transfer->status != LIBUSB_TRANSFER_COMPLETED) {
    count(session.link_.send_failed_);
    session.note_failure(*transfer);
  }
  session.send_newest();  // a new command may have arrived during this transfer
}

void UsbLink::Session::handle_events(std::chrono::microseconds wait) noexcept {
  timeval timeout{static_cast<time_t>(wait.count() / 1'000'000), static_cast<suseconds_t>(wait.count() % 1'000'000)};
  libusb_handle_events_timeout_completed(connection_->context(), &timeout, nullptr);
}

void UsbLink::Session::cancel() noexcept {
  ending_ = true;
  for (Transfer& transfer : states_) libusb_cancel_transfer(transfer.usb);  // harmless if not in flight
  libusb_cancel_transfer(command_.usb);
}

void UsbLink::Session::on_control(libusb_transfer* transfer) {
  auto& session = *static_cast<Session*>(transfer->user_data);
  session.control_done_.store(1, std::memory_order_release);
  session.control_done_.notify_one();
  session.in_flight_.fetch_sub(1, std::memory_order_acq_rel);
}

// The caller's thread only submits; the link's thread handles the completion. libusb's synchronous calls would make the
// caller's thread handle all events meanwhile, at its lower priority.
int UsbLink::Session::ask(std::uint8_t request_type, std::uint8_t request,
                          std::span<std::byte, firmware::kServiceFrameSize> data, std::chrono::milliseconds timeout) {
  unsigned char* buffer = control_.buffer.data();
  libusb_fill_control_setup(buffer, request_type, request, 0, connection_->interface_number(),
                            static_cast<std::uint16_t>(data.size()));
  auto* content = reinterpret_cast<std::byte*>(buffer + LIBUSB_CONTROL_SETUP_SIZE);
  std::copy(data.begin(), data.end(), content);
  libusb_fill_control_transfer(control_.usb, connection_->handle(), buffer, &on_control, this,
                               static_cast<unsigned>(std::max<std::int64_t>(timeout.count(), 1)));
  control_done_.store(0, std::memory_order_relaxed);
  in_flight_.fetch_add(1, std::memory_order_acq_rel);
  if (const int error = libusb_submit_transfer(control_.usb); error != 0) {
    in_flight_.fetch_sub(1, std::memory_order_acq_rel);
    return error;
  }
  control_done_.wait(0, std::memory_order_acquire);
  std::copy_n(content, data.size(), data.begin());
  switch (control_.usb->status) {
    case LIBUSB_TRANSFER_COMPLETED:
      return control_.usb->actual_length == static_cast<int>(data.size()) ? 0 : LIBUSB_ERROR_OVERFLOW;
    case LIBUSB_TRANSFER_STALL:
      return LIBUSB_ERROR_PIPE;
    case LIBUSB_TRANSFER_TIMED_OUT:
      return LIBUSB_ERROR_TIMEOUT;
    case LIBUSB_TRANSFER_NO_DEVICE:
      return LIBUSB_ERROR_NO_DEVICE;
    default:
      return LIBUSB_ERROR_IO;
  }
}

}  // namespace tactus::hal
