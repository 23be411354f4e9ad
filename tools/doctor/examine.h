// Examines whether this PC is fit for the rate: the checks, their findings, and the remedy of each.
//
// Each check is one function from the system's view to a finding; the table in examine.cpp lists them in the order in
// which they are shown. Green: correct. Amber: works with occasional late wake-ups, or cannot be determined. Red: the
// loop will miss deadlines or will not run. Thread: normal. Changes nothing: the remedies are only printed.
#pragma once

#include <string>
#include <vector>

#include "tools/doctor/system_view.h"

namespace tactus::doctor {

enum class MachineVerdict { kGreen, kAmber, kRed };

struct MachineFinding {
  std::string check;  // one word
  MachineVerdict verdict{MachineVerdict::kGreen};
  std::string found;     // the observed state, one line
  std::string remedy;    // one line; empty: none needed
  std::string commands;  // shell lines printed by --fix; empty: no command can fix it
  bool distorts{false};  // figures taken on this machine will not be representative
};

struct Request {
  int cpu{-1};  // the core of the haptic thread; -1: the last one that this process may use
  double rate_Hz{1000};
  std::vector<std::string> can_interfaces;  // empty: CAN is not used
  bool usb{false};                          // the device is on USB
  bool gpio{false};
};

struct Report {
  int cpu{0};
  std::vector<MachineFinding> findings;
  bool representative() const;  // true: timing figures of this PC represent a dedicated PC
  MachineVerdict worst() const;
};

Report examine(const SystemView& system, const Request& request);

const char* name_of(MachineVerdict verdict);

}  // namespace tactus::doctor
