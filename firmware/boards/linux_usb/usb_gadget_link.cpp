#include "firmware/boards/linux_usb/usb_gadget_link.h"

#include <endian.h>
#include <fcntl.h>
#include <linux/usb/functionfs.h>
#include <time.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "firmware/boards/linux_usb/usb_descriptors.h"

namespace tactus::firmware {
namespace {

constexpr int kReplyPolls = 800;  // of 250 us: 200 ms

void sleep_us(long us) noexcept {
  const timespec pause{0, us * 1000};
  nanosleep(&pause, nullptr);
}

std::string write_all(int file, const std::string& blob, const char* what) {
  if (write(file, blob.data(), blob.size()) == static_cast<ssize_t>(blob.size())) return "";
  return std::string("FunctionFS refused the ") + what + ": " + std::strerror(errno);
}

template <void (UsbGadgetLink::*kBody)() noexcept>
void run_body(void* link) noexcept {
  (static_cast<UsbGadgetLink*>(link)->*kBody)();
}

}  // namespace

std::string UsbGadgetLink::open(const GadgetOptions& options, int priority) {
  close();
  std::string error = gadget_.create(options);
  if (error.empty()) error = open_files(options.mount);
  if (error.empty()) error = start_threads(priority);
  if (error.empty()) error = gadget_.bind();
  if (!error.empty()) close();
  return error;
}

// The endpoints' files exist only after the descriptors are written.
std::string UsbGadgetLink::open_files(const std::string& mount) {
  const auto open_file = [&](const char* name, int& file) -> std::string {
    file = ::open((mount + "/" + name).c_str(), O_RDWR | O_CLOEXEC);
    return file >= 0 ? "" : mount + "/" + name + ": " + std::strerror(errno);
  };
  std::string error = open_file("ep0", control_file_);
  if (error.empty()) error = write_all(control_file_, functionfs_descriptors(), "descriptors");
  if (error.empty()) error = write_all(control_file_, functionfs_strings(), "strings");
  if (error.empty()) error = open_file("ep1", state_file_);
  if (error.empty()) error = open_file("ep2", command_file_);
  return error;
}

std::string UsbGadgetLink::start_threads(int priority) {
  std::string error = control_.start(&run_body<&UsbGadgetLink::answer_control>, this, priority);
  if (error.empty()) error = reader_.start(&run_body<&UsbGadgetLink::read_commands>, this, priority);
  if (error.empty()) error = writer_.start(&run_body<&UsbGadgetLink::write_states>, this, priority);
  return error;
}

void UsbGadgetLink::close() noexcept {
  gadget_.unbind();
  writer_.request_stop();
  wake_writer();  // a signal does not end its sleep
  control_.stop();
  reader_.stop();
  writer_.stop();
  for (int* file : {&state_file_, &command_file_, &control_file_}) {
    if (*file >= 0) ::close(*file);
    *file = -1;
  }
  gadget_.remove();
  configured_.store(false, std::memory_order_relaxed);
}

// Counts a failed transfer, unless it ended because the host disconnected.
void UsbGadgetLink::note_error(int error) noexcept {
  if (error != EINTR && error != ESHUTDOWN && configured()) count(transfer_errors_);
  if (error != EINTR && error != ESHUTDOWN) sleep_us(1000);  // no busy loop at real-time priority, whatever the error
}

// FunctionFS halts an endpoint that is accessed in the wrong direction.
void UsbGadgetLink::halt(bool states) noexcept {
  std::byte nothing{};
  [[maybe_unused]] const ssize_t halted = states ? read(state_file_, &nothing, 1) : write(command_file_, &nothing, 1);
}

void UsbGadgetLink::read_commands() noexcept {
  std::array<std::byte, kUsbPacketSize> packet;
  while (!reader_.stopping()) {
    const ssize_t size = read(command_file_, packet.data(), packet.size());  // blocks until the host sends
    if (size < 0) {
      note_error(errno);
      continue;
    }
    count(commands_received_);
    if (size > 0 && commands_.write(std::span(packet).first(static_cast<std::size_t>(size))))
      count(commands_superseded_);
  }
}

void UsbGadgetLink::write_states() noexcept {
  std::array<std::byte, kMaxFrameSize> frame;
  for (;;) {
    // Read before stopping(): close() first requests the stop and then changes the number, so the stop is not missed.
    const std::uint32_t before = states_written_.load(std::memory_order_acquire);
    if (writer_.stopping()) return;
    const std::size_t size = states_.take(frame);
    if (size == 0) {
      states_written_.wait(before, std::memory_order_acquire);
    } else if (write(state_file_, frame.data(), size) < 0) {  // blocks until the host fetches it
      note_error(errno);
    } else {
      count(states_sent_);
    }
  }
}

void UsbGadgetLink::send_state(std::span<const std::byte> frame) noexcept {
  if (states_.write(frame)) count(states_superseded_);
  wake_writer();
}

void UsbGadgetLink::wake_writer() noexcept {
  states_written_.fetch_add(1, std::memory_order_release);
  states_written_.notify_one();
}

// --- endpoint 0

void UsbGadgetLink::answer_control() noexcept {
  while (!control_.stopping()) {
    usb_functionfs_event event{};
    if (read(control_file_, &event, sizeof event) != static_cast<ssize_t>(sizeof event)) {
      // EIDRM: the host replaced a request by another one. Pause on all other errors.
      if (errno != EIDRM && errno != EINTR) sleep_us(1000);
      continue;
    }
    switch (event.type) {
      case FUNCTIONFS_ENABLE:
        configured_.store(true, std::memory_order_relaxed);
        break;
      case FUNCTIONFS_DISABLE:
      case FUNCTIONFS_UNBIND:
        if (configured_.exchange(false, std::memory_order_relaxed)) count(disconnects_);
        break;
      case FUNCTIONFS_SETUP:
        handle_setup(event.u.setup);
        break;
      default:
        break;  // bind, suspend, resume: nothing to do
    }
  }
}

// Stalls an unknown request, or one without a reply: FunctionFS stalls when the data go in the wrong direction.
void UsbGadgetLink::handle_setup(const usb_ctrlrequest& setup) noexcept {
  const bool to_host = (setup.bRequestType & USB_DIR_IN) != 0;
  const bool good = to_host ? give_reply(setup) : take_request(setup);
  if (good) return;
  count(service_refused_);
  std::byte nothing{};
  [[maybe_unused]] const ssize_t stalled =
      to_host ? read(control_file_, &nothing, 0) : write(control_file_, &nothing, 0);
}

bool UsbGadgetLink::take_request(const usb_ctrlrequest& setup) noexcept {
  if (setup.bRequest != kUsbWriteService || setup.bRequestType != kUsbRequestOut ||
      le16toh(setup.wLength) != kServiceFrameSize)
    return false;
  // The control period still owns the last request: it has not run for 200 ms.
  if (service_state_.load(std::memory_order_acquire) == Service::kAtPeriod) return false;
  std::array<std::byte, kServiceFrameSize> bytes;
  if (read(control_file_, bytes.data(), bytes.size()) != static_cast<ssize_t>(bytes.size())) return true;
  service_state_.store(Service::kFree, std::memory_order_relaxed);  // drops a reply that was never fetched
  // Too late to stall this request; the read that follows will be stalled.
  if (decode_service(bytes, ServiceDirection::kRequest, service_) != DecodeError::kNone) {
    count(service_refused_);
    return true;
  }
  count(service_requests_);
  service_state_.store(Service::kRequest, std::memory_order_release);
  await_reply();
  return true;
}

void UsbGadgetLink::await_reply() noexcept {
  for (int i = 0; i < kReplyPolls && !control_.stopping(); ++i) {
    if (service_state_.load(std::memory_order_acquire) == Service::kReply) return;
    sleep_us(250);
  }
  Service expected = Service::kRequest;  // withdrawn, unless the control period has just taken it
  service_state_.compare_exchange_strong(expected, Service::kFree, std::memory_order_acq_rel);
  count(service_refused_);
}

bool UsbGadgetLink::give_reply(const usb_ctrlrequest& setup) noexcept {
  if (setup.bRequest != kUsbReadService || setup.bRequestType != kUsbRequestIn ||
      le16toh(setup.wLength) < kServiceFrameSize)
    return false;
  if (service_state_.load(std::memory_order_acquire) != Service::kReply) return false;
  std::array<std::byte, kServiceFrameSize> bytes;
  encode_service(service_, ServiceDirection::kReply, bytes);
  // Kept until the next request: a host whose read failed may read again.
  [[maybe_unused]] const ssize_t written = write(control_file_, bytes.data(), bytes.size());
  return true;
}

bool UsbGadgetLink::receive_service(ServiceMessage& message) noexcept {
  Service expected = Service::kRequest;
  if (!service_state_.compare_exchange_strong(expected, Service::kAtPeriod, std::memory_order_acq_rel)) return false;
  message = service_;
  return true;
}

void UsbGadgetLink::reply_service(const ServiceMessage& message) noexcept {
  service_ = message;
  service_state_.store(Service::kReply, std::memory_order_release);
}

GadgetCounters UsbGadgetLink::counters() const noexcept {
  const auto read_counter = [](const Counter& counter) { return counter.load(std::memory_order_relaxed); };
  return {.commands_received = read_counter(commands_received_),
          .commands_superseded = read_counter(commands_superseded_),
          .states_sent = read_counter(states_sent_),
          .states_superseded = read_counter(states_superseded_),
          .transfer_errors = read_counter(transfer_errors_),
          .service_requests = read_counter(service_requests_),
          .service_refused = read_counter(service_refused_),
          .disconnects = read_counter(disconnects_)};
}

}  // namespace tactus::firmware
