// Is this PC fit for the rate? What the doctor looks at, what it found, and the cure of each finding.
//
// Each check is one function from the system's view to a finding; the table in examine.cpp lists them in the order in
// which they are shown. Green: as it should be. Amber: works, with late wake-ups now and then, or cannot be told. Red:
// the loop will miss deadlines, or will not run. Thread: normal. Nothing is changed: the cures are printed.
#pragma once

#include <string>
#include <vector>

#include "tools/doctor/system_view.h"

namespace tactus::doctor {

enum class Verdict { kGreen, kAmber, kRed };

struct Finding {
  std::string check;  // one word
  Verdict verdict{Verdict::kGreen};
  std::string found;     // what is so, in one line
  std::string cure;      // one line; empty where nothing needs one
  std::string commands;  // what --fix prints: shell lines; empty where no command cures it
  bool distorts{false};  // figures taken on this machine will not be representative
};

struct Request {
  int cpu{-1};  // the core of the haptic thread; -1: the last one that this process may use
  double rate_Hz{1000};
  std::string can_interface;  // empty: CAN is not used
  bool usb{false};            // the device is on USB
  bool gpio{false};
};

struct Report {
  int cpu{0};
  std::vector<Finding> findings;
  bool representative() const;  // are figures taken here those of a dedicated PC?
  Verdict worst() const;
};

Report examine(const SystemView& system, const Request& request);

const char* name_of(Verdict verdict);

}  // namespace tactus::doctor
