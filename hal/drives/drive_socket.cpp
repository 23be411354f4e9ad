#include "hal/drives/drive_socket.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "hal/can/can_interface.h"
#include "hal/drives/drive_codec.h"
#include "hal/drives/robstride_codec.h"
#include "rt/base/clock.h"

namespace tactus::hal {
namespace {

using firmware::CanOpenError;
using firmware::CanReceived;

constexpr can_err_mask_t kErrors = CAN_ERR_BUSOFF | CAN_ERR_RESTARTED;
constexpr std::uint32_t kAnyKind = CAN_EFF_FLAG | CAN_RTR_FLAG;

// The identifiers on which this drive answers.
can_filter filter_of(DriveFamily family, const DriveAxis& axis) noexcept {
  switch (family) {
    case DriveFamily::kRobStride:  // the type and the faults are in the identifier, too
      return {axis.id << 8 | CAN_EFF_FLAG, 0xff00u | kAnyKind};
    case DriveFamily::kMoteus:
      return axis.id < 8 ? can_filter{axis.id << 8, CAN_SFF_MASK | kAnyKind}
                         : can_filter{axis.id << 8 | CAN_EFF_FLAG, CAN_EFF_MASK | kAnyKind};
    case DriveFamily::kOdrive:
      return {axis.id << 5, 0x7e0u | kAnyKind};
    default:
      return firmware::exactly(axis.answer_id);
  }
}

Status check_rates(const DriveDescription& drives, const CanInterface& interface) {
  if (interface.is_virtual || interface.bit_per_s == 0) return Status::good();
  if (interface.bit_per_s != drives.bit_per_s)
    return Status::error(fmt::format("{} runs at {} bit/s, the description says {}; ip link set {} type can bitrate {}",
                                     interface.name, interface.bit_per_s, drives.bit_per_s, interface.name,
                                     drives.bit_per_s));
  if (drives.data_bit_per_s != 0 && interface.data_bit_per_s != drives.data_bit_per_s)
    return Status::error(fmt::format("{} sends CAN FD data at {} bit/s, the description says {}; set dbitrate",
                                     interface.name, interface.data_bit_per_s, drives.data_bit_per_s));
  return Status::good();
}

}  // namespace

Result<std::unique_ptr<DriveBus>> DriveSocket::open(const DriveDescription& drives, unsigned bus,
                                                    const std::string& interface) {
  if (interface.starts_with("slcan"))
    return Status::error(interface + " is a serial-line adapter, which sends frames in batches; use another kind");
  const auto found = find_can_interface(interface);
  if (!found.ok()) return found.status();
  const bool fd = codec_of(drives.family).needs_fd;
  if (Status status = check_can_interface(found.value(), fd); !status.ok()) return status;
  if (Status status = check_rates(drives, found.value()); !status.ok()) return status;
  std::vector<can_filter> filters;
  for (const DriveAxis& axis : drives.axes)
    if (axis.bus == bus) filters.push_back(filter_of(drives.family, axis));
  auto made = std::make_unique<DriveSocket>();
  const auto queue = static_cast<unsigned>(std::max<std::size_t>(6, 2 * filters.size()));
  const CanOpenError failed = made->socket_.open(
      {.interface = interface.c_str(), .filters = filters, .errors = kErrors, .fd = fd, .queued_sends = queue});
  if (failed.step != CanOpenError::Step::kNone)
    return Status::error(fmt::format("cannot open {}: {}", interface, std::strerror(failed.number)));
  return std::unique_ptr<DriveBus>(std::move(made));
}

std::int64_t DriveSocket::now_ns() const noexcept { return MonotonicClock::now_ns(); }

bool DriveSocket::receive(ReceivedDriveFrame& received) noexcept {
  if (next_ == count_) {
    int error = 0;
    next_ = 0;
    count_ = socket_.receive(error);
    if (error != 0) connected_ = false;
  }
  while (next_ < count_)
    if (take(socket_.frame(next_++), received)) return true;
  return false;
}

bool DriveSocket::take(const CanReceived& from, ReceivedDriveFrame& received) noexcept {
  if (from.error) {
    if ((from.id & CAN_ERR_BUSOFF) != 0) connected_ = false;
    if ((from.id & CAN_ERR_RESTARTED) != 0) connected_ = true;
    return false;
  }
  connected_ = true;
  received.arrival_ns = from.arrival_ns;
  received.frame = {.id = from.id & CAN_EFF_MASK, .extended = (from.id & CAN_EFF_FLAG) != 0, .fd = from.fd};
  received.frame.size = static_cast<std::uint8_t>(from.data.size());
  std::memcpy(received.frame.data.data(), from.data.data(), from.data.size());
  return true;
}

bool DriveSocket::send(const DriveFrame& frame) noexcept {
  const std::uint32_t id = frame.extended ? frame.id | CAN_EFF_FLAG : frame.id;
  return socket_.send(id, std::as_bytes(frame.bytes()), frame.fd) == 0;
}

Result<DriveBuses> open_drive_sockets(const DriveDescription& drives, const std::vector<std::string>& interfaces) {
  DriveBuses buses;
  for (unsigned bus = 0; bus < interfaces.size(); ++bus) {
    auto opened = DriveSocket::open(drives, bus, interfaces[bus]);
    if (!opened.ok()) return opened.status();
    buses.push_back(std::move(opened).value());
  }
  return buses;
}

}  // namespace tactus::hal
