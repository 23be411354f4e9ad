// A Novint Falcon on its port: a thread exchanges packets with the device, the haptic thread exchanges values with it.
//
// The thread sends the newest request and waits for the answer, again and again: about 1 kHz, the device's own limit.
// If no new request comes for more than kSilent exchanges it sends zeros: a loop that stopped must not leave a force.
// It sends zeros when it ends, too. Thread: open, destructor [setup]; read(), write() [rt]: two atomic exchanges, no
// lock, no system call. Units: SI.
#pragma once

#include <atomic>
#include <memory>

#include "hal/falcon/falcon_logic.h"
#include "hal/falcon/falcon_start.h"
#include "rt/base/latest_value.h"
#include "rt/thread/realtime_thread.h"

namespace tactus::hal {

class FalconDevice {
 public:
  static constexpr unsigned kSilent = 10, kLost = 50;  // exchanges in a row

  // A port whose device runs its firmware and is homed. Missing real-time privileges are no error.
  static Result<std::unique_ptr<FalconDevice>> start(std::unique_ptr<FalconPort> port, double gain_per_Nm,
                                                     std::int64_t period_ns);
  ~FalconDevice();  // zeros are sent before the thread ends
  FalconDevice(const FalconDevice&) = delete;
  FalconDevice& operator=(const FalconDevice&) = delete;

  const haptics::DeviceProperties& properties() const noexcept { return logic_.properties(); }
  void read(haptics::DeviceInput& input) noexcept;
  void write(const haptics::DeviceCommand& command) noexcept;

 private:
  struct Request {
    FalconRequest request;
    std::uint64_t sequence;
  };
  struct Answer {
    FalconState state;
    std::uint64_t echoed;
  };

  FalconDevice(std::unique_ptr<FalconPort> port, double gain_per_Nm, std::int64_t period_ns)
      : port_(std::move(port)), logic_(gain_per_Nm, period_ns) {}
  void publish_request() noexcept;
  void exchange() noexcept;

  std::unique_ptr<FalconPort> port_;
  FalconLogic logic_;
  std::uint64_t echoed_{0};
  LatestValue<Request> requests_;
  LatestValue<Answer> answers_;
  std::atomic<bool> stop_{false}, connected_{true};
  loop::RealtimeThread thread_;  // declared last: it uses the other members
};

static_assert(haptics::HapticDevice<FalconDevice>);

}  // namespace tactus::hal
