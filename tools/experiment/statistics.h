// The few statistics that the experiments need. Thread: [any]; pure functions, bounded by the sample.
#pragma once

#include <span>
#include <vector>

namespace tactus::experiment {

// The nearest-rank quantile, q in (0, 1]: the smallest value that at least that share of the sample does not exceed.
// 0 for an empty sample.
double quantile(std::vector<double> sample, double q);
double median(const std::vector<double>& sample);  // the mean of the middle two of an even number

// The least of each step over identical runs: what is left is the program's own, the machine's gaps fall out.
// Runs of different length are cut to the shortest.
std::vector<double> minimum_by_step(std::span<const std::vector<double>> runs);

// The exponent p of y = c x^p by least squares in the logarithms; values at or below 0 are left out. 0 where fewer
// than two different x are left.
double power_law_exponent(std::span<const double> x, std::span<const double> y);

}  // namespace tactus::experiment
