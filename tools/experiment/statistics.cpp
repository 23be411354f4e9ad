#include "tools/experiment/statistics.h"

#include <algorithm>
#include <cmath>

namespace tactus::experiment {

double quantile(std::vector<double> sample, double q) {
  if (sample.empty()) return 0;
  const double rank = std::ceil(q * static_cast<double>(sample.size()));
  const auto index = static_cast<std::ptrdiff_t>(std::clamp(rank - 1, 0.0, static_cast<double>(sample.size() - 1)));
  std::nth_element(sample.begin(), sample.begin() + index, sample.end());
  return sample[static_cast<std::size_t>(index)];
}

double median(const std::vector<double>& sample) {
  if (sample.empty()) return 0;
  std::vector<double> sorted = sample;
  std::sort(sorted.begin(), sorted.end());
  const std::size_t middle = sorted.size() / 2;
  return sorted.size() % 2 == 1 ? sorted[middle] : 0.5 * (sorted[middle - 1] + sorted[middle]);
}

std::vector<double> minimum_by_step(std::span<const std::vector<double>> runs) {
  if (runs.empty()) return {};
  std::vector<double> least = runs.front();
  for (const auto& run : runs.subspan(1)) {
    least.resize(std::min(least.size(), run.size()));
    for (std::size_t i = 0; i < least.size(); ++i) least[i] = std::min(least[i], run[i]);
  }
  return least;
}

double power_law_exponent(std::span<const double> x, std::span<const double> y) {
  double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (std::size_t i = 0; i < std::min(x.size(), y.size()); ++i) {
    if (!(x[i] > 0) || !(y[i] > 0)) continue;
    const double u = std::log(x[i]), v = std::log(y[i]);
    n += 1;
    sx += u;
    sy += v;
    sxx += u * u;
    sxy += u * v;
  }
  const double spread = n * sxx - sx * sx;
  return spread > 1e-12 * std::max(1.0, n * sxx) ? (n * sxy - sx * sy) / spread : 0;
}

}  // namespace tactus::experiment
