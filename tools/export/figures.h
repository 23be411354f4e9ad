// Figures of a run's columns, such as the root mean square of the force: COLUMN:HOW, of every tick.
//
// HOW: mean, rms, min, max, last, or pN, the N-th percentile (of the sorted values, the one at rank ceil(N / 100 n)).
// Thread: one, normal. Bound: a percentile keeps 8 bytes a tick of its column; the others a constant.
#pragma once

#include <string>
#include <utility>

#include "tools/export/columns.h"

namespace tactus::exporting {

struct Figure {
  enum class How : std::uint32_t { kMean, kRms, kMin, kMax, kLast, kPercentile };

  std::string name;  // as asked for: force_z_N:p99
  Column column;
  How how{How::kMean};
  double percent{0};
};

// Error, one line: no such column or no such figure.
Result<std::vector<Figure>> parse_figures(std::span<const std::string> words);

class Figures {
 public:
  Figures(std::vector<Figure> figures, double period_s);

  void take(const loop::TickRecord& tick);
  // In the order they were asked for; NaN without a tick.
  std::vector<std::pair<std::string, double>> values() const;

 private:
  struct Sums {
    double sum{0}, squares{0}, min{0}, max{0}, last{0};
    std::vector<double> all;  // of a percentile
  };

  std::vector<Figure> figures_;
  std::vector<Sums> sums_;
  double period_s_;
  std::uint64_t ticks_{0};
};

}  // namespace tactus::exporting
