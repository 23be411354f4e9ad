// The suite without hardware: the firmware on simulated mechanics behind a link in this process, with switches for the
// faults that a real bench can cause.
//
// Thread: the switches [any]; they act at the next receive(). The rest as in the contract of links; call() only while
// no thread receives.
#pragma once

#include <atomic>

#include "hal/loopback_link.h"
#include "tools/hil/provoke.h"

namespace tactus::hil {

class SimulatedBench {
 public:
  SimulatedBench(const hal::DeviceProfile& profile, std::int64_t period_ns)
      : link_(profile, hal::HandModel{}, period_ns, hal::LoopbackLink::Stamp::kClock) {}

  hal::ReceivedFrame receive(std::span<std::byte, firmware::kMaxFrameSize> buffer) noexcept {
    link_.set_emergency_stop(emergency_stop.load(std::memory_order_relaxed));
    link_.set_plugged(!unplugged.load(std::memory_order_relaxed));
    if (corrupt.load(std::memory_order_relaxed)) link_.corrupt_states(1);
    return link_.receive(buffer);
  }
  bool send(std::span<const std::byte> frame) noexcept { return link_.send(frame); }
  bool connected() const noexcept { return link_.connected(); }
  hal::LinkCounters counters() const noexcept { return link_.counters(); }
  Result<firmware::ServiceMessage> call(const firmware::ServiceMessage& request, std::chrono::milliseconds timeout) {
    return link_.call(request, timeout);
  }

  std::atomic<bool> emergency_stop{false}, unplugged{false}, corrupt{false};
  const hal::LoopbackLink& truth() const noexcept { return link_; }

 private:
  hal::LoopbackLink link_;
};

static_assert(hal::FrameLink<SimulatedBench>);

// Operates the switches of a bench, which must outlive it.
class ProvokeSimulated final : public Provoker {
 public:
  explicit ProvokeSimulated(SimulatedBench& bench) : bench_(bench) {}
  Status set(const std::string& fault, bool on) override {
    std::atomic<bool>* line = fault == "estop"     ? &bench_.emergency_stop
                              : fault == "unplug"  ? &bench_.unplugged
                              : fault == "corrupt" ? &bench_.corrupt
                                                   : nullptr;
    if (line == nullptr) return Status::error("the simulated device has no " + fault);
    line->store(on, std::memory_order_relaxed);
    return Status::good();
  }

 private:
  SimulatedBench& bench_;
};

}  // namespace tactus::hil
