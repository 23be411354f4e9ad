// The last faults, each with what the device did and when: kept over re-arms, lost with the supply.
//
// One entry per entry into BRAKE for a fault (a BRAKE that the host asked for is none), and one when the configuration
// is found bad. Thread: [rt], the control period's. Bound: kCapacity entries; the oldest is overwritten, the total
// tells how many there were.
#pragma once

#include "firmware/encoder.h"
#include "firmware/faults.h"
#include "firmware/protocol.h"

namespace tactus::firmware {

inline constexpr std::uint8_t kNoAxis = 255;

struct FaultEntry {
  Fault fault{Fault::kNone};
  State state_before{State::kReset};
  std::uint8_t axis{kNoAxis};  // the one it was about, if it was about one
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
  // 0 is the newest. An entry that is not there is empty: fault 0.
  FaultEntry entry(unsigned age) const noexcept {
    return age < size() ? entries_[(total_ - 1 - age) % kCapacity] : FaultEntry{};
  }

 private:
  static_assert((kCapacity & (kCapacity - 1)) == 0, "the total may wrap");
  std::array<FaultEntry, kCapacity> entries_{};
  std::uint32_t total_{0};
};

}  // namespace tactus::firmware
