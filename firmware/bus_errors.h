// Error counters of a CAN link's bus, for the registers can_transmit_errors to can_bus_off.
//
// ISO 11898-1: a controller counts errors up by 8 or 1 and good frames down; from 128 it is error passive, with 256
// transmit errors bus-off: it is silent until it is restarted, with both counters at zero. Thread: [any]; values.
#pragma once

#include <concepts>
#include <cstdint>

namespace tactus::firmware {

struct BusErrors {
  std::uint32_t transmit{0}, receive{0};  // the controller's counters, as last reported
  std::uint32_t bus_off{0};               // number of bus-off events since start-up; saturates
  friend constexpr bool operator==(const BusErrors&, const BusErrors&) noexcept = default;
};

// A link that reports bus errors; optional for a DeviceLink.
template <class L>
concept TellsBusErrors = requires(const L link) {
  { link.bus_errors() }
  noexcept->std::same_as<BusErrors>;
};

}  // namespace tactus::firmware
