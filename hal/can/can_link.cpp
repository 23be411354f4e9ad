#include "hal/can/can_link.h"

#include <fmt/format.h>

#include <algorithm>
#include <bitset>
#include <cerrno>
#include <cstring>

#include "rt/base/clock.h"

namespace tactus::hal {
namespace {

using firmware::can_function;
using firmware::can_id;
using firmware::CanFunction;
using firmware::CanOpenError;
using firmware::CanReceived;
using firmware::CanSocket;
using std::chrono::nanoseconds;

constexpr can_err_mask_t kErrors = CAN_ERR_BUSOFF | CAN_ERR_RESTARTED | CAN_ERR_CRTL | CAN_ERR_LOSTARB | CAN_ERR_PROT |
                                   CAN_ERR_ACK | CAN_ERR_BUSERROR | CAN_ERR_CNT;
constexpr std::chrono::milliseconds kRebindEvery{100};

Status cannot_open(const std::string& interface, const CanOpenError& error) {
  using Step = CanOpenError::Step;
  if (error.number == EPERM || error.number == EACCES)
    return Status::error(
        fmt::format("no permission for {}: {}; run outside the sandbox, or as a user who may open "
                    "CAN sockets",
                    interface, std::strerror(error.number)));
  if (error.step == Step::kSocket)
    return Status::error(
        fmt::format("this kernel has no raw CAN sockets ({}); as root: modprobe can_raw", std::strerror(error.number)));
  if (error.step == Step::kName) return Status::error(fmt::format("no interface '{}'", interface));
  return Status::error(fmt::format("cannot open {}: {}", interface, std::strerror(error.number)));
}

// Nodes whose states were received. `ours`: the selected one is among them; `ours_fd`: it sends CAN FD frames.
struct Heard {
  std::bitset<firmware::kMaxCanNode + 1> nodes;
  bool ours{false}, ours_fd{false};
};

Result<Heard> listen(const CanOptions& options, bool fd) {
  constexpr std::uint32_t function_bits = 0xfu << 7;
  const can_filter states{can_id(CanFunction::kState0, 0), function_bits | CAN_EFF_FLAG | CAN_RTR_FLAG};
  CanSocket socket;
  const CanOpenError failed =
      socket.open({.interface = options.interface.c_str(), .filters = std::span(&states, 1), .errors = 0, .fd = fd});
  if (failed.step != CanOpenError::Step::kNone) return cannot_open(options.interface, failed);
  Heard heard;
  const std::int64_t deadline = MonotonicClock::now_ns() + nanoseconds(options.first_frame).count();
  while (!heard.ours) {
    const std::int64_t left = deadline - MonotonicClock::now_ns();
    if (left <= 0 || !socket.wait(nanoseconds(left))) break;
    int error = 0;
    const unsigned count = socket.receive(error);
    if (error != 0) return cannot_open(options.interface, {CanOpenError::Step::kBind, error});
    for (unsigned i = 0; i < count; ++i) {
      const std::uint32_t node = socket.frame(i).id & firmware::kMaxCanNode;
      heard.nodes.set(node);
      if (node == options.node) {
        heard.ours = true;
        heard.ours_fd = socket.frame(i).fd;
      }
    }
  }
  return heard;
}

std::string names_of(const Heard& heard) {
  if (heard.nodes.none()) return "none is heard at all: is the device powered, the bus terminated, the bit rate right?";
  std::string names = "heard:";
  for (std::size_t node = 0; node < heard.nodes.size(); ++node)
    if (heard.nodes.test(node)) names += fmt::format(" {}", node);
  return names;
}

}  // namespace

Result<std::unique_ptr<CanLink>> CanLink::open(const CanOptions& options) {
  if (options.node < 1 || options.node > firmware::kMaxCanNode)
    return Status::error(fmt::format("node id {}; accepted: 1 to {}", options.node, firmware::kMaxCanNode));
  if (options.wait < nanoseconds::zero() || options.wait > options.period)
    return Status::error("the wait must be between 0 and the period");
  auto interface = find_can_interface(options.interface);
  if (!interface.ok()) return interface.status();
  if (const Status usable = check_can_interface(interface.value(), options.format == CanFormat::kFd); !usable.ok())
    return usable;

  const auto heard = listen(options, interface.value().fd && options.format != CanFormat::kClassic);
  if (!heard.ok()) return heard.status();
  if (!heard.value().ours)
    return Status::error(fmt::format("no device with node id {} sends on {}; {}", options.node, options.interface,
                                     names_of(heard.value())));
  const bool fd = heard.value().ours_fd;
  if (options.format == CanFormat::kFd && !fd)
    return Status::error(
        fmt::format("node {} sends classic frames; set it to FD, or open it as classic", options.node));

  if (const Status fits = check_can_rate(interface.value(), fd, options.period); !fits.ok()) return fits;

  std::unique_ptr<CanLink> link(new CanLink(options, interface.value(), fd));
  if (const CanOpenError failed = link->open_socket(link->socket()); failed.step != CanOpenError::Step::kNone)
    return cannot_open(options.interface, failed);
  link->keeper_ = std::jthread([raw = link.get()](const std::stop_token& stop) { raw->keep_bound(stop); });
  return link;
}

CanLink::CanLink(const CanOptions& options, const CanInterface& interface, bool fd)
    : options_(options),
      interface_(interface),
      fd_(fd),
      assembler_(
          static_cast<std::uint32_t>(std::chrono::duration_cast<std::chrono::microseconds>(options.period).count())) {}

CanOpenError CanLink::open_socket(CanSocket& socket) const noexcept {
  std::array<can_filter, 4> filters;
  constexpr std::array<CanFunction, 4> functions{CanFunction::kState0, CanFunction::kState1, CanFunction::kState2,
                                                 CanFunction::kStatus};
  for (std::size_t i = 0; i < filters.size(); ++i) filters[i] = firmware::exactly(can_id(functions[i], options_.node));
  return socket.open({.interface = options_.interface.c_str(), .filters = filters, .errors = kErrors, .fd = fd_});
}

Status CanLink::start() {
  std::array<std::byte, firmware::kMaxFrameSize> buffer;
  (void)receive(buffer);
  counters_ = {};
  errors_ = {};
  incomplete_before_ = assembler_.incomplete();
  malformed_before_ = assembler_.malformed();
  return Status::good();
}

ReceivedFrame CanLink::receive(std::span<std::byte, firmware::kMaxFrameSize> buffer) noexcept {
  take_over_socket();
  assembler_.look();
  ReceivedFrame newest;
  drain(buffer, newest);
  if (newest.size > 0 || options_.wait == nanoseconds::zero() || !connected_) return newest;
  // A state's fragments arrive one by one, so one wake may not be enough; the deadline applies to all of them together.
  const std::int64_t deadline = MonotonicClock::now_ns() + options_.wait.count();
  for (unsigned wake = 0; wake < kMaxWakes && newest.size == 0 && connected_; ++wake) {
    const std::int64_t left = deadline - MonotonicClock::now_ns();
    if (left <= 0 || !socket().wait(nanoseconds(left))) break;
    drain(buffer, newest);
  }
  return newest;
}

void CanLink::drain(std::span<std::byte, firmware::kMaxFrameSize> buffer, ReceivedFrame& newest) noexcept {
  const std::uint32_t lost_before = socket().lost();
  for (unsigned batch = 0; batch < kMaxFrames / CanSocket::kBatch; ++batch) {
    int error = 0;
    const unsigned count = socket().receive(error);
    if (error != 0) note_failure(error);
    for (unsigned i = 0; i < count; ++i) {
      const CanReceived& frame = socket().frame(i);
      if (!take(frame, buffer)) continue;
      ++counters_.received;
      if (newest.size > 0) {
        ++newest.superseded;
        ++counters_.superseded;
      }
      newest.size = firmware::kStateFrameSize;
      newest.arrival_ns = frame.arrival_ns;
      connected_ = true;
    }
    if (count < CanSocket::kBatch) break;
  }
  if (socket().lost() == lost_before) return;
  errors_.queue_full += socket().lost() - lost_before;
  assembler_.forget();
}

bool CanLink::take(const CanReceived& frame, std::span<std::byte, firmware::kMaxFrameSize> buffer) noexcept {
  if (frame.error) {
    take_error(frame);
    return false;
  }
  if (fd_) {
    const auto bytes = firmware::unpad_fd(frame.data, firmware::kFdStateSize, firmware::kStateFrameSize);
    const bool whole = frame.fd && !bytes.empty() && can_function(frame.id) == CanFunction::kState0;
    if (!whole) ++counters_.malformed;
    if (whole) std::copy(bytes.begin(), bytes.end(), buffer.begin());
    return whole;
  }
  firmware::StateFrame state;
  if (!assembler_.accept(can_function(frame.id), frame.data, state)) return false;
  firmware::encode_state(state, buffer.first<firmware::kStateFrameSize>());
  return true;
}

void CanLink::take_error(const CanReceived& frame) noexcept {
  ++counters_.errors;
  if ((frame.id & CAN_ERR_BUSOFF) != 0) {
    ++errors_.bus_off;
    disconnect();
  }
  if ((frame.id & CAN_ERR_RESTARTED) != 0) ++errors_.restarted;
  if ((frame.id & CAN_ERR_LOSTARB) != 0) ++errors_.arbitration_lost;
  if ((frame.id & (CAN_ERR_PROT | CAN_ERR_ACK | CAN_ERR_BUSERROR)) != 0) ++errors_.protocol;
  if (frame.data.size() < CAN_ERR_DLC) return;
  const auto at = [&](std::size_t i) { return std::to_integer<std::uint8_t>(frame.data[i]); };
  if ((frame.id & CAN_ERR_CNT) != 0) {
    errors_.tx_errors = at(6);
    errors_.rx_errors = at(7);
  }
  if ((frame.id & CAN_ERR_CRTL) == 0) return;
  if ((at(1) & (CAN_ERR_CRTL_RX_WARNING | CAN_ERR_CRTL_TX_WARNING)) != 0) ++errors_.error_warning;
  if ((at(1) & (CAN_ERR_CRTL_RX_PASSIVE | CAN_ERR_CRTL_TX_PASSIVE)) != 0) ++errors_.error_passive;
  if ((at(1) & CAN_ERR_CRTL_RX_OVERFLOW) != 0) {
    ++errors_.controller_full;
    assembler_.forget();
  }
}

void CanLink::note_failure(int error) noexcept {
  if (error == ENETDOWN || error == ENODEV || error == ENXIO) disconnect();
  if (error == ENODEV || error == ENXIO) {
    auto expected = SocketState::kGood;
    socket_state_.compare_exchange_strong(expected, SocketState::kLost, std::memory_order_acq_rel);
  }
}

void CanLink::disconnect() noexcept {
  assembler_.forget();
  if (connected_) ++counters_.disconnects;
  connected_ = false;
}

void CanLink::take_over_socket() noexcept {
  if (socket_state_.load(std::memory_order_acquire) != SocketState::kReplaced) return;
  active_ = 1 - active_;
  socket_state_.store(SocketState::kGood, std::memory_order_release);
}

bool CanLink::send(std::span<const std::byte> frame) noexcept {
  firmware::CommandFrame command;
  int error = EINVAL;
  if (fd_ && frame.size() <= firmware::kFdCommandSize) {  // any content: the device validates it
    std::array<std::byte, firmware::kFdCommandSize> padded;
    firmware::pad_fd(frame, padded);
    error = socket().send(can_id(CanFunction::kCommand0, options_.node), padded);
  } else if (!fd_ && firmware::decode_command(frame, command) == firmware::DecodeError::kNone) {
    error = send_classic(command);
  }
  if (error == 0) {
    ++counters_.sent;
    return true;
  }
  ++counters_.send_failed;
  note_failure(error);
  return false;
}

int CanLink::send_classic(const firmware::CommandFrame& command) noexcept {
  assembler_.sent(command.sequence);
  for (const firmware::CanFragment& fragment : firmware::split_command(command))
    if (const int error = socket().send(can_id(fragment.function, options_.node), fragment.data); error != 0)
      return error;
  return 0;
}

LinkCounters CanLink::counters() const noexcept {
  LinkCounters all = counters_;
  all.malformed += assembler_.malformed() - malformed_before_;
  all.malformed += assembler_.incomplete() - incomplete_before_;
  return all;
}

CanBusErrors CanLink::bus_errors() const noexcept {
  CanBusErrors all = errors_;
  all.incomplete = assembler_.incomplete() - incomplete_before_;
  return all;
}

Result<firmware::ServiceMessage> CanLink::call(const firmware::ServiceMessage& request,
                                               std::chrono::milliseconds timeout) {
  const can_filter replies = firmware::exactly(can_id(CanFunction::kServiceReply, options_.node));
  CanSocket socket;
  const CanOpenError failed = socket.open(
      {.interface = options_.interface.c_str(), .filters = std::span(&replies, 1), .errors = 0, .fd = false});
  if (failed.step != CanOpenError::Step::kNone) return cannot_open(options_.interface, failed);
  firmware::CanData content{};
  firmware::encode_service_content(request, content);
  if (const int error = socket.send(can_id(CanFunction::kServiceRequest, options_.node), content); error != 0)
    return Status::error(fmt::format("{} takes no frame: {}; ip -details link show {}", options_.interface,
                                     std::strerror(error), options_.interface));
  const std::int64_t deadline = MonotonicClock::now_ns() + nanoseconds(timeout).count();
  for (;;) {
    const std::int64_t left = deadline - MonotonicClock::now_ns();
    if (left <= 0 || !socket.wait(nanoseconds(left))) break;
    int error = 0;
    const unsigned count = socket.receive(error);
    for (unsigned i = 0; i < count; ++i) {
      firmware::ServiceMessage reply;
      if (firmware::decode_service_content(socket.frame(i).data, reply) && reply.tag == request.tag &&
          reply.address == request.address)
        return reply;
    }
    if (error != 0) break;
  }
  return Status::error(
      fmt::format("node {} on {} did not answer for register {} within {} ms; ask again, or check "
                  "its power and the bus",
                  options_.node, options_.interface, request.address, timeout.count()));
}

void CanLink::keep_bound(const std::stop_token& stop) {
  std::unique_lock lock(keeper_mutex_);
  while (!stop.stop_requested()) {
    keeper_wake_.wait_for(lock, stop, kRebindEvery, [] { return false; });
    if (socket_state_.load(std::memory_order_acquire) != SocketState::kLost) continue;
    // active_ does not change until the haptic thread reads kReplaced.
    if (open_socket(sockets_[1 - active_]).step == CanOpenError::Step::kNone)
      socket_state_.store(SocketState::kReplaced, std::memory_order_release);
  }
}

}  // namespace tactus::hal
