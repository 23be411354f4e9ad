// Worst-case CAN bus load of the control frames of can_codec.h.
//
// With worst-case bit stuffing and the three bits between frames, a classic frame of n bytes with an 11-bit
// identifier is 8 n + 47 + (8 n + 33) / 4 bits long: 135 for eight. At 1 Mbit/s a bit is a microsecond.
//   classic, 1 Mbit/s: a period is 3 + 2 frames and a tenth of a status, 688.5 us: 69 % at 1 kHz, which is the rate for
//     classic CAN; 80 % at 1.16 kHz, all of the bus at 1.45 kHz. A service request and its reply take 270 us, fit in
//     addition at 1 kHz (96 %), and use the remaining time since their priority is lowest. A frame already on the bus
//     delays a control frame by at most one frame, 135 us.
//   FD, 1 and 5 Mbit/s: state 169 us, command 137 us: 31 % at 1 kHz, 80 % at 2.6 kHz, all at 3.27 kHz.
//   FD, 1 and 2 Mbit/s: 373 and 293 us: 67 % at 1 kHz, 80 % at 1.2 kHz, all at 1.5 kHz.
// The watchdog is the same on every link: it counts periods without a command, and an incomplete command is none.
// Thread: [any]; constants.
#pragma once

#include "firmware/can_codec.h"

namespace tactus::firmware {

// Bits of one frame with an 11-bit identifier, and the three bits after it.
constexpr std::uint32_t worst_classic_bits(std::uint32_t bytes) noexcept {
  return 8 * bytes + 47 + (8 * bytes + 33) / 4;
}
constexpr std::uint64_t worst_fd_ns(std::uint32_t bytes, std::uint64_t nominal_bit_per_s,
                                    std::uint64_t data_bit_per_s) noexcept {
  // Slow: 17 bits up to the rate switch with 4 stuff bits, 12 after the CRC. Fast: ESI and length, data, their stuff
  // bits, the CRC with its stuff count and fixed stuff bits, its delimiter.
  const std::uint32_t crc_bits = bytes > 16 ? 32 : 27, stuffed = (17 + 5 + 8 * bytes - 1) / 4 - 4;
  const std::uint64_t slow = 17 + 4 + 12, fast = 5 + 8 * bytes + stuffed + crc_bits + 1;
  return slow * 1'000'000'000 / nominal_bit_per_s + fast * 1'000'000'000 / data_bit_per_s;
}
// Bus time of one control period's frames, including a tenth of a status frame. `data_bit_per_s` 0: classic.
constexpr std::uint64_t worst_period_ns(std::uint64_t bit_per_s, std::uint64_t data_bit_per_s) noexcept {
  if (data_bit_per_s > 0)
    return worst_fd_ns(kFdStateSize, bit_per_s, data_bit_per_s) +
           worst_fd_ns(kFdCommandSize, bit_per_s, data_bit_per_s);
  constexpr std::uint64_t frames_in_ten_periods = 10 * (kStateFragments + kCommandFragments) + 1;
  return frames_in_ten_periods * worst_classic_bits(kClassicSize) * 100'000'000 / bit_per_s;
}

}  // namespace tactus::firmware
