// What a link over a CAN bus knows of the bus' errors, for the registers can_transmit_errors to can_bus_off.
//
// ISO 11898-1: a controller counts errors up by 8 or 1 and good frames down; from 128 it is error passive, with 256
// transmit errors bus-off: it is silent until it is restarted, with both counters at zero. Thread: [any]; values.
#pragma once

#include <concepts>
#include <cstdint>

namespace tactus::firmware {

struct BusErrors {
  std::uint32_t transmit{0}, receive{0};  // the controller's counters, as it told last
  std::uint32_t bus_off{0};               // times, since the start; saturates
  friend constexpr bool operator==(const BusErrors&, const BusErrors&) noexcept = default;
};

// A link that knows; every other need not say anything.
template <class L>
concept TellsBusErrors = requires(const L link) {
  { link.bus_errors() }
  noexcept->std::same_as<BusErrors>;
};

}  // namespace tactus::firmware
