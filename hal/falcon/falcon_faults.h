// Faults of a Falcon, by number (hal/host_faults.h). falcon_logic.h raises them. Thread: [any]; constants and a pure
// function.
#pragma once

#include <cstdint>
#include <string_view>

#include "hal/host_faults.h"

namespace tactus::hal {

inline constexpr std::uint32_t kFalconNotHomed = kOfHost | 80;  // an axis lost its place while there was force

// What happened and what to do; empty for a number that is not one of these.
constexpr std::string_view describe_falcon_fault(std::uint32_t fault) noexcept {
  if (fault != kFalconNotHomed) return {};
  return "it does not know the place of an axis any more; pull the grip out fully and push it in fully, then re-arm";
}

}  // namespace tactus::hal
