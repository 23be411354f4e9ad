#include "firmware/boards/linux_can/can_device_link.h"

#include <algorithm>
#include <cerrno>

namespace tactus::firmware {
namespace {

constexpr unsigned kQueuedSends = 3 * (kStateFragments + 1);  // three periods: adapters report sent frames late
constexpr can_err_mask_t kErrors = CAN_ERR_BUSOFF | CAN_ERR_RESTARTED | CAN_ERR_CRTL | CAN_ERR_LOSTARB;

}  // namespace

CanOpenError CanDeviceLink::open(const CanDeviceOptions& options) noexcept {
  options_ = options;
  const std::array<can_filter, 3> filters{exactly(can_id(CanFunction::kCommand0, options.node)),
                                          exactly(can_id(CanFunction::kCommand1, options.node)),
                                          exactly(can_id(CanFunction::kServiceRequest, options.node))};
  return socket_.open({.interface = options.interface,
                       .filters = filters,
                       .errors = kErrors,
                       .fd = options.fd,
                       .queued_sends = kQueuedSends});
}

std::size_t CanDeviceLink::receive_command(std::span<std::byte, kMaxFrameSize> buffer) noexcept {
  if (batches_ == 0) assembler_.look();
  for (;;) {
    while (next_in_batch_ < batch_size_) {
      const std::size_t size = take(socket_.frame(next_in_batch_++), buffer);
      if (size == 0) continue;
      if (command_seen_) ++counters_.superseded;
      command_seen_ = true;
      return size;
    }
    if (!read_batch()) break;
  }
  if (lost_) assembler_.forget();
  batches_ = batch_size_ = next_in_batch_ = 0;
  command_seen_ = lost_ = false;
  return 0;
}

// Reads the next batch of frames. False: no more frames in this period.
bool CanDeviceLink::read_batch() noexcept {
  const bool last_was_full = batches_ == 0 || batch_size_ == CanSocket::kBatch;
  if (!last_was_full || batches_ == CanSocket::kQueuedFrames / CanSocket::kBatch) return false;
  ++batches_;
  next_in_batch_ = 0;
  const std::uint32_t lost_before = socket_.lost();
  int error = 0;
  batch_size_ = socket_.receive(error);
  if (error == ENETDOWN) {
    ++counters_.interface_down;
    bus_off_ = false;  // the controller restarts with the interface
    bus_errors_.transmit = bus_errors_.receive = 0;
  }
  if (socket_.lost() != lost_before) {
    counters_.lost += socket_.lost() - lost_before;
    lost_ = true;
  }
  return true;
}

std::size_t CanDeviceLink::take(const CanReceived& frame, std::span<std::byte, kMaxFrameSize> command) noexcept {
  if (frame.error) {
    take_error(frame);
    return 0;
  }
  bus_off_ = false;
  if (can_function(frame.id) != CanFunction::kServiceRequest) return take_command(frame, command);
  take_request(frame);
  return 0;
}

std::size_t CanDeviceLink::take_command(const CanReceived& frame,
                                        std::span<std::byte, kMaxFrameSize> command) noexcept {
  if (options_.fd) {
    const auto bytes = unpad_fd(frame.data, kFdCommandSize, kCommandFrameSize);
    if (!frame.fd || bytes.empty() || can_function(frame.id) != CanFunction::kCommand0) {
      ++counters_.malformed;
      return 0;
    }
    std::copy(bytes.begin(), bytes.end(), command.begin());
  } else {
    CommandFrame whole;
    if (frame.fd || !assembler_.accept(can_function(frame.id), frame.data, whole)) return 0;
    encode_command(whole, command.first<kCommandFrameSize>());
  }
  ++counters_.commands;
  return kCommandFrameSize;
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
  if ((what & CAN_ERR_CRTL_RX_OVERFLOW) != 0) {
    ++counters_.lost;
    assembler_.forget();
  }
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
  // An incomplete set is useless: after a failure do not send the rest.
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
  // If the reply is lost, the host repeats its request.
  if (!bus_off_) (void)socket_.send(can_id(CanFunction::kServiceReply, options_.node), content);
}

CanDeviceCounters CanDeviceLink::counters() const noexcept {
  CanDeviceCounters all = counters_;
  all.incomplete = assembler_.incomplete();
  all.malformed += assembler_.malformed();
  return all;
}

}  // namespace tactus::firmware
