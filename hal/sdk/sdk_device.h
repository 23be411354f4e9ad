// A device through a maker's library (sdk_port.h): a thread of its own calls the library, the haptic thread exchanges
// values with it.
//
// The thread makes an exchange per period. If no new request comes for kFade periods it lowers the force, at kBrake it
// switches the forces off: a library's own watchdog is fed by this thread, so it would not see a loop that stopped. It
// does so when it ends, too. The age of a sample is the time that an exchange takes, measured at the start, and a
// period: properties().delay_s, for the gain check. A call that takes longer: no fresh sample, and the loop fades.
// Faults: 1 commands lost, 4 not finite (firmware/faults.h), 5 the device switched its forces off.
// Thread: start(), destructor [setup]; read(), write() [rt]: atomic exchanges of values, no lock, no system call.
#pragma once

#include <atomic>
#include <memory>

#include "hal/sdk/sdk_port.h"
#include "rt/base/latest_value.h"
#include "rt/base/result.h"
#include "rt/thread/realtime_thread.h"

namespace tactus::hal {

class SdkDevice {
 public:
  static constexpr unsigned kFade = 3, kBrake = 10, kGone = 50;  // periods in a row
  static constexpr unsigned kTrials = 200;                       // exchanges without force, timed at the start

  // Error: the library refuses exchanges, or they take more than half of a period in the median.
  static Result<std::unique_ptr<SdkDevice>> start(std::unique_ptr<SdkPort> port, std::int64_t period_ns);
  ~SdkDevice();
  SdkDevice(const SdkDevice&) = delete;
  SdkDevice& operator=(const SdkDevice&) = delete;

  const haptics::DeviceProperties& properties() const noexcept { return properties_; }
  void read(haptics::DeviceInput& input) noexcept;
  void write(const haptics::DeviceCommand& command) noexcept;

 private:
  struct Request {
    Wrenchd wrench;
    bool force{false};
    std::uint64_t sequence{0};
  };
  struct Answer {
    SdkState state;
    std::uint64_t echoed{0};
  };

  SdkDevice(std::unique_ptr<SdkPort> port, std::int64_t period_ns);
  Status measure();
  void publish() noexcept;
  void brake(std::uint32_t fault) noexcept;
  void work() noexcept;

  std::unique_ptr<SdkPort> port_;
  std::int64_t period_ns_;
  haptics::DeviceProperties properties_;
  haptics::DeviceSample sample_;
  haptics::DeviceCommand command_;
  haptics::DeviceState state_{haptics::DeviceState::kIdle};
  std::uint32_t fault_{0}, missed_{0};
  std::uint64_t periods_{0};
  LatestValue<Request> requests_;
  LatestValue<Answer> answers_;
  std::atomic<bool> stop_{false}, gone_{false};
  loop::RealtimeThread thread_;  // declared last: it uses the other members
};

static_assert(haptics::HapticDevice<SdkDevice>);

}  // namespace tactus::hal
