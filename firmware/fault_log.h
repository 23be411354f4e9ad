// Log of the last faults, each with the device's state and the time: kept over re-arms, lost at power-off.
//
// One entry for each transition to BRAKE by a fault (not for a BRAKE that the host requested), and one when the
// configuration is found invalid. Thread: [rt], the control period's. Bound: kCapacity entries; the oldest is
// overwritten; total() counts all.
#pragma once

#include "firmware/encoder.h"
#include "firmware/faults.h"
#include "firmware/protocol.h"

namespace tactus::firmware {

inline constexpr std::uint8_t kNoAxis = 255;

struct FaultEntry {
  Fault fault{Fault::kNone};
  State state_before{State::kReset};
  std::uint8_t axis{kNoAxis};  // the axis concerned, if any
  std::uint64_t time_us{0};    // device clock
  float value{0.0f};  // overspeed: m/s or rad/s; overheated: K; commands lost: how many; self-test: failed bits
};

class FaultLog {
 public:
  static constexpr unsigned kCapacity = 16;

  void record(const FaultEntry& entry) noexcept {
    entries_[total_ % kCapacity] = entry;
    ++total_;
  }
  std::uint32_t total() const noexcept { return total_; }  // since the start; wraps
  unsigned size() const noexcept { return total_ < kCapacity ? static_cast<unsigned>(total_) : kCapacity; }
  // Age 0 is the newest entry. A missing entry is empty: fault 0.
  FaultEntry entry(unsigned age) const noexcept {
    return age < size() ? entries_[(total_ - 1 - age) % kCapacity] : FaultEntry{};
  }

 private:
  static_assert((kCapacity & (kCapacity - 1)) == 0, "the total may wrap");
  std::array<FaultEntry, kCapacity> entries_{};
  std::uint32_t total_{0};
};

}  // namespace tactus::firmware
