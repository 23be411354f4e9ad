// State of the stand-in for Force Dimension's library, and its faults. Fields are read and written by the test's thread
// and the library's: each is atomic by itself.
#pragma once

#include <atomic>

struct StandIn {
  std::atomic<int> count{1}, type{33}, result{0};  // result: of a reading; 1: the old sample again, -1: an error
  std::atomic<bool> in_use{false}, initialised{true}, wrist{false}, gone{false}, refuses_force{false};
  std::atomic<unsigned> blocks_us{0};
  std::atomic<bool> forces_on{false};
  std::atomic<unsigned> stops{0}, closed{0}, exchanges{0};
  std::atomic<int> time_guard_us{-1}, watchdog_steps{-1}, serial_asked{-1};
  std::atomic<int> major{3}, minor{17};
  std::atomic<bool> says_nothing{false};    // returns no text where the interface has one
  std::atomic<bool> refuses_expert{false};  // refuses expert mode, watchdog and time guard
  std::atomic<bool> hangs{false};           // a reading does not return until this is false
  std::atomic<double> turn_rad{0};
  std::atomic<double> hand_z_m{0};  // end of the spring that holds the mass
  std::atomic<double> force_N[6]{};
  double position_m[3]{}, speed_m_per_s[3]{};  // used by the library's thread only
};

extern "C" StandIn* stand_in();
