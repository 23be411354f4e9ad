// Script of faults that are injected into the simulated device and its link, per tick.
//
// A script is a list, separated by commas, of  kind[/state|/command]@tick[+ticks][:amount]
//   lost            frames sent in these ticks never arrive
//   late:K          frames sent in these ticks arrive K ticks later (1 to 63); a newer frame in that tick replaces them
//   duplicated      the previous frame is sent again instead of the present one
//   corrupted[:N]   N bits of the frame flip (default 1), so that its check fails
//   nan             state: the decoded sample has NaN in position and rotation; command: the wrench has NaN
//   wild            all counts of the state frame are random, its check is valid
//   teleport:X      the first axis' count jumps by what X metres of the tool are at the centre, its check is valid
//   frozen          the device's program hangs: it repeats the same state frame, commands wait, and the motors have no
//                   effort because the timer in the motor bridge expires
//   unplugged       no frame passes and the link reports it; the device keeps running
//   estop           the e-stop line is active
// Ticks count reads, from 0; `+ticks` is the number of ticks, by default 1. Without a direction, lost, late, duplicated
// and corrupted act on both; nan acts on the state. Example: lost@1000+20,teleport@3000:0.3,late/command@7000+100:2
// Thread: parsing [setup]; active() [rt], a loop over at most 64 faults.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "rt/base/result.h"

namespace tactus::hal {

enum class FaultKind : std::uint8_t {
  kLost = 0,
  kLate = 1,
  kDuplicated = 2,
  kCorrupted = 3,
  kNan = 4,
  kWild = 5,
  kTeleport = 6,
  kFrozen = 7,
  kUnplugged = 8,
  kEmergencyStop = 9,
};

enum class FaultDirection : std::uint8_t { kState = 1, kCommand = 2, kBoth = 3 };

inline constexpr unsigned kMaxFaults = 64;
inline constexpr unsigned kMaxLateTicks = 63;

struct InjectedFault {
  FaultKind kind{FaultKind::kLost};
  FaultDirection direction{FaultDirection::kBoth};
  std::uint64_t tick{0}, ticks{1};
  double amount{0};  // ticks for late, bits for corrupted, metres for teleport
};

struct FaultScript {
  std::array<InjectedFault, kMaxFaults> faults{};
  std::uint32_t count{0};

  // The first fault of this kind that acts in this direction at this tick; null if none.
  const InjectedFault* active(FaultKind kind, FaultDirection direction, std::uint64_t tick) const noexcept;
};

// An error is one line: which fault of the list, what is wrong, what is accepted. An empty text is an empty script.
Result<FaultScript> parse_fault_script(std::string_view text);

}  // namespace tactus::hal
