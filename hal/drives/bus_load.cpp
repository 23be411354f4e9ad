#include "hal/drives/bus_load.h"

#include <fmt/format.h>

#include <cmath>

#include "hal/drives/drive_codec.h"

namespace tactus::hal {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;

std::int64_t classic_bits(const FrameShape& shape) noexcept {
  const std::int64_t data = 8 * static_cast<std::int64_t>(shape.bytes);
  return shape.extended ? 67 + data + (54 + data - 1) / 4 : 47 + data + (34 + data - 1) / 4;
}

}  // namespace

std::int64_t longest_frame_ns(const FrameShape& shape, std::uint32_t bit_per_s, std::uint32_t data_bit_per_s) noexcept {
  if (!shape.fd) return classic_bits(shape) * kSecond_ns / bit_per_s;
  // Slow: up to the rate switch, 17 or 36 bits and their stuff bits, and 12 after the CRC. Fast: ESI and length, data,
  // their stuff bits, the CRC with its stuff count and fixed stuff bits, its delimiter.
  const std::int64_t data = 8 * static_cast<std::int64_t>(shape.bytes), head = shape.extended ? 36 : 17;
  const std::int64_t head_stuffed = (head - 1) / 4, crc = shape.bytes > 16 ? 32 : 27;
  const std::int64_t slow = head + head_stuffed + 12;
  const std::int64_t fast = 5 + data + (head + 5 + data - 1) / 4 - head_stuffed + crc + 1;
  return slow * kSecond_ns / bit_per_s + fast * kSecond_ns / data_bit_per_s;
}

std::int64_t bus_time_ns(const DriveDescription& drives, unsigned bus) noexcept {
  const DriveCodec& codec = codec_of(drives.family);
  std::int64_t time_ns = 0;
  for (const DriveAxis& axis : drives.axes) {
    if (axis.bus != bus) continue;
    // A moteus answers from an identifier of 29 bits if its number does not fit 11.
    const bool extended_answer = codec.extended_answer || (drives.family == DriveFamily::kMoteus && axis.id >= 8);
    time_ns += longest_frame_ns({codec.command_bytes, codec.extended_command, codec.needs_fd}, drives.bit_per_s,
                                drives.data_bit_per_s);
    time_ns += longest_frame_ns({codec.answer_bytes, extended_answer, codec.needs_fd}, drives.bit_per_s,
                                drives.data_bit_per_s);
  }
  return time_ns;
}

Status check_bus_load(const DriveDescription& drives, std::chrono::nanoseconds period) {
  const auto period_ns = static_cast<double>(period.count());
  double all_ns = 0;
  for (unsigned bus = 0; bus < drives.buses.size(); ++bus) all_ns += static_cast<double>(bus_time_ns(drives, bus));
  for (unsigned bus = 0; bus < drives.buses.size(); ++bus) {
    const auto time_ns = static_cast<double>(bus_time_ns(drives, bus));
    const double load = time_ns / period_ns;
    if (load <= kMaxBusLoad) continue;
    const bool spread_fits = all_ns <= kMaxBuses * kMaxBusLoad * period_ns;
    return Status::error(fmt::format(
        "the drives on {} need {:.0f} us of every {:.0f} us, {:.0f} % of the bus; accepted: up to {:.0f} %, "
        "that is --rate {:.0f} at most{}",
        drives.buses[bus], time_ns * 1e-3, period_ns * 1e-3, 100 * load, 100 * kMaxBusLoad,
        std::floor(kMaxBusLoad * 1e9 / time_ns), spread_fits ? ", or the drives spread over two buses" : ""));
  }
  return Status::good();
}

}  // namespace tactus::hal
