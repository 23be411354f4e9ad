#include "tools/hil/device_exchange.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>

#include "hal/device_words.h"
#include "tools/caught.h"

namespace tactus::hil {

using haptics::DeviceState;
using haptics::ReadStatus;

DeviceExchange::DeviceExchange(DeviceUnderTest& under_test) : test(under_test) {
  if (!test.options.stepped) thread_ = std::thread([this] { work(); });
}

DeviceExchange::~DeviceExchange() {
  stop_.store(true, std::memory_order_relaxed);
  if (thread_.joinable()) thread_.join();
}

void DeviceExchange::work() {
  thrown_ = caught([this] {
    loop::CpuAwake awake;
    setup = loop::setup_realtime(test.options.setup, awake);
    const auto period = std::chrono::nanoseconds(std::llround(1e9 / test.options.rate_Hz));
    for (auto deadline = std::chrono::steady_clock::now(); !stop_.load(std::memory_order_relaxed);) {
      // A wake-up that is late makes no burst of reads afterwards, which would find nothing new.
      deadline = std::max(deadline + period, std::chrono::steady_clock::now());
      std::this_thread::sleep_until(deadline);
      Job* const job = job_.load();
      if (job == nullptr) {
        repeat();
        continue;
      }
      pass(*job);
      if (job->done < job->periods) continue;
      job_.store(nullptr);
      job_.notify_one();
    }
  });
  ended_.store(true);
  job_.store(nullptr);
  job_.notify_one();
}

void DeviceExchange::repeat() {
  test.device.read(unread_);
  held_.sequence = ++sequence_;
  test.device.write(held_);
}

void DeviceExchange::pass(Job& job) {
  test.device.read(input);
  const bool is_fresh = input.status == ReadStatus::kFresh;
  fresh += is_fresh;
  silent = is_fresh ? 0 : silent + 1;
  if (job.tick) job.tick(job.done);
  ++job.done;
  if (job.writes) {
    lost = lost || (silent >= kGonePeriods && command.wanted == DeviceState::kForce);
    if (lost) {
      command.wanted = DeviceState::kBrake;
      command.wrench = {};
    }
    command.sequence = ++sequence_;
    test.device.write(command);
  }
  held_ = command;
  held_.wrench = {};
}

void DeviceExchange::check_thread() const {
  if (!ended_.load()) return;
  throw std::runtime_error(thrown_.ok() ? "the exchange has ended" : thrown_.message());
}

void DeviceExchange::run(unsigned periods, const Tick& tick, bool writes) {
  Job job{periods, tick, writes};
  if (periods == 0) return;
  if (test.options.stepped) {
    while (job.done < periods) pass(job);
    return;
  }
  job_.store(&job);
  if (ended_.load()) job_.store(nullptr);
  job_.wait(&job);
  check_thread();
}

DeviceState DeviceExchange::want(DeviceState wanted, unsigned periods) {
  command.wanted = wanted;
  run(periods);
  return input.sample.state;
}

unsigned DeviceExchange::patience() const {
  return 8 + 2 * static_cast<unsigned>(std::lround(test.device.properties().delay_s * test.options.rate_Hz));
}

void DeviceExchange::rearm() {
  command.wrench = {};
  command.rearm = 0;
  want(DeviceState::kIdle, 2);
  command.rearm = 1;
  run(2);
  command.rearm = 0;
  run(patience());
}

std::string DeviceExchange::silence() const {
  const std::string why = test.trouble ? test.trouble() : std::string();
  return "the device sends no samples, or few" + (why.empty() ? why : ": " + why);
}

std::string DeviceExchange::settle() {
  lost = false;
  command.wrench = {};
  command.rearm = 0;
  fresh = 0;
  if (want(DeviceState::kIdle, patience()) == DeviceState::kBrake) rearm();
  if (fresh < kLeastFresh * patience()) return silence();
  if (input.sample.state == DeviceState::kIdle && input.sample.device_fault == 0) return {};
  return fmt::format("the device is in {}; {}", hal::name_of(input.sample.state),
                     hal::describe_device_fault(input.sample.device_fault));
}

}  // namespace tactus::hil
