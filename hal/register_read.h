// Reads one register of a device over a link.
//
// Thread: [setup], [normal]; never the haptic thread. Bound: `patience`.
#pragma once

#include <fmt/format.h>

#include "firmware/registers.h"
#include "hal/frame_link.h"

namespace tactus::hal {

// An error is one line: no reply, or no such register.
template <FrameLink Link>
Result<std::uint32_t> read_register(Link& link, std::uint16_t number, std::uint8_t tag,
                                    std::chrono::milliseconds patience) {
  const firmware::ServiceMessage request{.operation = firmware::Operation::kRead,
                                         .status = firmware::ServiceStatus::kGood,
                                         .tag = tag,
                                         .address = number,
                                         .value = 0};
  const auto reply = link.call(request, patience);
  if (!reply.ok()) return reply.status();
  if (reply.value().status == firmware::ServiceStatus::kGood) return reply.value().value;
  return Status::error(fmt::format("device: register {:#06x} is not there (status {}); update its firmware", number,
                                   static_cast<unsigned>(reply.value().status)));
}

}  // namespace tactus::hal
