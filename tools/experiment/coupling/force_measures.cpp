#include "tools/experiment/coupling/force_measures.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tactus::experiment {

void ForceError::add(std::span<const Vec3d> force, std::span<const Vec3d> reference) {
  for (std::size_t i = 0; i < std::min(force.size(), reference.size()); ++i) {
    error_squared += norm_squared(force[i] - reference[i]);
    reference_squared += norm_squared(reference[i]);
  }
}

void ForceError::add(const ForceError& other) {
  error_squared += other.error_squared;
  reference_squared += other.reference_squared;
}

double ForceError::relative() const { return reference_squared > 0 ? std::sqrt(error_squared / reference_squared) : 0; }

std::vector<double> power_spectrum(std::span<const Vec3d> signal) {
  const std::size_t n = signal.size();
  if (n < 4) return {};
  const double count = static_cast<double>(n);
  Vec3d mean, slope;
  double square = 0;
  for (std::size_t i = 0; i < n; ++i) mean += signal[i] * (1 / count);
  for (std::size_t i = 0; i < n; ++i) {
    const double t = static_cast<double>(i) - 0.5 * (count - 1);
    slope += signal[i] * t;
    square += t * t;
  }
  slope = slope * (1 / square);
  std::vector<Vec3d> left(n);
  std::vector<double> cosine(n), sine(n);
  double window_power = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double t = static_cast<double>(i);
    const double angle = 2 * std::numbers::pi * t / count;
    cosine[i] = std::cos(angle);
    sine[i] = std::sin(angle);
    const double hann = 0.5 * (1 - std::cos(2 * std::numbers::pi * (t + 0.5) / count));
    window_power += hann * hann;
    left[i] = (signal[i] - mean - slope * (t - 0.5 * (count - 1))) * hann;
  }
  std::vector<double> lines(n / 2 + 1);
  for (std::size_t k = 0; k < lines.size(); ++k) {
    Vec3d real, imaginary;
    for (std::size_t i = 0, phase = 0; i < n; ++i, phase = (phase + k) % n) {
      real += left[i] * cosine[phase];
      imaginary += left[i] * sine[phase];
    }
    const double sides = k == 0 || 2 * k == n ? 1 : 2;  // a line includes its negative frequency
    lines[k] = sides * (norm_squared(real) + norm_squared(imaginary)) / (count * window_power);
  }
  return lines;
}

double line_Hz(std::size_t line, std::size_t samples, double rate_Hz) {
  return static_cast<double>(line) * rate_Hz / static_cast<double>(samples);
}

double band_deviation(std::span<const Vec3d> signal, double rate_Hz, double low_Hz, double high_Hz) {
  const std::vector<double> lines = power_spectrum(signal);
  double power = 0;
  for (std::size_t k = 0; k < lines.size(); ++k) {
    const double at_Hz = line_Hz(k, signal.size(), rate_Hz);
    if (at_Hz >= low_Hz * (1 - 1e-9) && at_Hz <= high_Hz * (1 + 1e-9)) power += lines[k];
  }
  return std::sqrt(power);
}

std::vector<double> steps_at(std::span<const Vec3d> force, std::span<const Vec3d> reference,
                             std::span<const std::size_t> ticks) {
  std::vector<double> steps;
  for (const std::size_t k : ticks)
    if (k > 0 && k < std::min(force.size(), reference.size()))
      steps.push_back(norm((force[k] - reference[k]) - (force[k - 1] - reference[k - 1])));
  return steps;
}

std::vector<Vec3d> difference(std::span<const Vec3d> force, std::span<const Vec3d> reference) {
  std::vector<Vec3d> result;
  for (std::size_t i = 0; i < std::min(force.size(), reference.size()); ++i) result.push_back(force[i] - reference[i]);
  return result;
}

}  // namespace tactus::experiment
