// Error measures of a commanded force, tick by tick, relative to a reference force.
//
// Pure functions. Thread: [any]; allocate. Units: SI. Bound: linear in the number of samples; spectra: quadratic.
#pragma once

#include <span>
#include <vector>

#include "rt/base/spatial.h"

namespace tactus::experiment {

// Sums over windows, for RMS(F - F_ref) / RMS(F_ref).
struct ForceError {
  double error_squared{0}, reference_squared{0};

  void add(std::span<const Vec3d> force, std::span<const Vec3d> reference);
  void add(const ForceError& other);
  double relative() const;  // 0 if there was no force
};

// The power of a signal by frequency [N^2 per line]: the linear trend is removed and a Hann window applied. Line
// k is k / (n T); the sum over the lines is the variance, over x, y and z together.
std::vector<double> power_spectrum(std::span<const Vec3d> signal);

// The lines' frequencies of a spectrum of n samples at `rate_Hz`.
double line_Hz(std::size_t line, std::size_t samples, double rate_Hz);

// Standard deviation of the signal between two frequencies, both included [N].
double band_deviation(std::span<const Vec3d> signal, double rate_Hz, double low_Hz, double high_Hz);

// |step of F - F_ref| from each of `ticks` - 1 to it: the reference's own step is caused by the hand's motion.
std::vector<double> steps_at(std::span<const Vec3d> force, std::span<const Vec3d> reference,
                             std::span<const std::size_t> ticks);

std::vector<Vec3d> difference(std::span<const Vec3d> force, std::span<const Vec3d> reference);

}  // namespace tactus::experiment
