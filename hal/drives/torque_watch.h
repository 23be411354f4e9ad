// Detects a drive that reports less torque than was commanded: a drive that restarted or timed out may answer as if
// nothing had happened, without any torque.
//
// An answer may belong to a command some periods ago, and the drive filters. So the torque tau of an answer is compared
// with e: of the last six commands, each with and without the drive's own damping, the one of least magnitude; 0 if
// their signs differ. Periods with |e| < kLeastShare range are left out: there the offsets of current sensors may be as
// large. Over the n others, once n >= kPeriods and sum e^2 >= kPeriods (kSureShare range)^2, the drive lacks torque if
//   sum tau e < kReported sum e^2,  kReported = 1/4
// and the sums restart. Thread: [rt], one; constant time. Units: N m, rad/s, of the drive's shaft.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

namespace tactus::hal {

class TorqueWatch {
 public:
  static constexpr unsigned kPeriods = 10;
  static constexpr double kLeastShare = 0.01, kSureShare = 0.02, kReported = 0.25;

  void reset() noexcept { *this = {}; }

  // Once a period: the torque that is commanded now.
  void sent(double torque_Nm) noexcept {
    sent_[newest_] = torque_Nm;
    newest_ = newest_ + 1 < sent_.size() ? newest_ + 1 : 0;
  }

  // Once in each period with an answer. `damping_Nm`: what the drive's own damping adds at the speed that it reports.
  // True: it lacks torque.
  bool lacks(double reported_Nm, double damping_Nm, double range_Nm) noexcept {
    const double expected = least(damping_Nm);
    if (std::abs(expected) < kLeastShare * range_Nm) return false;
    ++periods_;
    reported_ += reported_Nm * expected;
    expected_ += expected * expected;
    const double sure_Nm = kSureShare * range_Nm;
    if (periods_ < kPeriods || expected_ < kPeriods * sure_Nm * sure_Nm) return false;
    const bool lacking = reported_ < kReported * expected_;
    periods_ = 0;
    reported_ = expected_ = 0;
    return lacking;
  }

 private:
  // 0 where the commands, or the damping, differ in sign.
  double least(double damping_Nm) const noexcept {
    double low = sent_[0], high = sent_[0];
    for (const double torque : sent_) {
      low = std::min({low, torque, torque + damping_Nm});
      high = std::max({high, torque, torque + damping_Nm});
    }
    return low > 0 ? low : std::min(high, 0.0);
  }

  std::array<double, 6> sent_{};
  unsigned newest_{0}, periods_{0};
  double reported_{0}, expected_{0};  // sum of reported x expected torque; sum of expected^2
};

}  // namespace tactus::hal
