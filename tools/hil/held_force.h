// A small force that a device holds while a person reads a scale.
//
// The device is in IDLE except during a push. The force rises and falls at kSlope_N_per_s. It ends at once if the
// device reports a fault, stops answering, or its tool moves by more than kMostMoved_m, because then nothing holds the
// tool.
// Thread: normal; in real time a thread of its own exchanges with the device, set up as requested, until the
// destructor; stepped, the calls do. Frame: the device's. Units: SI.
#pragma once

#include <atomic>
#include <thread>

#include "tools/hil/device_suite.h"

namespace tactus::hil {

class HeldForce {
 public:
  static constexpr double kSlope_N_per_s = 2, kMostMoved_m = 0.02, kSettle_s = 0.3;
  static constexpr unsigned kMostMissing = 10;  // samples in a row

  // `direction`: of unit length.
  HeldForce(DeviceUnderTest& under_test, const Vec3d& direction);
  ~HeldForce();  // the force fades, the device is in IDLE
  HeldForce(const HeldForce&) = delete;
  HeldForce& operator=(const HeldForce&) = delete;

  // Returns when the force is there and has settled; 0 ends it. Error, one line: why there is none.
  Status push(double force_N);
  // Good while nothing has happened since the last push began.
  Status trouble() const;

 private:
  enum class Trouble : std::uint32_t { kNone = 0, kFault = 1, kSilent = 2, kMoved = 3 };

  void tick() noexcept;
  void look() noexcept;
  bool is_there() const noexcept;
  void pass(double seconds);

  DeviceUnderTest& test_;
  Vec3d direction_;
  // Of the exchange.
  haptics::DeviceInput input_;
  haptics::DeviceCommand command_;
  double force_N_{0}, slope_N_{0};  // slope: per period
  unsigned missing_{0};
  bool based_{false};
  Vec3d base_;
  // Between the threads.
  std::atomic<double> wanted_N_{0}, given_N_{0}, moved_m_{0};
  std::atomic<Trouble> trouble_{Trouble::kNone};
  std::atomic<std::uint32_t> fault_{0};
  std::atomic<haptics::DeviceState> state_{haptics::DeviceState::kReset};
  std::atomic<bool> stop_{false};
  std::thread thread_;  // declared last: it uses the other members
};

}  // namespace tactus::hil
