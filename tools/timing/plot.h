// Plots histograms of times: bars in a terminal, or SVG. Both axes are logarithmic, because rare and late ticks matter.
// Thread: normal. Pure.
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

// Plots the share of ticks that took longer than a time, from all ticks down to one. The deadline is a dashed line.
// Above the plot: a sentence with the result, the source of the figures, and the legend. At most four curves may have
// times. Light or dark by the reader's setting.
std::string histogram_svg(const std::string& sentence, const Provenance& made, const std::vector<Curve>& curves,
                          std::int64_t mark_ns);

}  // namespace tactus::timing
