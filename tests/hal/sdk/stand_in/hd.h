// State of the stand-in for 3D Systems' library HD, and its faults. Fields are read and written by the test's thread
// and the library's scheduler: each is atomic by itself.
#pragma once

#include <atomic>

struct HdStandIn {
  std::atomic<unsigned> init_error{0};  // error that hdInitDevice raises
  std::atomic<unsigned> error{0};       // raised at the end of each frame; an error of forces switches them off
  std::atomic<unsigned> calibration{0x5000}, calibrations{0};  // status that is returned; number of updates
  std::atomic<unsigned> calibrations_in_force{0};
  std::atomic<int> rate_Hz{1000}, output_dof{3}, rates_set{0};
  std::atomic<double> largest_force_N{3.3};
  std::atomic<char> version{'3'};
  std::atomic<bool> calls{true}, backwards{false}, refuses_force{false}, forces_on{false}, broken_matrix{false};
  std::atomic<unsigned> blocks_us{0};
  std::atomic<double> glitch_mm{0};  // added to x while it is not 0
  std::atomic<double> turn_rad{0};   // of the stylus about the library's y
  std::atomic<double> hand_y_mm{0};  // end of the spring that holds the mass
  std::atomic<double> force_N[3]{}, torque_mNm[3]{};
  std::atomic<double> position_mm[3]{};
  std::atomic<unsigned> frames{0}, outside_of_frames{0}, disabled{0}, stopped{0};
  std::atomic<bool> frame{false};
};

extern "C" HdStandIn* hd_stand_in();
