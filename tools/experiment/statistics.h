// Statistics of the experiments. Thread: [any]; pure functions, bounded by the sample.
#pragma once

#include <span>
#include <vector>

namespace tactus::experiment {

// The nearest-rank quantile, q in (0, 1]: the smallest value that at least that share of the sample does not exceed.
// 0 for an empty sample.
double quantile(std::vector<double> sample, double q);
double median(const std::vector<double>& sample);  // the mean of the middle two of an even number

// Minimum of each step over identical runs, to exclude interruptions by the machine.
// Runs of different length are cut to the shortest.
std::vector<double> minimum_by_step(std::span<const std::vector<double>> runs);

// The exponent p of y = c x^p by least squares in the logarithms; values at or below 0 are ignored. 0 if fewer than two
// different x remain.
double power_law_exponent(std::span<const double> x, std::span<const double> y);

}  // namespace tactus::experiment
