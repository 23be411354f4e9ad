#include "firmware/boards/linux_can/can_device_link.h"

#include <algorithm>
#include <cerrno>

namespace tactus::firmware {
namespace {

constexpr unsigned kQueuedSends = 3 * (kStateFragments + 1);  // three periods: adapters report late what has left
constexpr can_err_mask_t kErrors = CAN_ERR_BUSOFF | CAN_ERR_RESTARTED | CAN_ERR_CRTL | CAN_ERR_LOSTARB;

}  // namespace

CanOpenError CanDeviceLink::open(const CanDeviceOptions& options) noexcept {
  options_ = options;
  const std::array<can_filter, 3> filters{exactly(can_id(CanFunction::kCommand0, options.node)),
                                          exactly(can_id(CanFunction::kCommand1, options.node)),
                                          exactly(can_id(CanFunction::kServiceRequest, options.node))};
  return socket_.open({options.interface, filters, kErrors, options.fd, kQueuedSends});
}

std::size_t CanDeviceLink::receive_command(std::span<std::byte, kMaxFrameSize> buffer) noexcept {
  drain();
  const std::size_t size = command_size_;
  std::copy_n(command_.begin(), size, buffer.begin());
  command_size_ = 0;
  return size;
}

void CanDeviceLink::drain() noexcept {
  assembler_.look();
  const std::uint32_t lost_before = socket_.lost();
  for (unsigned batch = 0; batch < CanSocket::kQueuedFrames / CanSocket::kBatch; ++batch) {
    int error = 0;
    const unsigned count = socket_.receive(error);
    if (error == ENETDOWN) {
      ++counters_.interface_down;
      bus_off_ = false;  // the controller starts afresh with the interface
      bus_errors_.transmit = bus_errors_.receive = 0;
    }
    for (unsigned i = 0; i < count; ++i) take(socket_.frame(i));
    if (count < CanSocket::kBatch) break;
  }
  if (socket_.lost() == lost_before) return;
  counters_.lost += socket_.lost() - lost_before;
  assembler_.forget();
}

void CanDeviceLink::take(const CanReceived& frame) noexcept {
  if (frame.error) return take_error(frame);
  bus_off_ = false;
  if (can_function(frame.id) == CanFunction::kServiceRequest) return take_request(frame);
  take_command(frame);
}

void CanDeviceLink::take_command(const CanReceived& frame) noexcept {
  std::size_t size = 0;
  if (options_.fd) {
    const auto bytes = unpad_fd(frame.data, kFdCommandSize, kCommandFrameSize);
    if (!frame.fd || bytes.empty() || can_function(frame.id) != CanFunction::kCommand0) {
      ++counters_.malformed;
      return;
    }
    std::copy(bytes.begin(), bytes.end(), command_.begin());
    size = bytes.size();
  } else {
    CommandFrame command;
    if (frame.fd || !assembler_.accept(can_function(frame.id), frame.data, command)) return;
    encode_command(command, std::span(command_).first<kCommandFrameSize>());
    size = kCommandFrameSize;
  }
  ++counters_.commands;
  if (command_size_ > 0) ++counters_.superseded;
  command_size_ = size;
}

void CanDeviceLink::take_request(const CanReceived& frame) noexcept {
  ServiceMessage message;
  if (frame.fd || !decode_service_content(frame.data, message)) {
    ++counters_.malformed;
  } else if (waiting_requests_ == kWaitingRequests) {
    ++counters_.lost;
  } else {
    requests_[(first_request_ + waiting_requests_++) % kWaitingRequests] = message;
  }
}

void CanDeviceLink::take_error(const CanReceived& frame) noexcept {
  take_bus_errors(frame.id, frame.data, bus_errors_);
  if ((frame.id & CAN_ERR_BUSOFF) != 0) {
    ++counters_.bus_off;
    bus_off_ = true;
    assembler_.forget();
  }
  if ((frame.id & CAN_ERR_RESTARTED) != 0) bus_off_ = false;
  if ((frame.id & CAN_ERR_LOSTARB) != 0) ++counters_.arbitration_lost;
  if ((frame.id & CAN_ERR_CRTL) == 0 || frame.data.size() < 2) return;
  const auto what = std::to_integer<unsigned>(frame.data[1]);
  if ((what & (CAN_ERR_CRTL_RX_PASSIVE | CAN_ERR_CRTL_TX_PASSIVE)) != 0) ++counters_.error_passive;
  if ((what & CAN_ERR_CRTL_RX_OVERFLOW) != 0) ++counters_.lost, assembler_.forget();
  if ((what & CAN_ERR_CRTL_ACTIVE) != 0) bus_off_ = false;
}

void CanDeviceLink::send_state(std::span<const std::byte> frame) noexcept {
  StateFrame state;
  bool sent = false;
  if (bus_off_ || decode_state(frame, state) != DecodeError::kNone) {
    // counted below
  } else if (options_.fd) {
    std::array<std::byte, kFdStateSize> padded;
    pad_fd(frame, padded);
    sent = socket_.send(can_id(CanFunction::kState0, options_.node), padded) == 0;
  } else {
    sent = send_fragments(state);
  }
  ++(sent ? counters_.states : counters_.send_failed);
}

bool CanDeviceLink::send_fragments(const StateFrame& frame) noexcept {
  std::array<CanFragment, kStateFragments + 1> fragments;
  const unsigned count = splitter_.split(frame, fragments);
  // A set of which one part did not go is worth nothing: the rest stays.
  for (unsigned i = 0; i < count; ++i)
    if (socket_.send(can_id(fragments[i].function, options_.node), fragments[i].data) != 0) return false;
  return true;
}

bool CanDeviceLink::receive_service(ServiceMessage& message) noexcept {
  if (waiting_requests_ == 0) return false;
  message = requests_[first_request_];
  first_request_ = (first_request_ + 1) % kWaitingRequests;
  --waiting_requests_;
  return true;
}

void CanDeviceLink::reply_service(const ServiceMessage& message) noexcept {
  CanData content{};
  encode_service_content(message, content);
  // An answer that does not go out is asked for again.
  if (!bus_off_) (void)socket_.send(can_id(CanFunction::kServiceReply, options_.node), content);
}

CanDeviceCounters CanDeviceLink::counters() const noexcept {
  CanDeviceCounters all = counters_;
  all.incomplete = assembler_.incomplete();
  all.malformed += assembler_.malformed();
  return all;
}

}  // namespace tactus::firmware
