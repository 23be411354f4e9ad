// How much of a CAN bus one period of an arm of drives takes: the frames with the most stuff bits that they can have.
//
// Counted are one command and one answer per drive, from start of frame to the end of the three bits after it.
// Formulas: ISO 11898-1; a classic frame of n bytes has 47 + 8 n bits with an 11-bit identifier, 67 + 8 n with 29 bits,
// and a stuff bit after four in the worst case. Thread: [setup].
#pragma once

#include <chrono>

#include "hal/drives/drive_axis.h"
#include "rt/base/result.h"

namespace tactus::hal {

inline constexpr double kMaxBusLoad = 0.9;

struct FrameShape {
  unsigned bytes{8};
  bool extended{false}, fd{false};
};

// ns, with the most stuff bits. `data_bit_per_s`: used by CAN FD frames alone.
std::int64_t longest_frame_ns(const FrameShape& shape, std::uint32_t bit_per_s, std::uint32_t data_bit_per_s) noexcept;

// ns: what one period takes on this bus.
std::int64_t bus_time_ns(const DriveDescription& drives, unsigned bus) noexcept;

// Refuses a bus that would be loaded above kMaxBusLoad. Error, one line: the load, and the largest rate that fits.
Status check_bus_load(const DriveDescription& drives, std::chrono::nanoseconds period);

}  // namespace tactus::hal
