// How the suite gets a fault that it cannot cause itself: from a command of the bench's, from the simulated device, or
// from the person in front of it.
//
// Fault names: "estop" (the e-stop is pressed), "unplug" (the device is away), "corrupt" (state frames arrive broken),
// "bus-off" (the CAN controller leaves the bus). A command is run as `COMMAND NAME on` and later `COMMAND NAME off`;
// exit 0: it is so now; anything else: it cannot be done here, and the check is skipped. Thread: normal.
#pragma once

#include <chrono>
#include <memory>
#include <string>

#include "rt/base/result.h"

namespace tactus::hil {

class Provoker {
 public:
  virtual ~Provoker() = default;
  // An error: it cannot be done here, and why.
  virtual Status set(const std::string& fault, bool on) = 0;
  // How long it may take until it is seen.
  virtual std::chrono::seconds patience() const { return std::chrono::seconds(20); }
};

std::unique_ptr<Provoker> provoke_by_command(const std::string& command);
// Asks on standard error. A person cannot corrupt frames or bring a bus down.
std::unique_ptr<Provoker> provoke_by_person();
// Nobody is there: nothing can be provoked.
std::unique_ptr<Provoker> provoke_nothing();

}  // namespace tactus::hil
