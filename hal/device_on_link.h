// Owns a link and the device on it, and counts the frames that came over the link.
//
// The device numbers its state frames. Lost frames are the numbers between the first and the newest one seen that were
// not received fresh, corrupt or superseded. Thread: construction, link(), link_report() [setup] and by the owner after
// the loop has ended; read(), write() [rt]: the link's bound, and one clock read.
#pragma once

#include <memory>
#include <utility>

#include "hal/any_link.h"
#include "hal/linked_device.h"
#include "rt/base/clock.h"
#include "rt/base/histogram.h"

namespace tactus::hal {

// Counts of one run. Every frame that the device numbered is counted in fresh, corrupt, link.superseded,
// link.malformed or lost.
struct LinkReport {
  LinkCounters link;
  LinkedDeviceCounters reads;
  std::uint64_t lost{0};  // state frames, from gaps in the device's numbers
  Histogram force_age;    // ns, from a sample's arrival to the command computed from it
};

template <FrameLink Link>
class DeviceOnLink {
 public:
  DeviceOnLink(const DeviceProfile& profile, std::int64_t period_ns, std::unique_ptr<Link> link)
      : link_(std::move(link)), device_(profile, period_ns, *link_) {}

  Status start() { return start_link(*link_); }

  const haptics::DeviceProperties& properties() const noexcept { return device_.properties(); }

  void read(haptics::DeviceInput& input) noexcept {
    device_.read(input);
    if (input.status != haptics::ReadStatus::kFresh) return;
    const std::uint64_t sequence = input.sample.sequence;
    if (first_sequence_ == kNone || sequence < first_sequence_) first_sequence_ = newest_sequence_ = sequence;
    newest_sequence_ = std::max(newest_sequence_, sequence);
  }

  void write(const haptics::DeviceCommand& command) noexcept {
    device_.write(command);
    if (device_.newest_arrival_ns() > 0) force_age_.record(MonotonicClock::now_ns() - device_.newest_arrival_ns());
  }

  Link& link() const noexcept { return *link_; }

  LinkReport link_report() const noexcept {
    const LinkedDeviceCounters& reads = device_.counters();
    const std::uint64_t numbered = first_sequence_ == kNone ? 0 : newest_sequence_ - first_sequence_ + 1;
    const std::uint64_t accounted = reads.fresh + reads.corrupt + reads.superseded;
    return {link_->counters(), reads, numbered > accounted ? numbered - accounted : 0, force_age_};
  }

 private:
  static constexpr std::uint64_t kNone = ~std::uint64_t{0};

  std::unique_ptr<Link> link_;  // before the device, which points at it
  LinkedDevice<Link> device_;
  std::uint64_t first_sequence_{kNone}, newest_sequence_{0};
  Histogram force_age_;
};

}  // namespace tactus::hal
