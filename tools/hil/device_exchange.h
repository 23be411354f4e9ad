// The exchange of `tactus hil` with a device without tactus' wire: one read and one write per period.
//
// In real time a separate thread makes the exchange from construction to destruction without a gap: between two runs it
// repeats the last command without force, because a drive that receives no commands ends its force by itself. In
// stepped mode run() makes it. After ten periods without a sample while FORCE is wanted, BRAKE is wanted without force
// until settle(), as in a run of tactus.
// Thread: normal, by one; the ticks of run() are called in the exchange's thread, while run() waits.
#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <thread>

#include "tools/hil/device_suite.h"

namespace tactus::hil {

class DeviceExchange {
 public:
  static constexpr unsigned kGonePeriods = 10;  // without a sample, in a row
  static constexpr double kLeastFresh = 0.5;    // share of periods with a sample, below which a device is silent
  using Tick = std::function<void(unsigned period)>;

  explicit DeviceExchange(DeviceUnderTest& under_test);
  ~DeviceExchange();
  DeviceExchange(const DeviceExchange&) = delete;
  DeviceExchange& operator=(const DeviceExchange&) = delete;

  // Calls `tick` between read and write of each period; without `writes` the commands are left out.
  void run(unsigned periods, const Tick& tick = {}, bool writes = true);
  haptics::DeviceState want(haptics::DeviceState wanted, unsigned periods);
  // Periods within which a device must react to a command: both ways of the link, and the steps of its start.
  unsigned patience() const;
  void rearm();
  // Brings the device to IDLE without fault. Returns an empty line, or why it is not there.
  std::string settle();
  // One line for a device whose samples are missing, with the reason if it is known.
  std::string silence() const;

  DeviceUnderTest& test;
  // Of the last run; not to be touched by another thread during one.
  haptics::DeviceInput input;
  haptics::DeviceCommand command;
  unsigned silent{0}, fresh{0};  // periods without a sample, in a row; those with one, counted by who resets it
  bool lost{false};              // samples did not come while FORCE was wanted; until the next settle()
  loop::SetupReport setup;

 private:
  struct Job {
    unsigned periods{0};
    const Tick& tick;
    bool writes{true};
    unsigned done{0};
  };

  void pass(Job& job);
  void repeat();
  void work();
  void check_thread() const;

  // Of the exchange's thread.
  haptics::DeviceInput unread_;
  haptics::DeviceCommand held_;  // between two runs
  std::uint64_t sequence_{0};
  Status thrown_ = Status::good();
  std::atomic<Job*> job_{nullptr};
  std::atomic<bool> stop_{false}, ended_{false};
  std::thread thread_;  // declared last: it uses the other members
};

}  // namespace tactus::hil
