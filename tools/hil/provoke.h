// Causes faults that the suite cannot cause itself: by a command of the bench, by the simulated device, or by the
// operator.
//
// Fault names: "estop" (the e-stop is pressed), "unplug" (the device is away), "corrupt" (state frames arrive broken),
// "bus-off" (the CAN controller leaves the bus). A command is run as `COMMAND NAME on` and later `COMMAND NAME off`;
// exit 0: done; any other status: not possible here, and the check is skipped. Thread: normal.
#pragma once

#include <chrono>
#include <memory>
#include <string>

#include "rt/base/result.h"

namespace tactus::hil {

class Provoker {
 public:
  virtual ~Provoker() = default;
  // Error: why it is not possible here.
  virtual Status set(const std::string& fault, bool on) = 0;
  // Time until the fault must be observed.
  virtual std::chrono::seconds patience() const { return std::chrono::seconds(20); }
};

std::unique_ptr<Provoker> provoke_by_command(const std::string& command);
// Asks the operator on standard error. "corrupt" and "bus-off" are not possible.
std::unique_ptr<Provoker> provoke_by_person();
// Without an operator: no fault can be caused.
std::unique_ptr<Provoker> provoke_nothing();

}  // namespace tactus::hil
