// Histograms of times for the eye: bars in a terminal, a plot as SVG. Both axes are logarithmic: what matters is rare
// and late. Thread: normal. Pure.
#pragma once

#include <string>
#include <vector>

#include "rt/base/histogram.h"
#include "tools/version/provenance.h"

namespace tactus::timing {

struct Curve {
  std::string name;
  const Histogram* times{nullptr};
};

// Times in bins of 1, 2, 5, 10 ... us, a column of bars for each curve, with the counts. `mark_ns`: a deadline.
std::string histogram_text(const std::vector<Curve>& curves, std::int64_t mark_ns);

// The share of the ticks that took longer than the time: falls from all to one tick. The deadline is a dashed line.
// Above: the sentence that says what came out, where the figures come from, and the legend. At most four curves have
// times; light or dark as the reader's screen.
std::string histogram_svg(const std::string& sentence, const Provenance& made, const std::vector<Curve>& curves,
                          std::int64_t mark_ns);

}  // namespace tactus::timing
