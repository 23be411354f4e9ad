// Reads the controller's error counters from Linux CAN error frames.
//
// Drivers send one when the controller's error state changes, not with every error, so the counters may change between
// two of them. Thread: [rt]; pure, bounded. Source: linux/can/error.h. With a driver that reports no counters (no
// CAN_ERR_CNT) they stay unchanged, except that a restart zeroes them.
#pragma once

#include <linux/can/error.h>

#include <cstddef>
#include <limits>
#include <span>

#include "firmware/bus_errors.h"

namespace tactus::firmware {

// `id` is the error frame's, without CAN_ERR_FLAG.
inline void take_bus_errors(std::uint32_t id, std::span<const std::byte> data, BusErrors& errors) noexcept {
  if ((id & CAN_ERR_CNT) != 0 && data.size() >= 8) {
    errors.transmit = std::to_integer<std::uint32_t>(data[6]);
    errors.receive = std::to_integer<std::uint32_t>(data[7]);
  }
  if ((id & CAN_ERR_BUSOFF) != 0 && errors.bus_off < std::numeric_limits<std::uint32_t>::max()) ++errors.bus_off;
  if ((id & CAN_ERR_RESTARTED) != 0) errors.transmit = errors.receive = 0;
}

}  // namespace tactus::firmware
