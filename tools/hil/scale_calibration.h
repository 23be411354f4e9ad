// The force gain of a device from pushes onto a kitchen scale: how hard to push next, and what the readings say.
//
// A device whose motor values per N m are `used` gives used / true of the force that is commanded. Each push is chosen
// so that the scale should show the next of kPushes_N, by what it has shown so far: the first one is the smallest, for
// the gain may be far off. The slope of measured over commanded forces is used / true; an offset, such as dry friction,
// does not enter it. Thread: normal; pure. Units: N; readings as text in g.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace tactus::hil {

// What a person typed as a reading: "51", "51.5", "51,5", with or without "g". Nullopt: it is no number from -100 to
// 5000.
std::optional<double> parse_grams(const std::string& text);

struct GainResult {
  double gain_per_Nm{0};
  double spread{0};    // largest distance of a reading from the line, as a share of the largest force
  double offset_N{0};  // that the line has at no command
  std::string doubt;   // why the result is rejected; empty: accepted
};

class ScaleCalibration {
 public:
  static constexpr std::array<double, 4> kPushes_N{0.5, 1.0, 1.5, 2.0};
  // Others have 2300 to 10000; beyond this something else is wrong.
  static constexpr double kLeastGain = 1500, kMostGain = 15000;
  static constexpr double kWeight_N_per_g = 9.80665e-3;

  // `used`: the gain that the device works with now.
  ScaleCalibration(double used_per_Nm, double peak_N) : used_per_Nm_(used_per_Nm), peak_N_(peak_N) {}

  bool done() const noexcept { return points_.size() == kPushes_N.size(); }
  // Precondition: not done().
  double next_command_N() const noexcept;
  // What the scale showed more than without force. The doubt for which no further push is made; empty: go on.
  std::string take(double measured_N);
  // Precondition: done(). `drift_N`: what the scale shows afterwards, without force, more than before.
  GainResult result(double drift_N) const;

 private:
  struct Point {
    double commanded_N, measured_N;
  };
  // `share`: of the limits, for a single reading, in which friction counts.
  static std::string doubt_of(double gain_per_Nm, double share);

  double used_per_Nm_, peak_N_;
  std::vector<Point> points_;
};

}  // namespace tactus::hil
