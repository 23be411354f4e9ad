#include "tools/experiment/coupling/force_measures.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

using namespace tactus;
using namespace tactus::experiment;

namespace {

std::vector<Vec3d> sine(double amplitude_N, double at_Hz, std::size_t ticks = 200) {
  std::vector<Vec3d> signal;
  for (std::size_t i = 0; i < ticks; ++i)
    signal.push_back({0, amplitude_N * std::sin(2 * std::numbers::pi * at_Hz * 1e-3 * static_cast<double>(i)), 0});
  return signal;
}

}  // namespace

TEST_CASE("A force that is a tenth too large everywhere has an error of a tenth") {
  const auto reference = sine(2, 5);
  auto force = reference;
  for (Vec3d& f : force) f = f * 1.1;
  ForceError error;
  error.add(force, reference);
  CHECK(error.relative() == Approx(0.1).epsilon(1e-12));
  CHECK(ForceError{}.relative() == 0);
}

TEST_CASE("A sine within the band has its amplitude over the root of two, one below it nothing") {
  CHECK(band_deviation(sine(0.3, 100), 1000, 20, 500) == Approx(0.3 / std::numbers::sqrt2).epsilon(0.01));
  CHECK(band_deviation(sine(0.3, 5), 1000, 20, 500) < 0.3 * 0.01);
}

TEST_CASE("A slow drift of the force is no vibration") {
  std::vector<Vec3d> drift;
  for (int i = 0; i < 200; ++i) drift.push_back({0.01 * i, 3 - 0.02 * i, 1});
  CHECK(band_deviation(drift, 1000, 20, 500) < 1e-12);
}

TEST_CASE("The lines of a spectrum add up to the variance, and the highest is where the sine is") {
  const auto lines = power_spectrum(sine(0.3, 125));
  CHECK(std::accumulate(lines.begin(), lines.end(), 0.0) == Approx(0.5 * 0.3 * 0.3).epsilon(0.01));
  const auto highest = static_cast<std::size_t>(std::max_element(lines.begin(), lines.end()) - lines.begin());
  CHECK(line_Hz(highest, 200, 1000) == 125);
}

TEST_CASE("Steps at a synchronisation are those that the reference does not make") {
  std::vector<Vec3d> reference(20), force(20);
  for (std::size_t i = 10; i < 20; ++i) {
    reference[i] = {1, 0, 0};
    force[i] = {1.25, 0, 0};
  }
  const std::vector<std::size_t> ticks{5, 10};
  CHECK(steps_at(force, reference, ticks) == std::vector<double>{0, 0.25});
}
