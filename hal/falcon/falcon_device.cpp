#include "hal/falcon/falcon_device.h"

#include "rt/base/clock.h"

namespace tactus::hal {
namespace {

using std::chrono::milliseconds;

constexpr unsigned kLastZeros = 3;
constexpr milliseconds kAnswer{5};
constexpr std::int64_t kRest_ns = 1'000'000;

}  // namespace

Result<std::unique_ptr<FalconDevice>> FalconDevice::start(std::unique_ptr<FalconPort> port, double gain_per_Nm,
                                                          std::int64_t period_ns) {
  std::unique_ptr<FalconDevice> device(new FalconDevice(std::move(port), gain_per_Nm, period_ns));
  device->publish_request();
  const auto body = [](void* context) noexcept { static_cast<FalconDevice*>(context)->exchange(); };
  if (Status status = device->thread_.start(256, {.cpu = -1, .priority = 85}, body, device.get()); !status.ok())
    return status;
  return device;
}

FalconDevice::~FalconDevice() {
  stop_.store(true, std::memory_order_relaxed);
  thread_.join();
}

void FalconDevice::read(haptics::DeviceInput& input) noexcept {
  const Answer* fresh = answers_.take();
  if (fresh != nullptr) echoed_ = fresh->echoed;
  logic_.read(fresh != nullptr ? &fresh->state : nullptr, connected_.load(std::memory_order_relaxed), echoed_, input);
  publish_request();  // without a write it fades
}

void FalconDevice::write(const haptics::DeviceCommand& command) noexcept {
  logic_.write(command);
  publish_request();
}

void FalconDevice::publish_request() noexcept {
  requests_.writing() = {logic_.request(), logic_.commanded()};
  requests_.publish();
}

// The thread's body.
void FalconDevice::exchange() noexcept {
  FalconScanner scanner;
  Request newest{};
  unsigned silent = 0, lost = 0;
  while (!stop_.load(std::memory_order_relaxed)) {
    if (const Request* request = requests_.take()) {
      newest = *request;
      silent = 0;
    } else if (++silent > kSilent) {
      newest.request.motors = {};
    }
    FalconState state;
    const bool answered = exchange_falcon(*port_, newest.request, scanner, state, kAnswer);
    lost = answered ? 0 : lost + 1;
    connected_.store(lost < kLost, std::memory_order_relaxed);
    if (!answered) {
      // An unplugged device fails at once: without this sleep the thread would use its core without a pause.
      MonotonicClock::sleep_until_ns(MonotonicClock::now_ns() + kRest_ns);
      continue;
    }
    answers_.writing() = {state, newest.sequence};
    answers_.publish();
  }
  FalconState state;
  for (unsigned i = 0; i < kLastZeros; ++i) (void)exchange_falcon(*port_, {}, scanner, state, kAnswer);
}

}  // namespace tactus::hal
